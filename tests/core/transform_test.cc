#include "core/transform.h"

#include <gtest/gtest.h>

#include "core/frame.h"
#include "core/random.h"
#include "core/transform_double.h"
#include "core/warp.h"

namespace glowworm {
namespace {

void expect_near(Vec3 a, Vec3 b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

Vec3 random_direction(std::uint32_t i) { return square_to_sphere(Sampler(SamplerKind::independent, 6, 0, i).next2()); }

Transform random_transform(std::uint32_t i) {
  return {random_direction(4 * i) * 2, random_direction(4 * i + 1) * 0.5f, random_direction(4 * i + 2),
          random_direction(4 * i + 3) * 10};
}

TEST(Frame, IsOrthonormalAndRightHanded) {
  std::vector<Vec3> normals = {{0, 0, 1}, {0, 0, -1}, {0, -0.0f, 1}, {1, 0, 0}, {0, 1, 0}};
  for (std::uint32_t i = 0; i < 1000; ++i) normals.push_back(random_direction(i));
  normals.push_back(normalize({1e-6f, 0, -1}));
  for (const Vec3 n : normals) {
    const Frame f = Frame::from_normal(n);
    EXPECT_NEAR(length(f.s), 1, 2e-6f);
    EXPECT_NEAR(length(f.t), 1, 2e-6f);
    EXPECT_NEAR(dot(f.s, f.n), 0, 2e-6f);
    EXPECT_NEAR(dot(f.t, f.n), 0, 2e-6f);
    expect_near(cross(f.s, f.t), f.n, 2e-6f);
    const Vec3 v = {0.3f, -2, 5};
    expect_near(f.to_world(f.to_local(v)), v, 2e-5f);
  }
}

/// Splits a place as readers of files do: into floats, and what their rounding leaves.
[[gnu::noinline]] void split(const Vec3d& place, Vec3& rounded, Vec3& rest) {
  rounded = narrow(place);
  rest = narrow(place - Vec3d(rounded));
}

TEST(TransformDouble, RoundingLeavesItsRemainder) {
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Vec3d place = Vec3d(random_direction(i)) * 5123.4512345;
    Vec3 rounded, rest;
    split(place, rounded, rest);
    EXPECT_LT(length(place - Vec3d(rounded) - Vec3d(rest)), 1e-10);
  }
}

TEST(Transform, InverseUndoes) {
  int tested = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Transform m = random_transform(i);
    if (std::abs(m.determinant()) < 0.1f) continue;
    ++tested;
    const Vec3 p = random_direction(i + 5000) * 3;
    expect_near(inverse(m).point(m.point(p)), p, 2e-4f);
    expect_near((inverse(m) * m).point(p), p, 2e-4f);
  }
  EXPECT_GT(tested, 100);
}

TEST(Transform, ProductAppliesTheRightFactorFirst) {
  const Transform a = random_transform(1), b = random_transform(2);
  const Vec3 p = {1, 2, 3};
  expect_near((a * b).point(p), a.point(b.point(p)), 1e-4f);
  expect_near((a * b).vector(p), a.vector(b.vector(p)), 1e-4f);
}

TEST(Transform, NormalStaysAcrossTheSurfaceAndOnItsSide) {
  int mirrored = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Transform m = random_transform(i);
    if (std::abs(m.determinant()) < 0.1f) continue;
    mirrored += m.determinant() < 0;
    const Vec3 n = random_direction(i + 9000);
    const Frame f = Frame::from_normal(n);
    const Vec3 mapped = normalize(m.normal(n));
    EXPECT_NEAR(dot(mapped, normalize(m.vector(f.s))), 0, 1e-4f);
    EXPECT_NEAR(dot(mapped, normalize(m.vector(f.t))), 0, 1e-4f);
    // What stood on the side of n still does.
    EXPECT_GT(dot(mapped, m.vector(n)), 0);
  }
  EXPECT_GT(mirrored, 20);
}

}  // namespace
}  // namespace glowworm
