// The guide of gather rays: it follows the light of its rays, keeps the mean, and leaves flat light alone.
#include "gather/gather_guide.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "core/random.h"
#include "core/warp.h"
#include "gather/gather_rays.h"

namespace glowworm {
namespace {

constexpr std::uint32_t kRaysEach = 16;

/// Rays of points on a floor and a wall of 10 x 10 m. @param light of a ray, by its point and its place in the square
template <typename Light>
GuideRays rays_on_floor_and_wall(std::uint32_t points, Light&& light) {
  GuideRays rays;
  rays.rays_each = kRaysEach;
  for (std::uint32_t i = 0; i < points; ++i) {
    Sampler sampler(SamplerKind::sobol, 1, 0, i);
    const Vec2 at = sampler.next2() * 10;
    const bool wall = i % 2 == 1;
    rays.position.push_back(wall ? Vec3{at.x, at.y, 0} : Vec3{at.x, 0, at.y});
    rays.normal.push_back(wall ? Vec3{0, 0, 1} : Vec3{0, 1, 0});
    for (std::uint32_t r = 0; r < kRaysEach; ++r) {
      Sampler of_ray(SamplerKind::sobol, 2, i, r);
      const Vec2 u = of_ray.next2();
      rays.cell.push_back(GatherGuide::cell(u));
      rays.light.push_back(light(rays.position[i], rays.normal[i], u, of_ray.next1()));
    }
  }
  return rays;
}

/// Light from a small part of the square, at another place on the wall than on the floor.
float spot(Vec3, Vec3 normal, Vec2 u, float) {
  const Vec2 low = normal.z > 0 ? Vec2{0.75f, 0.25f} : Vec2{0.25f, 0.5f};
  return u.x >= low.x && u.x < low.x + 0.1f && u.y >= low.y && u.y < low.y + 0.1f ? 10.0f : 0.1f;
}

/// A point of the warped square, and the density of such points.
struct Warped {
  Vec2 point;
  float density = 1;
};

Warped warp(const GatherGuide& guide, std::uint32_t region, Vec2 u) {
  const float weight = guide.warp(region, u);
  return {u, 1 / weight};
}

TEST(GatherGuide, SendsRaysWhereTheLightIs) {
  const GatherGuide guide(rays_on_floor_and_wall(8192, spot));
  ASSERT_FALSE(guide.empty());
  for (const Vec3 normal : {Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    const std::uint32_t region = guide.region({5, 5 * normal.z, 5 * normal.y}, normal);
    ASSERT_NE(region, kNone);
    int hits = 0;
    double mean = 0;
    constexpr std::uint32_t kRays = 4096;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      Sampler sampler(SamplerKind::sobol, 3, 0, i);
      const Warped warped = warp(guide, region, sampler.next2());
      ASSERT_GE(warped.point.x, 0);
      ASSERT_LT(warped.point.x, 1);
      ASSERT_GE(warped.point.y, 0);
      ASSERT_LT(warped.point.y, 1);
      ASSERT_GE(warped.density, 0.99f * GatherGuide::kEvenShare);
      const float light = spot({}, normal, warped.point, 0);
      hits += light > 1;
      mean += light / warped.density / kRays;
    }
    // One ray in a hundred without a guide.
    EXPECT_GT(hits, kRays / 7);
    // Sobol' points: the error is far below that of 4,096 random rays, 0.2%.
    EXPECT_NEAR(mean, 0.1 + 9.9 * 0.01, 0.002 * 0.2);
  }
}

TEST(GatherGuide, HasTheDensityThatItReturns) {
  const GatherGuide guide(rays_on_floor_and_wall(8192, spot));
  const std::uint32_t region = guide.region({5, 0, 5}, {0, 1, 0});
  ASSERT_NE(region, kNone);
  constexpr std::uint32_t kSide = 1024;
  constexpr double kSamples = kSide * kSide;
  double area = 0;
  constexpr std::size_t kCells = std::size_t{GatherGuide::kSide} * GatherGuide::kSide;
  std::array<double, kCells> count{}, areas{};
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const Warped warped = warp(guide, region, {(x + 0.5f) / kSide, (y + 0.5f) / kSide});
      area += 1 / warped.density / kSamples;
      ASSERT_LT(std::abs(guide.density(region, warped.point) / warped.density - 1), 1e-3f);
      const std::size_t cell = GatherGuide::cell(warped.point);
      ++count[cell];
      areas[cell] += 1 / warped.density / kSamples;
    }
  EXPECT_NEAR(area, 1, 1e-3);
  // Samples, each with the area that it stands for, cover every cell alike.
  for (std::size_t i = 0; i < kCells; ++i)
    EXPECT_NEAR(areas[i], 1.0 / kCells, 0.03 / kCells) << i << ", of " << count[i] << " samples";
}

TEST(Warp, SquaresOfDiscsAreTheirInverse) {
  for (std::uint32_t i = 0; i < 10000; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 0, i);
    const Vec2 u = sampler.next2(), back = disk_to_square(square_to_disk(u));
    ASSERT_NEAR(back.x, u.x, 2e-6f);
    ASSERT_NEAR(back.y, u.y, 2e-6f);
  }
}

