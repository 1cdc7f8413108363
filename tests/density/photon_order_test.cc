// Photons in the order of space.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "points/photon_batch.h"

namespace glowworm {
namespace {

double way_through(const LargeVector<Vec3>& points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += static_cast<double>(length(points[i] - points[i - 1]));
  return sum;
}

TEST(PhotonOrder, PhotonsOfACellLieTogether) {
  PhotonBatch photons;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 7, i);
    const Vec2 a = sampler.next2(), b = sampler.next2();
    photons.push_back({4 * a.x, a.y, b.x}, {0, 0, 1}, RGB(static_cast<float>(i)), {0, 0, 1});
  }
  const std::vector<std::uint32_t> places = places_by_cell(photons.position);
  const PhotonBatch ordered = photons.moved(places);
  ASSERT_EQ(ordered.size(), photons.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(ordered.position[places[i]], photons.position[i]);
    EXPECT_EQ(ordered.flux[places[i]], photons.flux[i]);
  }
  EXPECT_LT(way_through(ordered.position), 0.2 * way_through(photons.position));
  std::vector<std::uint32_t> sorted = places;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
}

TEST(PhotonOrder, MovingStopsWhenInterrupted) {
  PhotonBatch photons;
  photons.resize(100);
  const std::vector<std::uint32_t> places = places_by_cell(photons.position);
  Interrupt interrupt;
  const CancellationScope scope(interrupt);
  EXPECT_EQ(photons.moved(places).size(), 100u);
  interrupt.request();
  EXPECT_THROW(photons.moved(places), Cancelled);
}

TEST(PhotonOrder, EveryPhotonHasAPlace) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(places_by_cell({}).empty());
  const std::vector<Vec3> odd = {{kNan, 0, 0}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1}};
  std::vector<std::uint32_t> places = places_by_cell(odd);
  EXPECT_LT(places[1], places[3]);
  std::sort(places.begin(), places.end());
  EXPECT_EQ(places, std::vector<std::uint32_t>({0, 1, 2, 3}));
}

}  // namespace
}  // namespace glowworm
