#include "density/radius.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {
namespace {

PhotonBatch floor_photons(std::size_t count) {
  PhotonBatch photons;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    photons.push_back({u.x * 3, u.y * 2, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  }
  return photons;
}

/// Mean over the photons of how many lie within the photon's radius, of those whose disc stays on the floor.
double mean_count(const PhotonBatch& photons, const std::vector<float>& radii) {
  double sum = 0, number = 0;
  for (std::size_t i = 0; i < photons.size(); i += 17) {
    const Vec3 p = photons.position[i];
    const float r = radii[i];
    if (p.x < r || p.x > 3 - r || p.y < r || p.y > 2 - r) continue;
    for (const Vec3& q : photons.position) sum += length_squared(q - p) < r * r ? 1 : 0;
    ++number;
  }
  return sum / number;
}

TEST(Radius, HoldsAboutKPhotonsOnAFloor) {
  const PhotonBatch photons = floor_photons(20000);
  for (const std::uint32_t k : {20u, 50u, 100u}) {
    const std::vector<float> radii = per_photon_radii(photons, k);
    EXPECT_NEAR(mean_count(photons, radii) / k, 1.0, 0.1) << k;
    // Even density: the spread of the radii is small too.
    const float expected = std::sqrt(6.0f * k / (20000 * kPi));
    double squares = 0;
    for (const float r : radii) squares += (r / expected - 1) * (r / expected - 1);
    EXPECT_LT(std::sqrt(squares / radii.size()), 0.12) << k;
    EXPECT_NEAR(fixed_radius(photons, k) / expected, 1.0, 0.05);
  }
}

TEST(Radius, IsTheSameForAnyNumberOfThreads) {
  const PhotonBatch photons = floor_photons(50000);
  set_thread_count(1);
  const std::vector<float> one = per_photon_radii(photons, 50);
  set_thread_count(2);
  EXPECT_EQ(one, per_photon_radii(photons, 50));
  set_thread_count(0);
}

TEST(Radius, IsPositiveAndFiniteForOddBatches) {
  PhotonBatch photons;
  EXPECT_TRUE(per_photon_radii(photons, 50).empty());
  EXPECT_GT(fixed_radius(photons, 50), 0);
  const auto check = [&] {
    const std::vector<float> radii = per_photon_radii(photons, 50);
    ASSERT_EQ(radii.size(), photons.size());
    for (const float r : radii) EXPECT_TRUE(std::isfinite(r) && r > 0);
  };
  photons.push_back({1, 2, 3}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  check();
  for (int i = 0; i < 200; ++i) photons.push_back({1, 2, 3}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  check();
  for (int i = 0; i < 200; ++i) photons.push_back({float(i), 2, 3}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  check();
}

TEST(Radius, LonePhotonsAreCapped) {
  PhotonBatch photons = floor_photons(5000);
  photons.push_back({1000, 0, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  const std::vector<float> radii = per_photon_radii(photons, 50);
  EXPECT_LE(radii.back(), 8.001f * fixed_radius(photons, 50));
}

}  // namespace
}  // namespace glowworm
