// Choosing among many lights: probabilities are correct, reach every light, and reduce noise.
#include "scene/light_tree.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/random.h"
#include "core/warp.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

Vec3 random_point(Sampler& s, float extent) {
  const Vec2 a = s.next2(), b = s.next2();
  return Vec3{a.x, a.y, b.x} * (2 * extent) - Vec3{extent, extent, extent};
}

/// Lights of every kind, strewn about: one- and two-sided, narrow and wide, strong, weak and dark.
std::vector<LightBounds> random_lights(std::uint32_t count, std::uint32_t seed) {
  std::vector<LightBounds> lights;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler s(SamplerKind::independent, seed, 77, i);
    LightBounds& b = lights.emplace_back();
    const Vec3 at = random_point(s, 10);
    b.box.grow(at);
    b.box.grow(at + random_point(s, 0.2f));
    b.axis = normalize(random_point(s, 1) + Vec3{1e-3f, 0, 0});
    b.cos_normals = s.next1() < 0.2f ? -1.0f : 1.0f;
    const float emission = s.next1();
    b.cos_emission = emission < 0.3f ? 0.9f : emission < 0.5f ? -0.6f : 0.0f;  // narrow and wide spots, and triangles
    b.two_sided = s.next1() < 0.3f;
    b.intensity = s.next1() < 0.1f ? 0.0f : std::exp(6 * s.next1());
  }
  return lights;
}

TEST(LightTree, ProbabilitiesAddUpToOne) {
  for (const std::uint32_t count : {1u, 2u, 3u, 17u, 400u}) {
    const std::vector<LightBounds> lights = random_lights(count, 3);
    const LightTree tree(lights);
    for (std::uint32_t n = 0; n < 50; ++n) {
      Sampler s(SamplerKind::independent, 5, 6, n);
      const Vec3 p = random_point(s, 12);
      double sum = 0;
      for (std::uint32_t i = 0; i < count; ++i) sum += tree.probability(p, i);
      // Nothing is lost but where a whole branch is dark to the point although its parent was not known to be.
      EXPECT_LE(sum, 1 + 1e-5);
      EXPECT_GT(sum, count >= 400 ? 0.5 : -1e-9);
    }
  }
}

TEST(LightTree, ChoosesWithItsProbabilities) {
  const std::vector<LightBounds> lights = random_lights(40, 9);
  const LightTree tree(lights);
  for (std::uint32_t n = 0; n < 5; ++n) {
    Sampler place(SamplerKind::independent, 5, 6, n);
    const Vec3 p = random_point(place, 8);
    constexpr std::uint32_t kCount = 100000;
    std::vector<double> seen(lights.size());
    double none = 0;
    LightTree::Descent descent;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      Sampler s(SamplerKind::independent, 1, n, i);
      const LightTree::Choice choice = tree.choose(p, s.next1(), descent);
      if (choice.probability == 0) {
        none += 1;
        continue;
      }
      EXPECT_FLOAT_EQ(choice.probability, tree.probability(p, choice.light));
      EXPECT_TRUE(choice.remapped >= 0 && choice.remapped < 1);
      seen[choice.light] += 1;
    }
    double total = none / kCount;
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      const double expected = tree.probability(p, i);
      total += expected;
      // 5 standard deviations of a count: 200 counts in all, a false alarm in 10,000 runs of another seed.
      EXPECT_NEAR(seen[i], expected * kCount, 5 * std::sqrt(expected * kCount) + 1e-9);
    }
    EXPECT_NEAR(total, 1, 0.01);
  }
}

TEST(LightTree, ReachesEveryLightThatReachesThePoint) {
  const std::vector<LightBounds> lights = random_lights(300, 21);
  const LightTree tree(lights);
  int reached = 0;
  for (std::uint32_t n = 0; n < 200; ++n) {
    Sampler s(SamplerKind::independent, 5, 6, n);
    const Vec3 p = random_point(s, 11);
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      const LightBounds& b = lights[i];
      if (!(b.intensity > 0)) continue;
      // A place on the light and its own normal.
      const Vec3 from = b.box.min + b.box.diagonal() * s.next1();
      const Vec3 direction = normalize(p - from);
      float cosine = dot(b.axis, direction);
      if (b.two_sided) cosine = std::abs(cosine);
      if (b.cos_normals > -1 && cosine <= b.cos_emission) continue;
      ++reached;
      EXPECT_GT(tree.probability(p, i), 0) << "light " << i << " from point " << n;
    }
  }
  EXPECT_GT(reached, 10000);
}

