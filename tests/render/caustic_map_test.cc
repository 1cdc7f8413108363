// Photons emitted for the caustic map alone, towards what makes caustics: less noise, and the same light.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "builtin/builtin.h"
#include "maps/photon_maps.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

constexpr int kSide = 96;

/// Irradiance, in W m^-2, of a grid of points in the caustic below the glass sphere.
std::vector<double> caustic_light(const Stage& stage, std::uint32_t seed, std::uint64_t more_paths) {
  MemoryBudget budget(std::uint64_t{1} << 30);
  PhotonMaps maps(budget);
  PhotonMapSettings settings;
  settings.photons = 50'000;
  settings.seed = seed;
  settings.more_caustic_paths = more_paths;
  Statistics statistics;
  maps.update(*stage.tracer, settings, statistics);
  QueryPoints points;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      points.push_back({-0.4f + 0.8f * static_cast<float>(x) / kSide, 0, -0.4f + 0.8f * static_cast<float>(y) / kSide},
                       {0, 1, 0}, RGB(1.0f), RGB(1.0f), 0);
  std::vector<RGB> radiance(points.size());
  for (const auto& engine : maps.caustic_engines()) engine->estimate(points, radiance, statistics);
  std::vector<double> light;
  for (const RGB& r : radiance) light.push_back(kPi * luminance(r));
  return light;
}

struct Spread {
  double mean = 0, variance = 0;  ///< of the mean over points
  double noise = 0;               ///< squared differences of points between seeds, in relation to the mean of light
};

Spread spread(const Stage& stage, std::uint64_t more_paths) {
  constexpr std::uint32_t kSeeds = 12;
  Spread out;
  double squares = 0;
  std::vector<double> before;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> light = caustic_light(stage, seed, more_paths);
    double sum = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      sum += light[i];
      if (!before.empty()) out.noise += (light[i] - before[i]) * (light[i] - before[i]);
    }
    sum /= static_cast<double>(light.size());
    out.mean += sum / kSeeds;
    squares += sum * sum / kSeeds;
    before = light;
  }
  out.variance = (squares - out.mean * out.mean) / (kSeeds - 1);
  out.noise /= out.mean * out.mean;
  return out;
}

TEST(SlowCausticMap, PathsTowardsCausticsLowerTheirNoiseAndKeepTheirLight) {
  const Stage stage(builtin_scene("glass-sphere"));
  const Spread one_pass = spread(stage, 0), more = spread(stage, 200'000);
  const double error = std::sqrt(one_pass.variance + more.variance);
  EXPECT_NEAR(more.mean, one_pass.mean, 4 * error) << "four standard errors";
  EXPECT_LT(4 * error, 0.05 * one_pass.mean) << "the test above finds 5%";
  EXPECT_LT(more.noise, 0.5 * one_pass.noise);
}

TEST(CausticMap, FewPathsAreNotWorthAPilot) {
  const Stage stage(builtin_scene("glass-sphere"));
  EXPECT_EQ(caustic_light(stage, 1, 1000), caustic_light(stage, 1, 0));
}

/// A lamp without size shines by a mirror onto glossy metal, whose light a diffuse wall gets. No ray from the wall
/// meets the lamp: photons bring its light to the metal, also where rays gather no second time because they are short.
TEST(CausticMap, BringsLightToGlossyEndsOfGatherRays) {
  SceneDescription d;
  d.materials.resize(3);
  for (const int metal : {0, 1}) {
    d.materials[metal].kind = MaterialKind::conductor;
    d.materials[metal].use_reflectance = true;
    d.materials[metal].reflectance.value = RGB(1.0f);
  }
  d.materials[1].roughness_u.value = d.materials[1].roughness_v.value = 0.2f;
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);  // a mirror as floor
  add_quad(d, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1);  // glossy, facing +y
  add_quad(d, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 2);  // diffuse, facing -y
  Light lamp;
  lamp.kind = LightKind::spot;
  lamp.position = {0.5f, 0.5f, 0.2f};
  lamp.direction = normalize(Vec3{0, -0.4f, -0.2f});
  lamp.cos_inner = 0.97f;
  lamp.cos_outer = 0.96f;
  d.lights.push_back(lamp);
  d.cameras.push_back(square_view({0.5f, 1, 0.5f}, {0, -1, 0}, 0.2f, 0.8f));
  const Stage stage(std::move(d));
  RenderSettings settings = by_photons(16, 16, 16, 200'000, "blocked");
  const double again = mean(stage.render(settings), true).luminance();
  settings.secondary_gather = false;
  EXPECT_GT(again, 0);
  EXPECT_NEAR(mean(stage.render(settings), true).luminance() / again, 1, 0.02);
}

/// A lamp shines down on a floor, and by an upright mirror on a patch of it, x from 0 to 1.33 m. The patch has some 30
/// of 4000 photons, so a disc of 100 caustic photons would reach .9 m beyond it.
TEST(CausticMap, FaintCausticsAreNotBlurredFarBeyondTheirEdges) {
  SceneDescription d;
  d.materials.resize(3);
  d.materials[1].kind = MaterialKind::conductor;
  d.materials[1].use_reflectance = true;
  d.materials[1].reflectance.value = RGB(1.0f);
  add_quad(d, {-4, 0, -4}, {0, 0, 8}, {8, 0, 0}, 0);                                             // faces +y
  add_quad(d, {2, 0.5f, -0.25f}, {0, 0, 0.5f}, {0, 0.5f, 0}, 1);                                 // faces -x
  add_quad(d, {-0.05f, 2, -0.05f}, {0.1f, 0, 0}, {0, 0, 0.1f}, 2, add_emission(d, RGB(10.0f)));  // faces -y
  const Stage stage(std::move(d));
  MemoryBudget budget(std::uint64_t{1} << 30);
  PhotonMaps maps(budget);
  PhotonMapSettings settings;
  settings.photons = 4000;
  Statistics statistics;
  maps.update(*stage.tracer, settings, statistics);
  QueryPoints points;
  for (const float x : {0.67f, -0.7f, -0.75f, -0.8f, -0.85f})
    points.push_back({x, 0, 0}, {0, 1, 0}, RGB(1.0f), RGB(1.0f), 0);
  std::vector<RGB> light(points.size());
  for (const auto& engine : maps.caustic_engines()) engine->estimate(points, light, statistics);
  EXPECT_GT(luminance(light[0]), 0);
  for (std::size_t i = 1; i < light.size(); ++i) EXPECT_EQ(luminance(light[i]), 0) << i;
}

}  // namespace
}  // namespace glowworm
