#include "density/query_radii.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace glowworm {
namespace {

/// Photons on a floor and on its underside, and points between them.
struct Floor {
  PhotonBatch photons;
  QueryPoints points;

  Floor() {
    for (std::uint32_t i = 0; i < 2000; ++i) {
      Sampler sampler(SamplerKind::independent, 1, 1, i);
      const Vec2 u = sampler.next2();
      const Vec3 normal{0, 0, i % 2 == 0 ? 1.0f : -1.0f};
      photons.push_back({u.x, u.y, 0}, normal, RGB(1.0f), normal);
      if (i < 40) points.push_back({u.y, u.x, 0}, {0, 0, 1}, RGB(1.0f), RGB(1.0f), 0);
    }
  }

  /// Distances of point i to the photons that count there, in increasing order, with their numbers.
  std::vector<std::pair<float, std::uint32_t>> distances(std::size_t i) const {
    std::vector<std::pair<float, std::uint32_t>> out;
    for (std::uint32_t j = 0; j < photons.size(); j += 2)
      out.emplace_back(length(photons.position[j] - points.position[i]), j);
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST(QueryRadii, AreThoseOfTheNearestPhotonThatCounts) {
  const Floor floor;
  RadiusPolicy policy;
  for (std::size_t j = 0; j < floor.photons.size(); ++j) policy.radii.push_back(0.2f + 0.0001f * static_cast<float>(j));
  std::vector<RGB> lit(floor.points.size(), RGB(1.0f));
  lit[7] = RGB(0.0f);
  const std::vector<float> radii =
      QueryRadii(floor.photons, policy).at(floor.points.position, floor.points.normal, lit);
  for (std::size_t i = 0; i < radii.size(); ++i)
    EXPECT_EQ(radii[i], i == 7 ? 0 : policy.radii[floor.distances(i)[0].second]) << i;
}

TEST(QueryRadii, AreTheDistanceOfTheLastOfTheNearestPhotons) {
  const Floor floor;
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  policy.k = 30;
  const std::vector<RGB> lit(floor.points.size(), RGB(1.0f));
  const std::vector<float> radii =
      QueryRadii(floor.photons, policy).at(floor.points.position, floor.points.normal, lit);
  for (std::size_t i = 0; i < radii.size(); ++i) EXPECT_FLOAT_EQ(radii[i], floor.distances(i)[29].first) << i;
  // Where fewer lie within the limit, the estimate has the limit as its radius.
  policy.max_radius = 0.04f;
  for (const float radius : QueryRadii(floor.photons, policy).at(floor.points.position, floor.points.normal, lit))
    EXPECT_EQ(radius, 0.04f);
}

TEST(QueryRadii, AreTheOneRadiusOfAll) {
  const Floor floor;
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = 0.1f;
  const std::vector<RGB> lit(floor.points.size(), RGB(1.0f));
  for (const float radius : QueryRadii(floor.photons, policy).at(floor.points.position, floor.points.normal, lit))
    EXPECT_EQ(radius, 0.1f);
}

}  // namespace
}  // namespace glowworm
