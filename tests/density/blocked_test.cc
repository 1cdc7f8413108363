#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/engine.h"
#include "density/radius.h"
#include "kernels/simd.h"

namespace glowworm {
namespace {

Vec3 on_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z};
}

/// A point of a surface in the unit cube: its walls, a ball inside, and a thin plate with two sides.
void surface_point(std::uint32_t seed, std::uint32_t i, Vec3& position, Vec3& normal) {
  Sampler sampler(SamplerKind::independent, seed, 1, i);
  const Vec2 u = sampler.next2(), choice = sampler.next2();
  if (choice.x < 0.25f) {
    normal = on_sphere(u);
    position = Vec3{0.5f, 0.4f, 0.5f} + normal * 0.2f;
  } else if (choice.x < 0.45f) {
    position = {u.x, 0.8f, u.y};
    normal = {0, choice.y < 0.5f ? 1.0f : -1.0f, 0};
  } else {
    const int axis = static_cast<int>(choice.y * 3);
    const bool upper = choice.y * 3 - static_cast<float>(axis) < 0.5f;
    position = {u.x * u.x, u.y, upper ? 1.0f : 0.0f};
    normal = {0, 0, upper ? -1.0f : 1.0f};
    std::swap(position[axis], position.z);
    std::swap(normal[axis], normal.z);
  }
}

PhotonBatch make_photons(std::uint32_t n, std::uint32_t seed = 1) {
  PhotonBatch photons;
  for (std::uint32_t i = 0; i < n; ++i) {
    Vec3 p, normal;
    surface_point(seed, i, p, normal);
    Sampler sampler(SamplerKind::independent, seed, 2, i);
    const Vec3 direction = face_forward(on_sphere(sampler.next2()), normal);
    const Vec2 u = sampler.next2();
    photons.push_back(p, direction, RGB(0.5f + u.x, 0.2f + u.y, 1.0f), normal);
  }
  return photons;
}

QueryPoints make_points(std::uint32_t n, std::uint32_t seed = 2) {
  QueryPoints points;
  for (std::uint32_t i = 0; i < n; ++i) {
    Vec3 p, normal;
    surface_point(seed, i, p, normal);
    points.push_back(p, normal, RGB(0.8f, 0.5f, to_unit_float(hash32(i))), RGB(1.0f), i);
  }
  return points;
}

RadiusPolicy fixed(float radius, KernelShape kernel = KernelShape::epanechnikov) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = radius;
  policy.kernel = kernel;
  return policy;
}

RadiusPolicy per_photon(const PhotonBatch& photons, KernelShape kernel) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::per_photon;
  policy.kernel = kernel;
  policy.radii = per_photon_radii(photons, 50);
  for (std::size_t i = 0; i < policy.radii.size(); i += 97) policy.radii[i] = 0;
  return policy;
}

struct Answer {
  std::vector<RGB> radiance;
  std::uint64_t operations, tested;
};

Answer ask(const std::string& engine, const PhotonBatch& photons, const RadiusPolicy& policy,
           const QueryPoints& points) {
  const std::unique_ptr<DensityEngine> made = make_engine(engine);
  Statistics statistics;
  made->build(photons, photons.flux, policy, statistics);
  Answer answer{std::vector<RGB>(points.size()), 0, 0};
  made->estimate(points, answer.radiance, statistics);
  EXPECT_EQ(statistics.count(Counter::query_points), points.size());
  answer.operations = statistics.count(Counter::shader_operations);
  answer.tested = statistics.count(Counter::pairs_tested);
  return answer;
}

/// Sums in single precision of up to a few thousand terms, none negative: relative error below 2e-6 a term on average.
void expect_agreement(const PhotonBatch& photons, const RadiusPolicy& policy, const QueryPoints& points) {
  const Answer truth = ask("brute", photons, policy, points), answer = ask("blocked", photons, policy, points);
  EXPECT_EQ(answer.operations, truth.operations);
  EXPECT_GE(answer.tested, answer.operations);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(answer.radiance[i][c], truth.radiance[i][c], 2e-5 * truth.radiance[i][c] + 1e-30)
          << "point " << i << " channel " << c;
}

