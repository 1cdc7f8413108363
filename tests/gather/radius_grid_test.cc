// Photon radii at places without photons.
#include "gather/radius_grid.h"

#include <gtest/gtest.h>

#include <vector>

namespace glowworm {
namespace {

/// Photons on a floor 10 m wide but for a hole 2 m wide in its middle, as beneath a piece of furniture, and one far up
/// that makes the box high.
RadiusGrid floor_with_hole(float radius) {
  std::vector<Vec3> positions{{5, 5, 10}};
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      const Vec3 p{(x + 0.5f) / 20, (y + 0.5f) / 20, 0};
      if (p.x > 4 && p.x < 6 && p.y > 4 && p.y < 6) continue;
      positions.push_back(p);
    }
  return RadiusGrid(positions, std::vector<float>(positions.size(), radius));
}

/// Photons at the rim of the hole count for what lies within it: a gather ray that ends there has to know.
TEST(RadiusGrid, ReachesIntoPlacesWithoutPhotons) {
  const RadiusGrid grid = floor_with_hole(0.5f);
  EXPECT_FLOAT_EQ(grid.radius({4.3f, 5, 0}), 0.5f);
  EXPECT_FLOAT_EQ(grid.radius({5, 5.7f, 0}), 0.5f);
  EXPECT_EQ(grid.radius({5, 5, 0}), 0);
  EXPECT_EQ(grid.radius({2, 2, 5}), 0);
  EXPECT_FLOAT_EQ(floor_with_hole(1.5f).radius({5, 5, 0}), 1.5f);
}

}  // namespace
}  // namespace glowworm
