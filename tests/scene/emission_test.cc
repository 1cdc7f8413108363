// Emission of photons: flux and directions, and agreement with sample_light().
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "core/random.h"
#include "core/warp.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

/// The power of a light source in W (RGB), counted as in Scene::light_power().
RGB light_source_power(const Scene& scene, std::uint32_t source) {
  const std::size_t last = scene.source_powers().size() - 1;
  const auto parts = static_cast<float>(scene.light_source_count() - last);
  // Parts of the environment count as equal.
  return source < last ? scene.source_powers()[source] : scene.source_powers()[last] / parts;
}

constexpr int kLightCases = static_cast<int>(LightCase::count_);

EmittedPhoton photon(const Scene& scene, std::uint32_t i) {
  Sampler sampler(SamplerKind::independent, 31, 0, i);
  const float u_light = sampler.next1();
  const Vec2 u_position = sampler.next2();
  return sample_emission(scene, u_light, u_position, sampler.next2());
}

class EmissionTest : public ::testing::TestWithParam<LightCase> {};

/// Power in closed form, where it has one.
RGB expected_power(LightCase light, const Scene& scene) {
  const float disc = kPi * scene.radius() * scene.radius();
  const Light spot = spot_light(SpotFalloff::smoothstep);
  const float core = 1 - spot.cos_inner, edge = spot.cos_inner - spot.cos_outer;
  switch (light) {
    case LightCase::panel:
      return RGB(5, 4, 3) * (kPi * 2);
    case LightCase::two_sided:
      return RGB(1, 2, 3) * (2 * kPi * 1.5f * std::sqrt(1.04f));
    case LightCase::textured:  // means over the unit square of x, y^2 and the step
      return RGB(1.0f / 2, 1.0f / 3, 0.55f) * (6 * kPi * 2);
    case LightCase::point:
      return RGB(3, 5, 7) * (4 * kPi);
    case LightCase::spot:
      return spot.intensity * (2 * kPi * (core + edge / 2));
    case LightCase::gltf_spot:
      return spot.intensity * (2 * kPi * (core + edge / 3));
    case LightCase::quartic_spot:
      return spot.intensity * (2 * kPi * (core + edge / 5));
    case LightCase::sun:
      return RGB(4, 3, 2) * disc;
    case LightCase::sky:
      return RGB(1, 2, 3) * (4 * kPi * disc);
    default: {
      RGB sum(0.0f);
      for (std::uint32_t s = 0; s < scene.light_source_count(); ++s) sum += light_source_power(scene, s);
      return sum;
    }
  }
}

TEST_P(EmissionTest, MeanFluxIsThePowerOfAllLight) {
  const Scene scene(lit_floor(GetParam()));
  RGB power = expected_power(GetParam(), scene);
  // In the scene of all lights the textured panel's listed power is an estimate; its exact one takes its place.
  if (GetParam() == LightCase::all) {
    for (const std::uint32_t s : {4u, 5u}) power += light_source_power(scene, s) * -1.0f;
    power += expected_power(LightCase::textured, scene);
  }
  RunningMean flux[3];
  for (std::uint32_t i = 0; i < 40000; ++i) {
    const EmittedPhoton p = photon(scene, i);
    ASSERT_LT(p.light, scene.light_source_count());
    EXPECT_NEAR(length(p.direction), 1, 1e-5f);
    for (int c = 0; c < 3; ++c) flux[c].add(p.flux[c]);
  }
  for (int c = 0; c < 3; ++c) expect_fit(flux[c].z_test(power[c]), 3 * kLightCases, "flux");
}