TEST(BlockedEngine, AgreesWithBruteForceForEveryKernel) {
  const PhotonBatch photons = make_photons(3001);
  const QueryPoints points = make_points(1003);
  for (const KernelShape shape : kKernelShapes) {
    SCOPED_TRACE(static_cast<int>(shape));
    expect_agreement(photons, fixed(0.15f, shape), points);
    expect_agreement(photons, per_photon(photons, shape), points);
  }
}

TEST(BlockedEngine, AgreesOnEveryInstructionSet) {
  const PhotonBatch photons = make_photons(2003);
  const QueryPoints points = make_points(517);
  for (const std::string& name : simd_names()) {
    SCOPED_TRACE(name);
    set_simd(name);
    for (const KernelShape shape : kKernelShapes) expect_agreement(photons, per_photon(photons, shape), points);
  }
  set_simd("auto");
}

TEST(BlockedEngine, AgreesForOddCounts) {
  for (const std::uint32_t photons : {0u, 1u, 7u, 8u, 9u, 63u, 65u, 513u})
    for (const std::uint32_t points : {0u, 1u, 2u, 15u, 17u, 33u}) {
      SCOPED_TRACE(testing::Message() << photons << " photons, " << points << " points");
      expect_agreement(make_photons(photons), fixed(0.5f), make_points(points));
    }
}

TEST(BlockedEngine, AgreesForRadiiOfZeroAndOfTheWholeScene) {
  const PhotonBatch photons = make_photons(1500);
  const QueryPoints points = make_points(300);
  expect_agreement(photons, fixed(0), points);
  for (const KernelShape shape : kKernelShapes) expect_agreement(photons, fixed(4, shape), points);
  EXPECT_EQ(ask("blocked", photons, fixed(1e-30f), points).operations, 0u);
  EXPECT_EQ(ask("blocked", photons, fixed(1e30f), points).operations,
            ask("brute", photons, fixed(9), points).operations);
}

TEST(BlockedEngine, FarAwayPointsSeeNothing) {
  QueryPoints points = make_points(200);
  for (std::size_t i = 0; i < 100; ++i) points.position[i] += Vec3{1e4f, -1e8f, 1e20f};
  const PhotonBatch photons = make_photons(1000);
  expect_agreement(photons, fixed(0.2f), points);
}

TEST(BlockedEngine, AcceptsNumbersThatAreNotFinite) {
  QueryPoints points = make_points(64);
  PhotonBatch photons = make_photons(64);
  const Answer whole = ask("blocked", photons, fixed(3), points);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  points.position[5].y = nan;
  points.position[6].x = infinity;
  points.normal[7].z = nan;
  photons.push_back({nan, 0, 0}, {0, 0, 1}, RGB(1), {0, 0, 1});
  photons.push_back({0, 0, -infinity}, {0, 0, 1}, RGB(1), {0, 0, 1});
  const Answer answer = ask("blocked", photons, fixed(3), points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i >= 5 && i <= 7) {
      EXPECT_EQ(answer.radiance[i].g, 0);
    } else {
      EXPECT_NEAR(answer.radiance[i].g, whole.radiance[i].g, 1e-5f * whole.radiance[i].g);
    }
  }
}

TEST(BlockedEngine, AgreesWherePhotonsLieOnAPlaneALineOrOnePoint) {
  const QueryPoints points = make_points(200);
  PhotonBatch photons = make_photons(1000);
  for (int axis = 0; axis < 3; ++axis) {
    for (Vec3& p : photons.position) p[axis] = 0.25f;
    expect_agreement(photons, fixed(0.4f), points);
  }
}

TEST(BlockedEngine, PhotonsOnTheBackDoNotCount) {
  PhotonBatch photons = make_photons(1000);
  QueryPoints points = make_points(1000);
  for (Vec3& n : photons.normal) n = {0, 0, 1};
  for (Vec3& n : points.normal) n = {0, 0, -1};
  EXPECT_EQ(ask("blocked", photons, fixed(0.5f), points).operations, 0u);
  for (std::size_t i = 0; i < points.size(); i += 2) points.normal[i] = {0, 0, 1};
  expect_agreement(photons, fixed(0.5f), points);
  RadiusPolicy policy = fixed(0.5f);
  policy.min_normal_cosine = -1.5f;  // every photon counts
  expect_agreement(photons, policy, points);
}

