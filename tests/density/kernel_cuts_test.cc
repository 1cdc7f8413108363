// Kernels that end at planes, by every engine.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "density/density_scenes.h"
#include "kernels/kernel_shape.h"

namespace glowworm {
namespace {

class KernelCutsOf : public testing::TestWithParam<std::string> {};

/// Photons of a floor, of which every third does not count beyond a plane, and some of these not beyond a second one.
TEST_P(KernelCutsOf, CountOnTheirSideOfThePlanes) {
  constexpr std::uint32_t kPhotons = 3000, kPoints = 500;
  PhotonBatch photons;
  RadiusPolicy policy;
  for (std::uint32_t i = 0; i < kPhotons; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 0, i);
    const Vec2 u = sampler.next2(), v = sampler.next2();
    photons.push_back({u.x, u.y, 0}, {0, 0, 1}, RGB(1, v.x, 0.5f), {0, 0, 1});
    policy.radii.push_back(0.02f + 0.1f * v.y);
    if (i % 3 > 0) continue;
    PhotonCuts c{i, {}};
    c.cuts[0] = {{std::cos(6 * v.x), std::sin(6 * v.x), 0}, 0.5f * v.y * policy.radii[i]};
    if (i % 2 > 0) c.cuts[1] = {{1, 0, 0}, 0.3f * policy.radii[i]};
    policy.cuts.push_back(c);
  }
  QueryPoints points;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const Vec2 u = Sampler(SamplerKind::independent, 2, 0, i).next2();
    points.push_back({u.x, u.y, 0}, {0, 0, 1}, RGB(0.5f), RGB(1.0f), i);
  }
  for (const KernelShape shape : kKernelShapes) {
    policy.kernel = shape;
    const auto engine = make_engine(GetParam());
    Statistics statistics;
    engine->build(photons, photons.flux, policy, statistics);
    EXPECT_EQ(engine->name(), GetParam());
    std::vector<RGB> found(kPoints);
    engine->estimate(points, found, statistics);
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      double expected = 0;
      std::size_t cut = 0;
      for (std::uint32_t p = 0; p < kPhotons; ++p) {
        const Vec3 way = points.position[i] - photons.position[p];
        const double r = policy.radii[p], d2 = length_squared(way) / (r * r);
        const KernelCut* cuts =
            cut < policy.cuts.size() && policy.cuts[cut].photon == p ? policy.cuts[cut++].cuts.data() : nullptr;
        bool counts = d2 < 1;
        for (int c = 0; cuts && c < 2; ++c) counts &= dot(cuts[c].normal, way) > -cuts[c].distance;
        if (counts) expected += kernel(shape, d2) / (r * r) * photons.flux[p].g * 0.5 / std::numbers::pi;
      }
      // The box kernel jumps at its rim and at planes, where rounding decides.
      if (shape == KernelShape::box) continue;
      EXPECT_NEAR(found[i].g, expected, 1e-4 * expected + 1e-3) << i;
    }
  }
}

TEST(KernelCuts, ExcludePhotonsFromTheNearest) {
  const PhotonBatch photons = density_tests::room_photons(3000);
  const QueryPoints points = density_tests::room_queries(500);
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  policy.k = 20;
  policy.max_radius = 0.3f;
  const std::vector<RGB> whole = density_tests::run("knn", photons, policy, points);
  // Photons do not count beyond the middle of the room.
  for (std::uint32_t i = 0; i < photons.size(); ++i) {
    const float x = photons.position[i].x - 0.5f;
    policy.cuts.push_back({i, {KernelCut{{x > 0 ? 1.0f : -1.0f, 0, 0}, std::abs(x)}}});
  }
  const std::vector<RGB> cut = density_tests::run("knn", photons, policy, points);
  EXPECT_GT(density_tests::largest_difference(cut, whole), 0.1);
  EXPECT_LT(density_tests::largest_difference(cut, density_tests::run("brute", photons, policy, points)), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Engines, KernelCutsOf, testing::Values("blocked", "forward", "reverse", "brute"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace glowworm
