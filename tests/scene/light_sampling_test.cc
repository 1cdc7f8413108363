// sample_light() against its densities and against closed forms of irradiance.
#include "scene/light_sampling.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/random.h"
#include "core/warp.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

constexpr int kCases = static_cast<int>(LightCase::count_);

class LightSampling : public ::testing::TestWithParam<LightCase> {};

LightSample light_sample(const Scene& scene, Vec3 position, std::uint32_t i) {
  Sampler sampler(SamplerKind::independent, 21, 0, i);
  const float u_light = sampler.next1();
  return sample_light(scene, position, u_light, sampler.next2());
}

/// Where a ray meets a triangle: by barycentric coordinates from the volumes it spans (Moeller and Trumbore 1997).
bool meet(const Geometry& g, std::uint32_t triangle, Vec3 origin, Vec3 direction, Vec2& barycentric) {
  const auto& [a, b, c] = g.triangles[triangle];
  const Vec3 e1 = g.positions[b] - g.positions[a], e2 = g.positions[c] - g.positions[a], from = origin - g.positions[a];
  const Vec3 p = cross(direction, e2);
  const float determinant = dot(e1, p);
  if (determinant == 0) return false;
  barycentric = {dot(from, p) / determinant, dot(direction, cross(from, e1)) / determinant};
  return barycentric.x >= 0 && barycentric.y >= 0 && barycentric.x + barycentric.y <= 1 &&
         dot(e2, cross(from, e1)) / determinant > 0;
}

/// All that light_pdf and environment_pdf say about a direction.
float density(const Scene& scene, Vec3 position, Vec3 direction) {
  float sum = environment_pdf(scene, position, direction);
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    Vec2 barycentric;
    if (meet(scene.geometry(), triangle, position, direction, barycentric))
      sum += light_pdf(scene, position, surface_point(scene, triangle, barycentric));
  }
  return sum;
}

TEST_P(LightSampling, FollowsItsDensity) {
  const Scene scene(lit_floor(GetParam()));
  const Vec3 position = {0.1f, 0.2f, 0.05f};
  const auto direction = [&](int i) -> std::optional<Vec3> {
    const LightSample s = light_sample(scene, position, static_cast<std::uint32_t>(i));
    if (s.pdf == 0 || s.delta) return std::nullopt;
    return s.direction;
  };
  const auto result = chi_squared_sphere_of_jumps(
      direction, [&](Vec3 w) { return density(scene, position, w); }, 40000);
  EXPECT_LT(result.integral, 1 + 1e-3);
  expect_fit(result.p_value, kCases, light_case_name(GetParam()));
}

TEST_P(LightSampling, SamplesAgreeWithTheDensityFunctions) {
  const Scene scene(lit_floor(GetParam()));
  const Vec3 position = {0.1f, 0.2f, 0.05f};
  int compared = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const LightSample s = light_sample(scene, position, i);
    if (s.pdf == 0) continue;
    EXPECT_NEAR(length(s.direction), 1, 1e-5f);
    EXPECT_TRUE(is_finite(s.radiance));
    if (s.delta) continue;
    if (std::isfinite(s.distance)) {
      float pdf = 0;
      for (const std::uint32_t triangle : scene.emissive_triangles()) {
        Vec2 barycentric;
        if (!meet(scene.geometry(), triangle, position, s.direction, barycentric)) continue;
        const SurfacePoint on_light = surface_point(scene, triangle, barycentric);
        if (std::abs(length(on_light.position - position) - s.distance) > 1e-4f) continue;
        pdf = light_pdf(scene, position, on_light);
      }
      if (pdf == 0) continue;  // on an edge, by rounding
      EXPECT_NEAR(s.pdf / pdf, 1, 1e-3f);
    } else {
      EXPECT_EQ(s.pdf, environment_pdf(scene, position, s.direction));
      EXPECT_EQ(s.radiance, environment_radiance(scene, s.direction));
    }
    ++compared;
  }
  const bool has_area = GetParam() != LightCase::point && GetParam() != LightCase::spot &&
                        GetParam() != LightCase::gltf_spot && GetParam() != LightCase::quartic_spot &&
                        GetParam() != LightCase::sun && GetParam() != LightCase::luminaire &&
                        GetParam() != LightCase::luminaire_up && GetParam() != LightCase::luminaire_right;
  EXPECT_EQ(compared > 100, has_area);
}

INSTANTIATE_TEST_SUITE_P(Lights, LightSampling, ::testing::ValuesIn(light_cases()),
                         [](const auto& info) { return light_case_name(info.param); });

/// Irradiance at the origin's floor point, estimated without anything in the way.
struct Irradiance {
  RunningMean red, green, blue;
};
Irradiance irradiance(const Scene& scene, Vec3 position, Vec3 normal, int samples) {
  Irradiance sum;
  for (int i = 0; i < samples; ++i) {
    const LightSample s = light_sample(scene, position, static_cast<std::uint32_t>(i));
    const RGB value = s.pdf > 0 ? s.radiance * (std::max(dot(s.direction, normal), 0.0f) / s.pdf) : RGB(0.0f);
    sum.red.add(value.r);
    sum.green.add(value.g);
    sum.blue.add(value.b);
  }
  return sum;
}