/// Gather points at one place of the floor, seen at an angle. @param frame_normal of the shading frame
GatherPoints points_of(const Bsdf& bsdf, Vec3 frame_normal, std::uint32_t count) {
  GatherPoints points;
  for (std::uint32_t i = 0; i < count; ++i) {
    points.slot.push_back(i);
    points.sequence.push_back(i);
    points.sample.push_back(0);
    points.position.push_back({5, 0, 5});
    points.normal.push_back({0, 1, 0});
    points.offset.push_back(1e-6f);
    points.frame.push_back(Frame::from_normal(frame_normal));
    points.wo.push_back(normalize(Vec3{1, 1, 0.5f}));
    points.bsdf.push_back(bsdf);
    points.throughput.push_back(RGB(1.0f));
  }
  return points;
}

/// Mean over points of the sum of a value over the rays of each, and the squared standard error of that mean.
struct Estimate {
  double mean = 0, variance = 0;
};
template <typename Value>
Estimate over_rays(const GatherPoints& points, const GatherGuide* guide, Value&& value) {
  constexpr std::uint32_t kRays = 12;
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  GatherRayMaker maker;
  maker.prepare(points, order, kRays, 7, guide);
  GatherPaths rays;
  maker.create(0, kRays, rays);
  std::vector<double> sums(points.size());
  for (const GatherPath& ray : rays)
    sums[ray.point] += value(ray.throughput.g, ray.ray.direction, maker.density(ray.point));
  const double n = static_cast<double>(sums.size());
  Estimate out;
  for (const double sum : sums) out.mean += sum / n;
  for (const double sum : sums) out.variance += (sum - out.mean) * (sum - out.mean) / (n * (n - 1));
  return out;
}

/// Guided rays bring the light of those that are not, for surfaces with a coat and bent normals, too, and their density
/// is what it says.
TEST(GatherGuide, KeepsTheLightOfAllBsdfs) {
  const GatherGuide guide(rays_on_floor_and_wall(8192, spot));
  Bsdf diffuse, smooth_coat, rough_coat;
  diffuse.diffuse = smooth_coat.diffuse = rough_coat.diffuse = RGB(0.5f);
  smooth_coat.kind = rough_coat.kind = BsdfKind::coated_diffuse;
  rough_coat.alpha_x = rough_coat.alpha_y = 0.3f;
  for (const Bsdf& bsdf : {diffuse, smooth_coat, rough_coat}) {
    for (const Vec3 normal : {Vec3{0, 1, 0}, normalize(Vec3{0.3f, 1, -0.1f})}) {
      const GatherPoints points = points_of(bsdf, normal, 4000);
      ASSERT_NE(GatherDensity(points, 0, &guide).region(), kNone);
      const auto light = [](double weight, Vec3 d, const GatherDensity&) {
        return weight * (d.x * d.y > 0.2f ? 3 : 1 + d.z);
      };
      const Estimate guided = over_rays(points, &guide, light), even = over_rays(points, nullptr, light);
      EXPECT_NEAR(guided.mean, even.mean, 4 * std::sqrt(guided.variance + even.variance)) << normal.x;
      EXPECT_LT(std::sqrt(guided.variance + even.variance), 0.01 * even.mean);
      if (normal.x != 0) continue;  // mirrored directions have two densities
      const Estimate area = over_rays(points, &guide, [](double, Vec3 d, const GatherDensity& density) {
        return d.y > 0.3f ? 1 / (12.0 * density.guided_pdf(d)) : 0;
      });
      EXPECT_NEAR(area.mean, 2 * M_PI * 0.7, 4 * std::sqrt(area.variance));
    }
  }
}