TEST(LightTree, MergesConesAroundBoth) {
  for (std::uint32_t n = 0; n < 1000; ++n) {
    const std::vector<LightBounds> pair = random_lights(2, n);
    const LightBounds both = merge(pair[0], pair[1]);
    for (const LightBounds& b : pair) {
      if (!(b.intensity > 0)) continue;
      const double angle = std::acos(std::clamp<double>(dot(both.axis, b.axis), -1, 1)) + std::acos(b.cos_normals);
      if (angle > 3.1) continue;
      EXPECT_LE(angle, std::acos(std::clamp<double>(both.cos_normals, -1, 1)) + 2e-3);
      EXPECT_LE(both.cos_emission, b.cos_emission);
    }
  }
}

/// A long hall's floor under many small panels.
Scene hall(int panels) {
  SceneDescription d = floor_description();
  const std::uint32_t emission = add_emission(d, RGB(10));
  for (int i = 0; i < panels; ++i)
    add_quad(d, {static_cast<float>(i % 20) * 4 - 40, static_cast<float>(i / 20) * 4 - 40, 3}, {0, 0.3f, 0},
             {0.3f, 0, 0}, 0, emission);
  return Scene(std::move(d));
}

struct Estimate {
  double mean = 0, variance = 0;
};

/// Irradiance of the floor's middle; by light_power() alone where `by_power`.
Estimate irradiance(const Scene& scene, bool by_power) {
  constexpr std::uint32_t kCount = 20000;
  const Vec3 p{0.7f, 0.4f, 0};
  double sum = 0, squares = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    Sampler s(SamplerKind::independent, 4, 5, i);
    const Vec2 u = s.next2();
    const LightSample light = sample_light(scene, p, s.next1(), u);
    double value = light.pdf > 0 ? luminance(light.radiance) * light.direction.z / light.pdf : 0;
    if (by_power) {
      // The same panels, chosen evenly: density by area and the panels' number.
      const std::uint32_t triangle = scene.emissive_triangles()[scene.light_power().sample(s.next1()).index];
      const Vec2 w = s.next2();
      const SurfacePoint on = surface_point(scene, triangle, square_to_triangle(w));
      const Vec3 offset = on.position - p;
      const double squared = length_squared(offset), cosine = offset.z / std::sqrt(squared);
      value = luminance(scene.emissions()[0].radiance.value) * cosine * cosine / squared *
              scene.geometry().area(triangle) * static_cast<double>(scene.emissive_triangles().size());
    }
    sum += value;
    squares += value * value;
  }
  return {sum / kCount, squares / kCount - sum / kCount * sum / kCount};
}

/// The variance of one light sample where each panel is chosen in exact proportion to I cos_l / d^2, all that is known
/// of it without the surface that it lights: the sample is then (sum of those) times cos_s, the surface's cosine.
double least_variance(const Scene& scene, Vec3 p) {
  double known = 0, mean = 0, squares = 0;
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    const auto& [a, b, c] = scene.geometry().triangles[triangle];
    const auto& at = scene.geometry().positions;
    const Vec3 offset = (at[a] + at[b] + at[c]) / 3 - p;
    const double squared = length_squared(offset), cosine = offset.z / std::sqrt(squared);
    const double share =
        luminance(scene.emissions()[0].radiance.value) * scene.geometry().area(triangle) * cosine / squared;
    known += share;
    mean += share * cosine;
    squares += share * cosine * cosine;
  }
  return known * squares - mean * mean;
}

TEST(LightTree, IsCloserToTheLeastVarianceThanChoiceByPower) {
  const Scene scene = hall(400);
  const Estimate tree = irradiance(scene, false), power = irradiance(scene, true);
  EXPECT_NEAR(tree.mean, power.mean, 4 * std::sqrt((tree.variance + power.variance) / 20000));
  const double least = least_variance(scene, {0.7f, 0.4f, 0});
  fmt::print("variance: by power {:.3f}, by the tree {:.3f}, by exact knowledge of each light {:.3f}\n", power.variance,
             tree.variance, least);
  // Power alone knows nothing of where the lights are. The tree, whose nodes know a box and a cone of theirs, is nearer
  // to knowing each, by ratio.
  EXPECT_LT(tree.variance, std::sqrt(power.variance * least));
}

TEST(LightSelector, GivesNearAndFarLightTheirShares) {
  const Scene scene(lit_floor(LightCase::all));
  for (std::uint32_t n = 0; n < 50; ++n) {
    Sampler s(SamplerKind::independent, 5, 6, n);
    const Vec3 p = random_point(s, 2);
    double near = 0, far = 0;
    const std::size_t triangles = scene.emissive_triangles().size();
    for (std::uint32_t source = 0; source < scene.light_source_count(); ++source) {
      const bool is_far = source >= triangles && (source == scene.light_source_count() - 1 ||
                                                  scene.lights()[source - triangles].kind == LightKind::directional);
      (is_far ? far : near) += scene.light_selector().probability(p, source);
    }
    EXPECT_GE(far, 0.1 - 1e-5);
    EXPECT_LE(near, 0.9 + 1e-5);
    EXPECT_LE(near + far, 1 + 1e-5);
  }
}

}  // namespace
}  // namespace glowworm
