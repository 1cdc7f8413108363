#include "core/warp.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

constexpr int kSamples = 100000;
constexpr int kMembers = 5;

Vec2 random_pair(std::uint32_t test, int i) {
  return Sampler(SamplerKind::independent, test, 0, static_cast<std::uint32_t>(i)).next2();
}

TEST(Warp, DiskIsUniformByArea) {
  // Squared radius and angle of a uniform disc are independent and uniform.
  const auto polar = [](int i) {
    const Vec2 d = square_to_disk(random_pair(1, i));
    return Vec2{d.x * d.x + d.y * d.y, (std::atan2(d.y, d.x) + kPi) / (2 * kPi)};
  };
  expect_fit(chi_squared_square(
                 polar, [](Vec2) { return 1.0f; }, kSamples, 20, 40)
                 .p_value,
             kMembers, "disk");
}

TEST(Warp, DiskKeepsItsRimAndCentre) {
  for (int i = 0; i < 10000; ++i) {
    const Vec2 d = square_to_disk(random_pair(2, i));
    EXPECT_LE(d.x * d.x + d.y * d.y, 1 + 1e-6f);
  }
  const Vec2 centre = square_to_disk({0.5f, 0.5f});
  EXPECT_EQ(centre.x, 0);
  EXPECT_EQ(centre.y, 0);
}

TEST(Warp, CosineHemisphere) {
  const auto result =
      chi_squared_sphere([](int i) -> std::optional<Vec3> { return square_to_cosine_hemisphere(random_pair(3, i)); },
                         [](Vec3 w) { return cosine_hemisphere_pdf(w.z); }, kSamples);
  EXPECT_NEAR(result.integral, 1, 1e-4);
  expect_fit(result.p_value, kMembers, "cosine hemisphere");
}

TEST(Warp, Sphere) {
  const auto result =
      chi_squared_sphere([](int i) -> std::optional<Vec3> { return square_to_sphere(random_pair(4, i)); },
                         [](Vec3) { return kUniformSpherePdf; }, kSamples);
  EXPECT_NEAR(result.integral, 1, 1e-4);
  expect_fit(result.p_value, kMembers, "sphere");
}

TEST(Warp, Triangle) {
  // Uniform on the triangle x, y >= 0, x + y <= 1: folding its upper half over gives a uniform parallelogram only if
  // the halves are alike; instead, the share below x + y <= s must be s^2, and x / (x + y) uniform.
  const auto shape = [](int i) {
    const Vec2 w = square_to_triangle(random_pair(6, i));
    const float sum = w.x + w.y;
    return Vec2{sum * sum, sum > 0 ? w.x / sum : 0.5f};
  };
  expect_fit(chi_squared_square(
                 shape, [](Vec2) { return 1.0f; }, kSamples, 32, 32)
                 .p_value,
             kMembers, "triangle");
}

}  // namespace
}  // namespace glowworm
