#include "density/radius.h"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(SlowRadius, HoldsAboutKPhotonsOnAFloor) {
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

/// Photons of equal density on the five walls of an open box of side 1, whose coordinates across the wall differ by
/// rounding, as those of hits on triangles do.
PhotonBatch box_photons(std::size_t count, std::uint32_t seed = 3) {
  PhotonBatch photons;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    const int wall = static_cast<int>(i % 5), across = wall / 2;
    Vec3 position, normal;
    position[across] = wall % 2 == 0 ? 0.001f : 0.999f;
    const float other_way = sampler.next1() < 0.5f ? -1.0f : 2.0f;
    if (sampler.next1() < 0.6f) position[across] = std::nextafter(position[across], other_way);
    position[(across + 1) % 3] = u.x;
    position[(across + 2) % 3] = u.y;
    normal[across] = wall % 2 == 0 ? 1.0f : -1.0f;
    photons.push_back(position, normal, RGB(1.0f), normal);
  }
  return photons;
}

TEST(Radius, HoldsAboutKPhotonsOnWallsThatAreFlatToRounding) {
  constexpr std::size_t kPhotons = 50'000;
  const float expected = std::sqrt(50.0f / (kPhotons / 5 * kPi));
  double squares = 0;
  for (const float r : per_photon_radii(box_photons(kPhotons), 50)) squares += (r / expected) * (r / expected);
  EXPECT_NEAR(squares / kPhotons, 1.0, 0.05);
}

TEST(Radius, IsTheSameInCornersWhereFewPhotonsOfALeafShareASurface) {
  constexpr std::size_t kPhotons = 5000;
  constexpr std::uint32_t kSeeds = 200;
  const float even = std::sqrt(50.0f / (kPhotons / 5 * kPi));
  double corners = 0, in_corners = 0, middles = 0, in_middles = 0;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const PhotonBatch photons = box_photons(kPhotons, seed);
    const std::vector<float> radii = per_photon_radii(photons, 50);
    for (std::size_t i = 0; i < kPhotons; ++i) {
      const Vec3 p = photons.position[i];
      const auto is_near_edge = [&](float x) { return std::min(x, 1 - x) < 0.7f * even; };
      const double squared = double{radii[i]} * radii[i];
      if (is_near_edge(p.x) && is_near_edge(p.y) && p.z < 0.7f * even) {
        corners += squared;
        ++in_corners;
      } else if (!is_near_edge(p[(i % 5 / 2 + 1) % 3]) && !is_near_edge(p[(i % 5 / 2 + 2) % 3])) {
        middles += squared;
        ++in_middles;
      }
    }
  }
  EXPECT_NEAR(corners / in_corners / (middles / in_middles), 1, 0.03);
}

/// Photons of equal density on a floor (side 0), the wall that meets it at x = 0 (1) and the floor's underside (2).
PhotonBatch corner_photons(std::size_t count_each) {
  PhotonBatch photons;
  for (std::size_t i = 0; i < 3 * count_each; ++i) {
    Sampler sampler(SamplerKind::independent, 2, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    const int side = static_cast<int>(i % 3);
    const Vec3 position = side == 0 ? Vec3{u.x, u.y, 0} : side == 1 ? Vec3{0, u.y, u.x} : Vec3{u.x, u.y, -0.001f};
    const Vec3 normal = side == 0 ? Vec3{0, 0, 1} : side == 1 ? Vec3{1, 0, 0} : Vec3{0, 0, -1};
    photons.push_back(position, normal, RGB(1.0f), normal);
  }
  return photons;
}

TEST(Radius, IsNotHalvedWhereWallsMeetOrThroughThinOnes) {
  constexpr std::size_t kCount = 10000;
  constexpr std::uint32_t kWanted = 50;
  const std::vector<float> radii = per_photon_radii(corner_photons(kCount), kWanted);
  const float expected = std::sqrt(kWanted / (kCount * kPi));
  double sum = 0, lowest = 10, highest = 0;
  for (const float r : radii) {
    sum += r / expected;
    lowest = std::min(lowest, double(r / expected));
    highest = std::max(highest, double(r / expected));
  }
  EXPECT_NEAR(sum / double(radii.size()), 1, 0.05);
  EXPECT_GT(lowest, 0.6);
  EXPECT_LT(highest, 1.7);
}

TEST(Radius, FollowsTheDensity) {
  // The density falls along x as kCount / (2 sqrt(x)).
  PhotonBatch photons;
  constexpr std::size_t kCount = 40000;
  for (std::size_t i = 0; i < kCount; ++i) {
    Sampler sampler(SamplerKind::independent, 3, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    photons.push_back({u.x * u.x, u.y, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  }
  const std::vector<float> radii = per_photon_radii(photons, 50);
  double sum = 0, squares = 0, number = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const float x = photons.position[i].x;
    if (x < 0.02f || x > 0.98f) continue;
    const double ratio = radii[i] / std::sqrt(50 / (kPi * kCount * 0.5f / std::sqrt(x)));
    sum += ratio;
    squares += (ratio - 1) * (ratio - 1);
    ++number;
  }
  EXPECT_NEAR(sum / number, 1, 0.03);
  EXPECT_LT(std::sqrt(squares / number), 0.12);
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

TEST(Radius, OfLightAroundAFocusFollowsItsOwnDensity) {
  // Nine photons of ten lie in a spot of 2 cm, the others all over the floor.
  PhotonBatch photons;
  constexpr std::size_t kSpread = 4000;
  for (std::size_t i = 0; i < 10 * kSpread; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    const float scale = i < kSpread ? 1 : 0.01f;
    photons.push_back({1 + scale * (3 * u.x - 1), 1 + scale * (2 * u.y - 1), 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  }
  const std::vector<float> radii = per_photon_radii(photons, 25);
  const double own = std::sqrt(25 * 6 / (kPi * kSpread));
  double sum = 0, number = 0;
  for (std::size_t i = 0; i < kSpread; ++i) {
    const Vec3 p = photons.position[i];
    if (std::abs(p.x - 1) < 0.2f && std::abs(p.y - 1) < 0.2f) continue;
    sum += radii[i] / own;
    ++number;
  }
  EXPECT_NEAR(sum / number, 1, 0.05);
}

TEST(Radius, FewPhotonsCloseTogetherDoNotShineAsSpecks) {
  PhotonBatch photons = floor_photons(5000);
  for (int i = 0; i < 5; ++i) {
    photons.push_back({1 + 1e-5f * float(i % 2), 1 + 1e-5f * float(i), 0.001f}, {0, 0, -1}, RGB(1.0f), {0, 0, -1});
  }
  const std::vector<float> radii = per_photon_radii(photons, 50);
  for (std::size_t i = 5000; i < radii.size(); ++i) EXPECT_GE(radii[i], 0.24f * fixed_radius(photons, 50));
}

}  // namespace
}  // namespace glowworm
