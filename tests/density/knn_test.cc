// Nearest-neighbour photon mapping against brute force.
#include "density/knn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "density/density_scenes.h"

namespace glowworm::density_tests {
namespace {

constexpr float kMinCosine = 0.7f;

std::vector<float> brute_distances(const PhotonBatch& photons, Vec3 x, Vec3 normal, std::size_t k, float limit) {
  std::vector<float> distances;
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const float d2 = length_squared(photons.position[i] - x);
    if (dot(photons.normal[i], normal) > kMinCosine && d2 < limit) distances.push_back(d2);
  }
  std::sort(distances.begin(), distances.end());
  if (distances.size() > k) distances.resize(k);
  return distances;
}

std::vector<float> map_distances(const PhotonMap& map, Vec3 x, Vec3 normal, std::size_t k, float limit) {
  std::vector<std::uint64_t> heap(k);
  std::uint64_t tested = 0;
  const std::size_t count = map.nearest(x, normal, kMinCosine, k, limit, heap, tested);
  std::vector<float> distances;
  for (std::size_t i = 0; i < count; ++i) distances.push_back(PhotonMap::unpack(heap[i]).distance_squared);
  std::sort(distances.begin(), distances.end());
  return distances;
}

void expect_same_distances(const PhotonBatch& photons, const QueryPoints& points) {
  PhotonMap map;
  map.build(photons, photons.flux, {});
  for (const std::size_t k : {1, 2, 7, 50, 1000}) {
    for (const float limit : {std::numeric_limits<float>::infinity(), 0.01f}) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(map_distances(map, points.position[i], points.normal[i], k, limit),
                  brute_distances(photons, points.position[i], points.normal[i], k, limit))
            << k << " " << limit << " " << i;
      }
    }
  }
}

TEST(Knn, FindsTheSameSortedDistancesAsBruteForce) {
  expect_same_distances(room_photons(5000), room_queries(40));
  expect_same_distances(room_photons(1), room_queries(20));
  expect_same_distances(room_photons(600), room_queries(20));
}

TEST(Knn, FindsTheSameDistancesFarOutside) {
  QueryPoints points;
  for (int i = 0; i < 20; ++i) add_query(points, {-float(i), 5.0f * float(i), 1000}, {0, 0, 1});
  expect_same_distances(room_photons(3000), points);
}

TEST(Knn, FindsTheSameDistancesAmongFlatStraightAndCoincidentPhotons) {
  for (int dimensions = 0; dimensions < 3; ++dimensions) {
    PhotonBatch photons;
    QueryPoints points;
    const PhotonBatch places = room_photons(2000);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3 p{dimensions > 0 ? places.position[i].x : 0.25f, dimensions > 1 ? places.position[i].y : 0.25f, 0.25f};
      add_photon(photons, p, {0, 0, 1});
      if (i % 100 == 0) add_query(points, p + Vec3{0, 0.01f, 0.1f}, {0, 0, 1});
    }
    expect_same_distances(photons, points);
  }
}

RadiusPolicy nearest(std::uint32_t k, float max_radius = 0, KernelShape kernel = KernelShape::epanechnikov) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  policy.k = k;
  policy.max_radius = max_radius;
  policy.kernel = kernel;
  return policy;
}

TEST(Knn, GivesTheRadianceOfBruteForce) {
  const PhotonBatch photons = room_photons(3001);
  const QueryPoints points = room_queries(211);
  for (const KernelShape kernel : kKernelShapes) {
    for (const std::uint32_t k : {1u, 5u, 50u, 9000u}) {
      // The one nearest photon lies at the rim, where all kernels but these two are zero.
      if (k == 1 && kernel != KernelShape::box && kernel != KernelShape::gaussian) continue;
      for (const float max_radius : {0.0f, 0.05f}) {
        const RadiusPolicy policy = nearest(k, max_radius, kernel);
        EXPECT_LT(largest_difference(run("knn", photons, policy, points), run("brute", photons, policy, points)), 1e-5)
            << int(kernel) << " " << k << " " << max_radius;
      }
    }
  }
}

TEST(Knn, IsFiniteForEmptyAndCoincidentAndSinglePhotons) {
  PhotonBatch photons;
  QueryPoints points;
  add_query(points, {0, 0, 0}, {0, 0, 1});
  add_query(points, {0, 0, 0.5f}, {0, 0, 1});
  EXPECT_EQ(run("knn", photons, nearest(5), points)[0], RGB(0.0f));
  for (const int count : {1, 10, 100}) {
    while (photons.size() < std::size_t(count)) add_photon(photons, {0, 0, 0}, {0, 0, 1});
    const RadiusPolicy policy = nearest(20, 0, KernelShape::box);
    const std::vector<RGB> values = run("knn", photons, policy, points);
    EXPECT_EQ(values[0], RGB(0.0f));  // all photons at the point: no radius
    EXPECT_LT(largest_difference(values, run("brute", photons, policy, points)), 1e-5);
  }
}

TEST(Knn, EstimatesEvenIrradiance) {
  // A grid of 100 by 100 photons on a square metre, 1 W in all, leaves a white wall as 1 / pi W sr^-1 m^-2.
  PhotonBatch photons;
  QueryPoints points;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      add_photon(photons, {(float(x) + 0.5f) / 100, (float(y) + 0.5f) / 100, 0}, {0, 0, 1}, RGB(1e-4f));
    }
  }
  for (int i = 0; i < 400; ++i) {
    add_query(points, {0.3f + 0.0211f * float(i % 20), 0.3f + 0.0197f * float(i / 20), 0}, {0, 0, 1}, RGB(1.0f));
  }
  double mean = 0;
  for (const RGB& value : run("knn", photons, nearest(400), points)) mean += value.g / 400;
  EXPECT_NEAR(mean * kPi, 1, 0.005);
}

TEST(Knn, GivesTheSameBitsForAnyNumberOfThreads) {
  const PhotonBatch photons = room_photons(60000);
  const QueryPoints points = room_queries(5000);
  set_thread_count(1);
  const std::vector<RGB> one = run("knn", photons, nearest(50), points);
  for (const int threads : {2, 3}) {
    set_thread_count(threads);
    EXPECT_TRUE(one == run("knn", photons, nearest(50), points)) << threads;
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace glowworm::density_tests