constexpr int kIrradianceTests = 24;

void expect_irradiance(const Irradiance& estimate, RGB expected) {
  expect_fit(estimate.red.z_test(expected.r), kIrradianceTests, "red");
  expect_fit(estimate.green.z_test(expected.g), kIrradianceTests, "green");
  expect_fit(estimate.blue.z_test(expected.b), kIrradianceTests, "blue");
}

/// Form factor from a point to a parallel rectangle whose one corner is right above it at distance 1, with sides a and
/// b (Modest, "Radiative Heat Transfer", configuration 13).
double corner_form_factor(double a, double b) {
  const double ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
  return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * std::acos(-1.0));
}

TEST(Irradiance, OfAPanelIsItsFormFactor) {
  const Scene scene(lit_floor(LightCase::panel));
  // The panel covers x from -0.25 to 0.75 and y from -0.5 to 1.5, two metres above.
  const double factor = corner_form_factor(0.125, 0.25) + corner_form_factor(0.125, 0.75) +
                        corner_form_factor(0.375, 0.25) + corner_form_factor(0.375, 0.75);
  expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 50000),
                    RGB(5, 4, 3) * static_cast<float>(std::acos(-1.0) * factor));
}

TEST(Irradiance, BehindAOneSidedPanelIsNone) {
  const Scene scene(lit_floor(LightCase::panel));
  for (std::uint32_t i = 0; i < 1000; ++i) EXPECT_EQ(light_sample(scene, {0, 0, 3}, i).pdf, 0);
}

TEST(Irradiance, OfATwoSidedPanelIsTheSameOnBothSides) {
  SceneDescription d = floor_description();
  add_quad(d, {-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0, add_emission(d, RGB(1, 2, 3), true));
  const Scene scene(std::move(d));
  const RGB expected = RGB(1, 2, 3) * static_cast<float>(4 * std::acos(-1.0) * corner_form_factor(1, 1));
  expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 50000), expected);
  expect_irradiance(irradiance(scene, {0, 0, 2}, {0, 0, -1}, 50000), expected);
}

TEST(Irradiance, OfAUniformSkyIsPiTimesItsRadiance) {
  const Scene scene(lit_floor(LightCase::sky));
  expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 50000), RGB(1, 2, 3) * kPi);
}

TEST(Irradiance, OfAWhiteImageIsPiWhateverItsMapping) {
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    SceneDescription d = floor_description();
    d.environment = image_environment(mapping);
    d.environment->scale = RGB(1.0f);
    for (RGB& texel : d.environment->pixels) texel = RGB(1.0f);
    const Scene scene(std::move(d));
    expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 50000), RGB(kPi));
  }
}

TEST(Irradiance, OfAPointFallsWithTheSquareOfTheDistance) {
  const Scene scene(lit_floor(LightCase::point));
  const float squared = 0.5f * 0.5f + 0.25f * 0.25f + 1;
  expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 100), RGB(3, 5, 7) * (1 / (squared * std::sqrt(squared))));
}

TEST(Irradiance, OfASunIsItsIrradianceTimesTheCosine) {
  const Scene scene(lit_floor(LightCase::sun));
  expect_irradiance(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 100), RGB(4, 3, 2) * -sun_light().direction.z);
}

TEST(Irradiance, OfASpotFadesBetweenItsCones) {
  for (const auto& [light, falloff] : kSpotCases) {
    const Light spot = spot_light(falloff);
    const Scene scene(lit_floor(light));
    const Vec3 across = Frame::from_normal(spot.direction).s;
    for (const float angle : {0.0f, 0.2f, 0.5f, 0.6f, 0.8f}) {
      const Vec3 direction = spot.direction * std::cos(angle) + across * std::sin(angle);
      const LightSample s = light_sample(scene, spot.position + direction * 2, 1);
      const float t = (std::cos(angle) - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
      const float between = falloff == SpotFalloff::smoothstep  ? 3 * t * t - 2 * t * t * t
                            : falloff == SpotFalloff::quadratic ? t * t
                                                                : t * t * t * t;
      const float fade = angle < 0.3f ? 1 : angle > 0.7f ? 0 : between;
      EXPECT_NEAR(s.radiance.r, 30 * fade / 4, 2e-5f);
      EXPECT_EQ(s.pdf > 0, fade > 0);
    }
  }
}

TEST(LightNames, AreThoseOfTheSceneOrTheKind) {
  SceneDescription d = lit_floor(LightCase::all);
  d.lights[0].name = "bulb";
  const Scene scene(std::move(d));
  const auto lights = static_cast<std::uint32_t>(scene.emissive_triangles().size());
  EXPECT_EQ(light_source_name(scene, 0), "area light");
  EXPECT_EQ(light_source_name(scene, lights), "bulb");
  EXPECT_EQ(light_source_name(scene, lights + 1), "spot light");
  EXPECT_EQ(light_source_name(scene, lights + 2), "directional light");
  EXPECT_EQ(light_source_name(scene, lights + 3), "luminaire");
  EXPECT_EQ(light_source_name(scene, lights + 4), "environment");
}

}  // namespace
}  // namespace glowworm