TEST(GatherGuide, LeavesEvenAndBlackLightAlone) {
  const auto even = [](Vec3, Vec3, Vec2, float) { return 1.0f; };
  const auto noise = [](Vec3, Vec3, Vec2, float u) { return u; };
  const auto black = [](Vec3, Vec3, Vec2, float) { return 0.0f; };
  EXPECT_TRUE(GatherGuide(rays_on_floor_and_wall(4096, even)).empty());
  EXPECT_TRUE(GatherGuide(rays_on_floor_and_wall(4096, noise)).empty());
  EXPECT_TRUE(GatherGuide(rays_on_floor_and_wall(4096, black)).empty());
  EXPECT_TRUE(GatherGuide(GuideRays{}).empty());
  EXPECT_EQ(GatherGuide().region({0, 0, 0}, {0, 1, 0}), kNone);
}

TEST(GatherGuide, DoesNotFollowRaysThatFoundLightByChance) {
  const auto rare = [](Vec3, Vec3, Vec2, float u) { return u < 0.002f ? 100.0f : 1.0f; };
  EXPECT_LT(GatherGuide(rays_on_floor_and_wall(4096, rare)).gain(), 0.02);
}

TEST(GatherGuide, KnowsItsGain) {
  const GatherGuide guide(rays_on_floor_and_wall(8192, spot));
  EXPECT_GT(guide.gain(), 0.5);
  EXPECT_LT(guide.gain(), 1);
  EXPECT_EQ(GatherGuide().gain(), 0);
}

TEST(GatherGuide, DividesSpaceWhereLightMoves) {
  // Light comes from the side on which the point lies.
  const auto moving = [](Vec3 p, Vec3, Vec2 u, float) { return std::abs(u.x - p.x / 10) < 0.1f ? 1.0f : 0.0f; };
  const GatherGuide guide(rays_on_floor_and_wall(16384, moving));
  std::set<std::uint32_t> regions;
  for (float x = 0.5f; x < 10; ++x) {
    const std::uint32_t region = guide.region({x, 0, 5}, {0, 1, 0});
    ASSERT_NE(region, kNone);
    regions.insert(region);
    int found = 0;
    for (std::uint32_t i = 0; i < 1024; ++i) {
      Sampler sampler(SamplerKind::sobol, 4, 0, i);
      found += std::abs(warp(guide, region, sampler.next2()).point.x - x / 10) < 0.1f;
    }
    EXPECT_GT(found, 400) << "at " << x << " m; 200 without a guide";
  }
  EXPECT_GT(regions.size(), 4u);
}

TEST(GatherGuide, SurvivesPointsInOnePlace) {
  GuideRays rays = rays_on_floor_and_wall(4096, spot);
  rays.position.assign(rays.position.size(), {1, 2, 3});
  rays.normal.assign(rays.normal.size(), {0, 1, 0});
  const GatherGuide guide(rays);
  EXPECT_LE(guide.size(), 1u);
}

TEST(GatherGuide, FramesDependOnNormalsAloneAndAreSteadyOnWalls) {
  for (const Vec3 n :
       {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0.48f, 0.6f, 0.64f}}) {
    const Frame f = GatherGuide::frame(n);
    EXPECT_NEAR(dot(f.s, f.t), 0, 1e-6f);
    EXPECT_NEAR(dot(f.s, n), 0, 1e-6f);
    EXPECT_NEAR(dot(f.t, n), 0, 1e-6f);
    EXPECT_NEAR(length(f.s), 1, 1e-6f);
    EXPECT_NEAR(dot(cross(f.s, f.t), n), 1, 1e-6f);
  }
  const Frame a = GatherGuide::frame({1, 0, 1e-7f}), b = GatherGuide::frame({1, 0, -1e-7f});
  EXPECT_GT(dot(a.s, b.s), 0.999f) << "rounding of a wall's normal does not turn its frame";
}

}  // namespace
}  // namespace glowworm
