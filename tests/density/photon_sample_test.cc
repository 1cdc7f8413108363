#include "density/photon_sample.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "density/density_scenes.h"

namespace glowworm {
namespace {

constexpr std::size_t kTargets = 20;

/// Query points with weights, several for each target.
QueryPoints points_of(std::uint32_t seed) {
  QueryPoints points = density_tests::room_queries(200, seed);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.gather_point[i] = static_cast<std::uint32_t>(i % kTargets);
    points.weight[i] = RGB(0.5f + 0.01f * static_cast<float>(i), 1, 0.25f);
  }
  return points;
}

PhotonSample room_sample(std::size_t count) {
  PhotonSample out;
  out.photons = density_tests::room_photons(count);
  out.policy.radii.assign(count, 0.3f);
  for (std::uint32_t i = 0; i < count; ++i) {
    out.policy.radii[i] += 0.001f * static_cast<float>(i);
    if (i % 3 == 0) out.policy.cuts.push_back({i, {KernelCut{{1, 0, 0}, 0.05f}, KernelCut{}}});
  }
  return out;
}

/// What one photon adds to the targets.
std::vector<RGB> shares(const PhotonSample& sample, std::uint32_t photon, const QueryPoints& points) {
  const PhotonSample one = sample_of(sample.photons, sample.photons.flux, sample.policy, {photon});
  const std::vector<RGB> found = density_tests::run("brute", one.photons, one.policy, points);
  std::vector<RGB> out(kTargets);
  for (std::size_t i = 0; i < points.size(); ++i) out[points.gather_point[i]] += points.weight[i] * found[i];
  return out;
}

TEST(PhotonSample, SumsTheProductsOfWhatEachPhotonAddsToBothSets) {
  PhotonSample sample = room_sample(150);
  sample.each = 3;
  const QueryPoints first = points_of(5), second = points_of(6);
  std::vector<RGB> expected(kTargets);
  for (std::uint32_t photon = 0; photon < sample.photons.size(); ++photon) {
    const std::vector<RGB> a = shares(sample, photon, first), b = shares(sample, photon, second);
    for (std::size_t i = 0; i < kTargets; ++i) expected[i] += a[i] * b[i] * sample.each;
  }
  const std::vector<RGB> found = variance_by_photons(sample, first, second, kTargets);
  EXPECT_LT(density_tests::largest_difference(found, expected), 1e-4);
}

TEST(PhotonSample, HasTheSameVarianceForAnyThreads) {
  const PhotonSample sample = room_sample(2000);
  const QueryPoints first = points_of(5), second = points_of(6);
  const std::vector<RGB> found = variance_by_photons(sample, first, second, kTargets);
  const int threads = thread_count();
  set_thread_count(3);
  EXPECT_TRUE(variance_by_photons(sample, first, second, kTargets) == found);
  set_thread_count(threads);
}

TEST(PhotonSample, OfNoPhotonsOrPointsHasNone) {
  const QueryPoints points = points_of(5);
  for (const RGB& v : variance_by_photons({}, points, points, kTargets)) EXPECT_TRUE(is_black(v));
  for (const RGB& v : variance_by_photons(room_sample(10), {}, {}, kTargets)) EXPECT_TRUE(is_black(v));
}

}  // namespace
}  // namespace glowworm
