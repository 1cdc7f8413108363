// Light paths in the arrays of the scattering kernel: results match those of the surface itself.
#include "photon/diffuse_hits.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "builtin/builtin.h"
#include "core/random.h"
#include "core/shading_light.h"
#include "core/warp.h"
#include "scene/surface.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

/// Rays from the middle of a scene to all sides, and what they hit.
struct Shots {
  static constexpr std::size_t kCount = 1000;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<float> numbers;  // serves as flux, roulette and square

  explicit Shots(const Tracer& tracer) : hits(kCount), numbers(kCount + kDiffuseScatterPadding) {
    for (std::uint32_t i = 0; i < kCount; ++i) {
      numbers[i] = to_unit_float(hash32(i));
      const Vec2 u{to_unit_float(hash_combine(i, 1)), to_unit_float(hash_combine(i, 2))};
      rays.push_back({tracer.scene().center(), 0, square_to_sphere(u), std::numeric_limits<float>::infinity()});
    }
    tracer.intersect(rays, hits, RayOrder::incoherent);
  }
  ArrivedPaths paths() const {
    ArrivedPaths out;
    out.roulette = numbers.data();
    out.square[0] = out.square[1] = numbers.data();
    for (const float*& channel : out.flux) channel = numbers.data();
    return out;
  }
};

class DiffuseHitsOf : public testing::TestWithParam<const char*> {};

TEST_P(DiffuseHitsOf, MatchDiffusePoint) {
  const Scene scene(builtin_scene(GetParam()));
  const Tracer tracer(scene);
  const Shots shots(tracer);
  const auto block = std::make_unique<DiffuseHits>();
  std::size_t served = 0;
  for (std::size_t first = 0; first < Shots::kCount; first += DiffuseHits::kBlock) {
    const std::size_t count = std::min(DiffuseHits::kBlock, Shots::kCount - first);
    block->scatter(scene, shots.rays, shots.hits, first, count, shots.paths());
    for (std::size_t i = 0; i < count; ++i) {
      const Hit& hit = shots.hits[first + i];
      const Vec3 back = -shots.rays[first + i].direction;
      EXPECT_EQ(block->back(i), back);
      if (hit.triangle == kNone) {
        EXPECT_EQ(block->outcome(i), 0u);
        EXPECT_FALSE(block->left_over(i));
        continue;
      }
      DiffusePoint point;
      Vec3 shading;
      const bool diffuse = diffuse_point(scene, hit.triangle, hit.barycentric, point) &&
                           diffuse_shading_normal(scene, hit.triangle, hit.barycentric, point, shading);
      const bool black = diffuse && is_black(point.reflectance);
      ASSERT_EQ(block->left_over(i), !diffuse && !black);
      if (!diffuse || black) continue;
      ++served;
      const float side = dot(point.geometric_normal, back) < 0 ? -1.0f : 1.0f;
      const float factor = arrival_factor(side * dot(shading, back), side * dot(point.geometric_normal, back),
                                          dot(shading, point.geometric_normal));
      ASSERT_EQ(block->outcome(i) & kPhotonLeft, factor > 0 ? kPhotonLeft : 0u);
      if (!(factor > 0)) continue;
      EXPECT_EQ(block->position(i), point.position);
      EXPECT_EQ(block->normal(i), face_forward(point.geometric_normal, back));
      const float flux = shots.numbers[first + i];
      EXPECT_EQ(block->photon_flux(i).r, flux * factor);
      if (!(block->outcome(i) & kPathGoesOn)) {
        EXPECT_TRUE(is_black(block->flux(i)));
      }
    }
  }
  EXPECT_GT(served, 100u);
}

INSTANTIATE_TEST_SUITE_P(Builtin, DiffuseHitsOf, testing::Values("cornell", "ajar", "glass-sphere", "furnace-sphere"),
                         scene_test_name);

}  // namespace
}  // namespace glowworm
