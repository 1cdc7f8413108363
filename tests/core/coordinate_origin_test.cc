#include "core/coordinate_origin.h"

#include <gtest/gtest.h>

namespace glowworm {
namespace {

TEST(CoordinateOrigin, IsNearWhatLiesFarAway) {
  EXPECT_EQ(origin_for({-1, -1, -1}, {1, 1, 1}), (Vec3{0, 0, 0}));
  EXPECT_EQ(origin_for({1000, 99, -1}, {1001, 100, 1}), (Vec3{1000.5f, 0, 0})) << "along each axis alone";
  EXPECT_EQ(origin_for({5e6, 5e6, 0}, {6e6, 6e6, 0}), (Vec3{0, 0, 0})) << "a wide land";
}

TEST(CoordinateOrigin, ReadsOnceMoreWhereItMoves) {
  int reads = 0;
  const auto read = [&](double at, CoordinateOrigin& origin) {
    return read_near(origin, [&] {
      ++reads;
      origin.cover({at + 1, NAN, 0});
      return origin.take({at, 0, 0}).x + 0 * origin.take({at + 1, 0, 0}).x;
    });
  };
  CoordinateOrigin near, far, broken;
  EXPECT_EQ(read(3.25, near), 3.25f);
  EXPECT_EQ(reads, 1);
  EXPECT_NEAR(read(5412345.125, far), -0.5, 0.51);
  EXPECT_EQ(reads, 3);
  EXPECT_EQ(far.origin().x, 5412345.5f);
  EXPECT_THROW(read_near(broken, []() -> int { throw Error("bad"); }), Error);
}

TEST(CoordinateOrigin, MapsInDoublesKeepDigits) {
  const TransformDouble there{{0, 1, 0}, {-1, 0, 0}, {0, 0, 2}, {5412345.125, 7, 0.001}};
  const TransformDouble both = there * inverse(there);
  EXPECT_NEAR(both.translation.x, 0, 1e-8);
  EXPECT_NEAR(both.z.z, 1, 1e-15);
  EXPECT_EQ(there.relative_to({5412345, 0, 0}).translation.x, 0.125f);
  EXPECT_EQ(there.determinant(), 2);
}

}  // namespace
}  // namespace glowworm
