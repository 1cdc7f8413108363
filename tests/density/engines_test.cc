// Every engine against the brute-force sum at the same radii.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/error.h"
#include "core/frame.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/density_scenes.h"
#include "density/radius.h"
#include "kernels/simd.h"

namespace glowworm::density_tests {
namespace {

RadiusPolicy fixed(float radius, KernelShape kernel = KernelShape::epanechnikov) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = radius;
  policy.kernel = kernel;
  return policy;
}

class EveryEngine : public testing::TestWithParam<std::string> {
 protected:
  /// Largest relative difference of the engine from brute force.
  double difference(const PhotonBatch& photons, const RadiusPolicy& policy, const QueryPoints& points) const {
    return largest_difference(run(GetParam(), photons, policy, points), run("brute", photons, policy, points));
  }

  /// Radii that differ from photon to photon by up to a factor of 5, over what the estimate says; or another radius
  /// than the tests' for an engine that takes none for each photon. Some kernels end at planes.
  RadiusPolicy varied(const PhotonBatch& photons, KernelShape kernel = KernelShape::epanechnikov) const {
    RadiusPolicy policy = fixed(0.25f, kernel);
    policy.radii = per_photon_radii(photons, 20);
    for (std::uint32_t i = 0; i < policy.radii.size(); ++i) {
      policy.radii[i] *= 0.5f + 2 * to_unit_float(hash32(i));
      // Every third kernel ends at a plane, every sixth at two.
      if (i % 3 > 0) continue;
      const float angle = to_unit_float(hash32(i + 1)), reach = 0.4f * policy.radii[i];
      PhotonCuts c{i, {KernelCut{{std::cos(6 * angle), 0, std::sin(6 * angle)}, reach * angle}}};
      if (i % 6 == 0) c.cuts[1] = {{0, 1, 0}, reach};
      policy.cuts.push_back(c);
    }
    if (!engine_traits(GetParam()).takes_nearest) policy.kind = RadiusKind::per_photon;
    return policy;
  }
};

TEST_P(EveryEngine, HasItsName) { EXPECT_EQ(make_engine(GetParam())->name(), GetParam()); }

TEST_P(EveryEngine, AgreesAtOneRadiusForEveryKernel) {
  const PhotonBatch photons = room_photons(5003);
  const QueryPoints points = room_queries(1009);
  for (const KernelShape shape : kKernelShapes)
    EXPECT_LT(difference(photons, fixed(0.1f, shape), points), 1e-5) << int(shape);
}

TEST_P(EveryEngine, AgreesAtRadiiPerPhotonForEveryKernel) {
  const PhotonBatch photons = room_photons(5003);
  const QueryPoints points = room_queries(1009);
  for (const KernelShape shape : kKernelShapes)
    EXPECT_LT(difference(photons, varied(photons, shape), points), 1e-5) << int(shape);
}

TEST_P(EveryEngine, AgreesForOddCounts) {
  for (const std::size_t photon_count : {1, 2, 3, 5, 8, 9, 17, 33, 100}) {
    const PhotonBatch photons = room_photons(photon_count);
    for (const std::size_t query_count : {1, 2, 7, 8, 15, 16, 17, 31, 65}) {
      const QueryPoints points = room_queries(query_count);
      EXPECT_LT(difference(photons, fixed(0.7f), points), 1e-5) << photon_count << " " << query_count;
      EXPECT_LT(difference(photons, varied(photons), points), 1e-5) << photon_count << " " << query_count;
    }
  }
}

TEST_P(EveryEngine, AgreesOnEveryInstructionSetForEveryKernelAndOddCounts) {
  const PhotonBatch photons = room_photons(1237);
  const QueryPoints points = room_queries(331);
  for (const KernelShape shape : kKernelShapes) {
    const RadiusPolicy one = fixed(0.13f, shape), own = varied(photons, shape);
    const std::vector<RGB> by_one = run("brute", photons, one, points), by_own = run("brute", photons, own, points);
    for (const std::string& name : simd_names()) {
      set_simd(name);
      EXPECT_LT(largest_difference(run(GetParam(), photons, one, points), by_one), 1e-5) << name << int(shape);
      EXPECT_LT(largest_difference(run(GetParam(), photons, own, points), by_own), 1e-5) << name << int(shape);
    }
    set_simd("auto");
  }
}

TEST_P(EveryEngine, AgreesForOneQueryPointAndForOnePhoton) {
  const PhotonBatch photons = room_photons(700);
  PhotonBatch single;
  add_photon(single, {0.5f, 0.5f, 0}, {0, 0, 1});
  QueryPoints point;
  add_query(point, {0.52f, 0.47f, 0}, {0, 0, 1});
  for (const KernelShape shape : kKernelShapes) {
    EXPECT_LT(difference(photons, fixed(0.2f, shape), point), 1e-5) << int(shape);
    EXPECT_LT(difference(single, fixed(0.2f, shape), point), 1e-5) << int(shape);
    EXPECT_GT(run(GetParam(), single, fixed(0.2f, shape), point)[0].r, 0) << int(shape);
    EXPECT_LT(difference(single, fixed(0.2f, shape), room_queries(50)), 1e-5) << int(shape);
  }
}

TEST_P(EveryEngine, AgreesForRadiiOfZeroAndOfTheWholeScene) {
  PhotonBatch photons = room_photons(2000);
  QueryPoints points = room_queries(300);
  // A photon and a query point in one place: within no radius of zero, but within every other.
  add_query(points, photons.position[7], photons.normal[7]);
  for (const float radius : {0.0f, 1e-12f, 1e-6f, 4.0f, 1e6f}) {
    EXPECT_LT(difference(photons, fixed(radius), points), 1e-5) << radius;
  }
  RadiusPolicy policy = varied(photons);
  if (policy.kind == RadiusKind::fixed) return;
  for (std::size_t i = 0; i < policy.radii.size(); i += 3) policy.radii[i] = 0;
  policy.radii[4] = 4;
  EXPECT_LT(difference(photons, policy, points), 1e-5);
}

TEST_P(EveryEngine, AgreesForPointsFarOutside) {
  const PhotonBatch photons = room_photons(500);
  QueryPoints points;
  for (int i = 0; i < 40; ++i) add_query(points, {float(i % 3) * 100, -50.0f * float(i), 1e6f}, {0, 0, 1});
  for (const RGB& value : run(GetParam(), photons, fixed(0.2f), points)) EXPECT_EQ(value, RGB(0.0f));
  const QueryPoints inside = room_queries(40);
  points.append(inside);
  EXPECT_LT(difference(photons, fixed(0.2f), points), 1e-5);
  EXPECT_LT(difference(photons, varied(photons), points), 1e-5);
}

TEST_P(EveryEngine, AgreesForCoincidentAndFlatAndStraightPhotons) {
  for (int dimensions = 0; dimensions < 3; ++dimensions) {
    PhotonBatch photons;
    QueryPoints points;
    for (int i = 0; i < 700; ++i) {
      Sampler sampler(SamplerKind::independent, 3, 1, static_cast<std::uint32_t>(i));
      const Vec2 u = sampler.next2(), v = sampler.next2();
      const auto spread = [dimensions](Vec2 p) {
        return Vec3{dimensions > 0 ? p.x : 0.5f, dimensions > 1 ? p.y : 0.25f, 0.125f};
      };
      add_photon(photons, spread(u), {0, 0, 1}, RGB(u.x, u.y, 1));
      if (i % 10 == 0) add_query(points, spread(v) + Vec3{0, 0, 0.01f}, {0, 0, 1});
    }
    EXPECT_LT(difference(photons, fixed(0.1f), points), 1e-5) << dimensions;
    EXPECT_LT(difference(photons, varied(photons), points), 1e-5) << dimensions;
  }
}

TEST_P(EveryEngine, GivesZeroForNoPhotonsAndNothingForNoPoints) {
  const PhotonBatch none;
  const QueryPoints points = room_queries(50);
  for (const RGB& value : run(GetParam(), none, fixed(1.0f), points)) EXPECT_EQ(value, RGB(0.0f));
  for (const RGB& value : run(GetParam(), none, varied(none), points)) EXPECT_EQ(value, RGB(0.0f));
  EXPECT_TRUE(run(GetParam(), room_photons(50), fixed(1.0f), QueryPoints()).empty());
}

TEST_P(EveryEngine, ExcludesPhotonsOnTheBackOfAWall) {
  PhotonBatch photons;
  QueryPoints points;
  add_photon(photons, {0, 0, -0.001f}, {0, 0, -1});                 // back of a thin wall
  add_photon(photons, {0.01f, 0, 0.01f}, {1, 0, 0});                // the wall at the corner
  add_photon(photons, {0.01f, 0, 0}, normalize(Vec3{1.1f, 0, 1}));  // just too far turned
  add_query(points, {0, 0, 0}, {0, 0, 1});
  EXPECT_EQ(run(GetParam(), photons, fixed(0.1f), points)[0], RGB(0.0f));
  add_photon(photons, {0.01f, 0, 0}, normalize(Vec3{0.9f, 0, 1}));
  EXPECT_GT(run(GetParam(), photons, fixed(0.1f), points)[0].g, 0);
  EXPECT_LT(difference(photons, fixed(0.1f), points), 1e-5);
}

TEST_P(EveryEngine, AddsToTheRadianceAndCanBeRebuilt) {
  const PhotonBatch photons = room_photons(300), others = room_photons(200, 9);
  const QueryPoints points = room_queries(60);
  const auto engine = make_engine(GetParam());
  Statistics statistics;
  std::vector<RGB> sum(points.size(), RGB(1.0f));
  engine->build(photons, photons.flux, fixed(0.3f), statistics);
  engine->estimate(points, sum, statistics);
  engine->build(others, others.flux, fixed(0.2f), statistics);
  engine->estimate(points, sum, statistics);
  const std::vector<RGB> first = run("brute", photons, fixed(0.3f), points);
  const std::vector<RGB> second = run("brute", others, fixed(0.2f), points);
  std::vector<RGB> expected;
  for (std::size_t i = 0; i < points.size(); ++i) expected.push_back(RGB(1.0f) + first[i] + second[i]);
  EXPECT_LT(largest_difference(sum, expected), 1e-5);
}

TEST_P(EveryEngine, CountsItsWork) {
  const PhotonBatch photons = room_photons(3000);
  const QueryPoints points = room_queries(500);
  Statistics statistics, expected;
  run(GetParam(), photons, fixed(0.1f), points, &statistics);
  run("brute", photons, fixed(0.1f), points, &expected);
  EXPECT_EQ(statistics.count(Counter::query_points), 500u);
  EXPECT_EQ(statistics.count(Counter::shader_operations), expected.count(Counter::shader_operations));
  EXPECT_GE(statistics.count(Counter::pairs_tested), statistics.count(Counter::shader_operations));
  EXPECT_GT(statistics.seconds(Phase::density), 0);
}

TEST_P(EveryEngine, GivesTheSameBitsForAnyNumberOfThreads) {
  const PhotonBatch photons = room_photons(40000);
  QueryPoints points = room_queries(3000);
  const RadiusPolicy policy = varied(photons);
  if (GetParam() == "brute") points = room_queries(200);
  set_thread_count(1);
  const std::vector<RGB> one = run(GetParam(), photons, policy, points);
  for (const int threads : {2, 3}) {
    set_thread_count(threads);
    EXPECT_TRUE(one == run(GetParam(), photons, policy, points)) << threads;
  }
  set_thread_count(0);
}

TEST_P(EveryEngine, ShadesPointsThatAreNotLambertian) {
  const PhotonBatch photons = room_photons(4000);
  QueryPoints points = room_queries(200);
  const QueryPoints places = room_queries(203, 5);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Frame frame = Frame::from_normal(places.normal[i]);
    QueryBsdf query;
    query.s = frame.s;
    query.t = frame.t;
    query.n = frame.n;
    query.wo = frame.to_world(normalize(Vec3{0.3f, float(i % 7) * 0.1f, 0.8f}));
    if (i % 2 == 0) {
      query.bsdf.kind = BsdfKind::conductor;
      query.bsdf.use_reflectance = true;
      query.bsdf.specular = RGB(0.9f, 0.6f, 0.3f);
      query.bsdf.alpha_x = query.bsdf.alpha_y = 0.4f;
    } else {
      query.bsdf.kind = BsdfKind::lambertian;
      query.bsdf.diffuse = RGB(0.2f, 0.4f, 0.8f);
      query.bsdf.transmission = RGB(0.1f);
    }
    points.push_back(places.position[i], places.normal[i], query, RGB(1.0f), 0);
  }
  EXPECT_LT(difference(photons, fixed(0.15f), points), 1e-5);
  EXPECT_LT(difference(photons, varied(photons), points), 1e-5);
}

TEST_P(EveryEngine, RejectsInvalidRadii) {
  const PhotonBatch photons = room_photons(10);
  Statistics statistics;
  RadiusPolicy policy;
  policy.radii.assign(9, 0.1f);
  EXPECT_THROW(make_engine(GetParam())->build(photons, photons.flux, policy, statistics), Error);
  policy.radii.assign(10, std::numeric_limits<float>::quiet_NaN());
  EXPECT_THROW(make_engine(GetParam())->build(photons, photons.flux, policy, statistics), Error);
  EXPECT_THROW(make_engine(GetParam())->build(photons, photons.flux, fixed(-1), statistics), Error);
}

INSTANTIATE_TEST_SUITE_P(Engines, EveryEngine, testing::ValuesIn(engine_names()),
                         [](const testing::TestParamInfo<std::string>& name) { return name.param; });

TEST(EngineNames, AreUniqueAndOthersAreRejected) {
  const std::vector<std::string> names = engine_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  try {
    make_engine("no such engine");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(names.front()), std::string::npos);
  }
}

}  // namespace
}  // namespace glowworm::density_tests
