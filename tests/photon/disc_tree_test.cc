// The tree over discs against a loop over all of them.
#include "points/disc_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "core/random.h"
#include "core/warp.h"

namespace glowworm {
namespace {

TEST(DiscTree, FindsTheDiscsThatARayCrossesFromTheFront) {
  std::uint32_t drawn = 0;
  const auto number = [&] { return to_unit_float(hash_combine(7, drawn++)); };
  const auto unit = [&] {
    const float z = 2 * number() - 1, turn = 2 * kPi * number(), r = std::sqrt(1 - z * z);
    return Vec3{r * std::cos(turn), r * std::sin(turn), z};
  };
  std::vector<Disc> discs;
  for (int i = 0; i < 500; ++i)
    discs.push_back({{4 * number(), 4 * number(), 4 * number()}, unit(), 0.05f + 0.4f * number()});
  const DiscTree tree(discs);
  std::size_t crossings = 0;
  for (int ray = 0; ray < 500; ++ray) {
    const Vec3 origin{4 * number(), 4 * number(), 4 * number()};
    // Some rays run along an axis, and some have no end.
    const Vec3 direction = ray % 5 == 0 ? Vec3{0, ray % 2 ? 1.0f : -1.0f, 0} : unit();
    const float length = ray % 3 == 0 ? std::numeric_limits<float>::infinity() : 3 * number();
    std::set<std::uint32_t> expected, found;
    for (std::uint32_t i = 0; i < discs.size(); ++i) {
      const float facing = dot(direction, discs[i].normal);
      const float distance = dot(discs[i].center - origin, discs[i].normal) / facing;
      const Vec3 place = origin + direction * distance;
      if (facing < 0 && distance >= 0 && distance <= length &&
          length_squared(place - discs[i].center) < discs[i].radius * discs[i].radius)
        expected.insert(i);
    }
    tree.for_crossed(origin, direction, length, [&](const DiscCrossing& c) {
      EXPECT_TRUE(found.insert(c.disc).second) << "found once";
      EXPECT_NEAR(length_squared(origin + direction * c.distance - discs[c.disc].center), c.radius_squared, 1e-5f);
      return true;
    });
    EXPECT_EQ(found, expected);
    crossings += found.size();
  }
  EXPECT_GT(crossings, 200u);
  DiscTree().for_crossed({0, 0, 0}, {0, 0, 1}, 1, [](const DiscCrossing&) -> bool { throw 1; });
}

}  // namespace
}  // namespace glowworm