TEST(BlockedEngine, AgreesWhereNormalsAreAtTheLimit) {
  PhotonBatch photons = make_photons(600);
  QueryPoints points = make_points(600);
  // Cosines all around 0.7, some closer than rounding.
  for (std::uint32_t i = 0; i < 600; ++i) {
    const float angle = std::acos(0.7f) + 1e-7f * (static_cast<float>(i) - 300);
    photons.normal[i] = {0, std::sin(angle), std::cos(angle)};
    points.normal[i] = {0, 0, 1};
  }
  expect_agreement(photons, fixed(0.5f), points);
}

TEST(BlockedEngine, AgreesWherePointsAreNotLambertian) {
  const PhotonBatch photons = make_photons(2000);
  QueryPoints points;
  Bsdf conductor;
  conductor.kind = BsdfKind::conductor;
  conductor.use_reflectance = true;
  conductor.specular = RGB(0.9f, 0.8f, 0.7f);
  conductor.alpha_x = conductor.alpha_y = 0.4f;
  for (std::uint32_t i = 0; i < 700; ++i) {
    Vec3 p, n;
    surface_point(5, i, p, n);
    if (i % 3 == 0) {
      points.push_back(p, n, RGB(0.5f), RGB(1.0f), i);
      continue;
    }
    const Vec3 s = normalize(cross(n, std::abs(n.x) > 0.5f ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
    const Vec3 wo = face_forward(on_sphere({to_unit_float(hash32(i)), to_unit_float(hash32(i + 9999))}), n);
    points.push_back(p, n, QueryBsdf{conductor, s, cross(n, s), n, wo}, RGB(1.0f), i);
  }
  expect_agreement(photons, fixed(0.2f), points);
}

TEST(BlockedEngine, GivesTheSameBitsForAnyNumberOfThreads) {
  const PhotonBatch photons = make_photons(60000);
  const QueryPoints points = make_points(60000);
  const RadiusPolicy policy = per_photon(photons, KernelShape::epanechnikov);
  set_thread_count(1);
  const Answer one = ask("blocked", photons, policy, points);
  for (const int threads : {2, 5}) {
    set_thread_count(threads);
    const Answer more = ask("blocked", photons, policy, points);
    EXPECT_EQ(std::memcmp(one.radiance.data(), more.radiance.data(), one.radiance.size() * sizeof(RGB)), 0);
    EXPECT_EQ(one.operations, more.operations);
  }
  set_thread_count(0);
}

TEST(BlockedEngine, BatchesAddUp) {
  const PhotonBatch a = make_photons(800, 7), b = make_photons(900, 8);
  PhotonBatch both = a;
  both.append(b);
  const QueryPoints points = make_points(300);
  const Answer truth = ask("brute", both, fixed(0.3f), points);
  const auto engine = make_engine("blocked");
  Statistics statistics;
  std::vector<RGB> radiance(points.size());
  for (const PhotonBatch* batch : {&a, &b}) {
    engine->build(*batch, batch->flux, fixed(0.3f), statistics);
    engine->estimate(points, radiance, statistics);
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(radiance[i].r, truth.radiance[i].r, 2e-5f * truth.radiance[i].r);
}

TEST(BlockedEngine, DividesWhereAllPointsCrowdInOneCell) {
  const PhotonBatch photons = make_photons(300);
  QueryPoints points = make_points(70000);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i % 1000 != 0) points.position[i] = points.position[i] * 1e-3f;
  for (std::size_t i = 40000; i < points.size(); ++i) points.position[i] = {0.25f, 0.25f, 0.25f};
  expect_agreement(photons, fixed(0.1f), points);
}

TEST(BlockedEngine, TellsTheMemoryOfItsIndex) {
  const auto engine = make_engine("blocked");
  EXPECT_GE(engine->index_bytes(100000), 100000u * 40);
  EXPECT_LT(engine->index_bytes(100000), 100000u * 80);
}

TEST(BlockedEngine, RejectsUnsupportedOptions) {
  const auto engine = make_engine("blocked");
  Statistics statistics;
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  const PhotonBatch photons = make_photons(10);
  EXPECT_THROW(engine->build(photons, photons.flux, policy, statistics), Error);
  EXPECT_THROW(engine->build(photons, photons.flux, fixed(std::numeric_limits<float>::quiet_NaN()), statistics), Error);
}

}  // namespace
}  // namespace glowworm