TEST_P(EmissionTest, SourcesAreChosenByTheirPower) {
  const Scene scene(lit_floor(GetParam()));
  constexpr int samples = 40000;
  std::vector<double> observed(scene.light_source_count()), expected(observed.size());
  for (std::uint32_t i = 0; i < samples; ++i) ++observed[photon(scene, i).light];
  double total = 0;
  for (std::uint32_t s = 0; s < observed.size(); ++s) total += luminance(light_source_power(scene, s));
  EXPECT_NEAR(scene.light_power().total() / total, 1, 1e-5);
  for (std::uint32_t s = 0; s < observed.size(); ++s)
    expected[s] = samples * luminance(light_source_power(scene, s)) / total;
  expect_fit(chi_squared_counts(observed, expected).p_value, kLightCases, light_case_name(GetParam()));
}

TEST_P(EmissionTest, PhotonsBringWhatLightSamplesSee) {
  // Flux through a square metre of the floor's plane, with nothing in the way: by photons that cross it downwards, and
  // by irradiance at random places. Two estimates of one number.
  const Scene scene(lit_floor(GetParam()));
  RunningMean difference;
  for (std::uint32_t i = 0; i < 60000; ++i) {
    const EmittedPhoton p = photon(scene, i);
    double by_photon = 0;
    if (p.direction.z < 0 && p.origin.z > 0) {
      const Vec3 at = p.origin + p.direction * (-p.origin.z / p.direction.z);
      if (std::abs(at.x) < 0.5f && std::abs(at.y) < 0.5f) by_photon = luminance(p.flux);
    }
    Sampler sampler(SamplerKind::independent, 32, 0, i);
    const Vec2 place = sampler.next2();
    const float u_light = sampler.next1();
    const LightSample s = sample_light(scene, {place.x - 0.5f, place.y - 0.5f, 0}, u_light, sampler.next2());
    difference.add(by_photon - (s.pdf > 0 ? luminance(s.radiance) * std::max(s.direction.z, 0.0f) / s.pdf : 0.0f));
  }
  expect_fit(difference.z_test(0), kLightCases, light_case_name(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Lights, EmissionTest, ::testing::ValuesIn(light_cases()),
                         [](const auto& info) { return light_case_name(info.param); });

constexpr int kDirectionTests = 7;

template <class Density>
void expect_directions(LightCase light, const Density& density) {
  const Scene scene(lit_floor(light));
  const auto result = chi_squared_sphere_of_jumps(
      [&](int i) -> std::optional<Vec3> { return photon(scene, static_cast<std::uint32_t>(i)).direction; }, density,
      40000);
  EXPECT_NEAR(result.integral, 1, 2e-3);
  expect_fit(result.p_value, kDirectionTests, light_case_name(light));
}

TEST(EmissionDirections, PanelIsCosineWeighted) {
  expect_directions(LightCase::panel, [](Vec3 w) { return cosine_hemisphere_pdf(-w.z); });
}
TEST(EmissionDirections, TwoSidedPanelIsCosineWeightedOnBothSides) {
  const Vec3 n = normalize(cross(Vec3{0, 1.5f, 0}, Vec3{0.2f, 0, 1}));
  expect_directions(LightCase::two_sided, [&](Vec3 w) { return std::abs(dot(n, w)) * kInversePi / 2; });
}
TEST(EmissionDirections, PointIsUniform) {
  expect_directions(LightCase::point, [](Vec3) { return kUniformSpherePdf; });
}
TEST(EmissionDirections, SpotFollowsItsFalloffUpToItsWeight) {
  for (const auto& [light, falloff] : kSpotCases) {
    const Light spot = spot_light(falloff);
    const int power = falloff == SpotFalloff::smoothstep ? 1 : falloff == SpotFalloff::quadratic ? 2 : 4;
    const float edge = (spot.cos_inner - spot.cos_outer) / static_cast<float>(power + 1);
    const float whole = 2 * kPi * (1 - spot.cos_inner + edge);
    expect_directions(light, [&](Vec3 w) {
      const float t = (dot(w, spot.direction) - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
      if (t <= 0) return 0.0f;
      return (t >= 1 ? 1.0f : std::pow(t, static_cast<float>(power))) / whole;
    });
  }
}
TEST(EmissionDirections, EnvironmentFollowsItsDensity) {
  for (const LightCase light : {LightCase::lat_long, LightCase::equal_area}) {
    const Scene scene(lit_floor(light));
    expect_directions(light, [&](Vec3 w) { return environment_pdf(scene, {}, -w); });
  }
}

TEST(EmissionOrigins, LightFromAfarStartsBeforeTheScene) {
  for (const LightCase light : {LightCase::sun, LightCase::sky, LightCase::lat_long}) {
    const Scene scene(lit_floor(light));
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const EmittedPhoton p = photon(scene, i);
      EXPECT_NEAR(dot(p.origin - scene.center(), p.direction), -scene.radius(), 1e-4f);
    }
  }
}

TEST(EmissionOrigins, PanelPhotonsStartOnItsFront) {
  const Scene scene(lit_floor(LightCase::panel));
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Vec3 origin = photon(scene, i).origin;
    EXPECT_LT(origin.z, 2);
    EXPECT_NEAR(origin.z, 2, 1e-3f);
    EXPECT_GE(origin.x, -0.25f - 1e-4f);
    EXPECT_LE(origin.x, 0.75f + 1e-4f);
  }
}

// Thousands of triangles that show the whole of an image each, as of a lamp's glass, take no longer for that.
TEST(TexturedEmission, IsReadAtABoundedNumberOfPoints) {
  constexpr int kQuads = 1000;
  std::atomic<std::uint64_t> points{0};
  SceneDescription d = floor_description();
  d.textures.push_back(image_node([&](Vec2 uv) {
    points.fetch_add(1, std::memory_order_relaxed);
    return RGB(uv.x);
  }));
  d.textures.back().uv_scale = {4, 4};
  const std::uint32_t emission = add_emission(d, RGB(1.0f), false, 0);
  for (int i = 0; i < kQuads; ++i)
    add_quad(d, {0, 0, static_cast<float>(i + 1)}, {0.25f, 0, 0}, {0, 0.25f, 0}, 0, emission);
  const Scene scene(std::move(d));
  EXPECT_LE(points, 20'000'000u);
  EXPECT_GE(points, 2 * kQuads * 10u);
  // The mean of 4 u, as the image is a function that does not repeat.
  EXPECT_NEAR(scene.light_power().total(), kQuads * kPi * 0.0625f * 2, 0.02f * kQuads * kPi * 0.0625f * 2);
}

TEST(TexturedEmission, MakesLightsOfTrianglesThatAreNotBlack) {
  // Eight squares in a row over one texture, whose third square alone has a lit spot: a single texel of 64.
  SceneDescription d = floor_description();
  d.textures.push_back(image_node([](Vec2 uv) {
    const Vec2 texel{uv.x * 64, uv.y * 64};
    return std::abs(texel.x - 20) < 1 && std::abs(texel.y - 30) < 1 ? RGB(1.0f) : RGB(0.0f);
  }));
  const std::uint32_t emission = add_emission(d, RGB(4.0f), false, 0);
  for (int i = 0; i < 8; ++i) {
    add_quad(d, {static_cast<float>(i), 0, 2}, {0, 1, 0}, {1, 0, 0}, 0, emission);
    for (int k = 0; k < 4; ++k) {
      Vec2& uv = d.geometry.uvs[d.geometry.uvs.size() - 1 - static_cast<std::size_t>(k)];
      uv = {(static_cast<float>(i) + uv.x) / 8, uv.y};
    }
  }
  const Scene scene(std::move(d));
  // Place 20 of 64 is in square 2; the spot lies in one triangle of it, or reaches over its diagonal.
  ASSERT_GE(scene.emissive_triangles().size(), 1u);
  ASSERT_LE(scene.emissive_triangles().size(), 2u);
  for (const std::uint32_t t : scene.emissive_triangles()) EXPECT_EQ((t - 2) / 2, 2u);
  EXPECT_TRUE(scene.notes().empty() || scene.notes().front().find("sky") == std::string::npos);
}

}  // namespace
}  // namespace glowworm
