// Caustics of the photon map against light tracing: their energy, and the sharpness of their edges.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "builtin/builtin.h"
#include "caustic/light_traced.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

/// The scene seen straight from above, from under what stands on the floor or
/// between it.
Stage from_above(const char *name, const FloorSquare &square, float height) {
  SceneDescription scene = builtin_scene(name);
  scene.cameras = {square_view({square.x, 0, square.z}, {0, 1, 0}, height, square.side)};
  return Stage(std::move(scene));
}

/// The caustic layer as exitance: pi times radiance, since the floor is
/// diffuse. The mean of maps of several seeds, whose spread is its error.
FloorLight mapped_caustic(const Stage &stage, const FloorSquare &square, std::uint32_t maps) {
  RenderSettings settings = by_photons(square.pixels, 16, 1, 500'000, "blocked");
  FloorLight out;
  out.exitance.assign(static_cast<std::size_t>(square.pixels) * static_cast<std::size_t>(square.pixels), 0);
  double squares = 0;
  for (settings.seed = 0; settings.seed < maps; ++settings.seed) {
    const Film film = stage.render(settings);
    double flux = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      const double exitance = M_PI * luminance(film.mean(Film::Layer::caustic, i));
      out.exitance[i] += exitance / maps;
      flux += exitance * square.pixel_area();
    }
    out.flux += flux / maps;
    squares += flux * flux / maps;
  }
  out.standard_error = std::sqrt((squares - out.flux * out.flux) / (maps - 1));
  return out;
}

/// Metres over which the steepest edges rise from nothing to the brightest: the
/// mean over the steepest hundredth of steps between neighbours two pixels
/// apart.
double edge_width(const FloorLight &light, const FloorSquare &square) {
  std::vector<double> steps, values = light.exitance;
  const auto n = static_cast<std::size_t>(square.pixels);
  for (std::size_t y = 0; y < n; ++y)
    for (std::size_t x = 0; x + 2 < n; ++x) {
      steps.push_back(std::abs(light.exitance[y * n + x + 2] - light.exitance[y * n + x]));
      steps.push_back(std::abs(light.exitance[(x + 2) * n + y] - light.exitance[x * n + y]));
    }
  std::sort(steps.rbegin(), steps.rend());
  std::sort(values.rbegin(), values.rend());
  double step = 0, brightest = 0;
  for (std::size_t i = 0; i < steps.size() / 100; ++i) step += steps[i] / static_cast<double>(steps.size() / 100);
  for (std::size_t i = 0; i < values.size() / 100; ++i)
    brightest += values[i] / static_cast<double>(values.size() / 100);
  return brightest / step * 2 * square.side / square.pixels;
}

struct CausticCase {
  const char *scene;
  std::uint32_t paths;  // traced
  FloorSquare square;
  float height;  // of the camera, metres
};

class SlowCaustic : public testing::TestWithParam<CausticCase> {};

TEST_P(SlowCaustic, HasTheEnergyOfLightTracedAndItsEdges) {
  const CausticCase &c = GetParam();
  const Stage stage = from_above(c.scene, c.square, c.height);
  const FloorLight traced = trace_caustic(*stage.tracer, c.square, c.paths);
  const FloorLight mapped = mapped_caustic(stage, c.square, 12);
  const double true_width = edge_width(traced, c.square), width = edge_width(mapped, c.square);
  fmt::print(
      "{}: {:.5f} +- {:.5f} W traced, {:.5f} +- {:.5f} W mapped "
      "({:.4f}); edges {:.1f}, {:.1f} mm wide\n",
      c.scene, traced.flux, traced.standard_error, mapped.flux, mapped.standard_error, mapped.flux / traced.flux,
      1000 * true_width, 1000 * width);
  ASSERT_LT(traced.standard_error, 0.003 * traced.flux);
  ASSERT_LT(mapped.standard_error, 0.003 * traced.flux);
  EXPECT_NEAR(mapped.flux / traced.flux, 1, 0.01);
  EXPECT_LT(width, 1.5 * true_width);
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowCaustic,
                         testing::Values(CausticCase{"glass-sphere", 7'000'000, {0.18f, 0.1f, 0.6f, 64}, 0.12f},
                                         CausticCase{"ring", 12'000'000, {0, 0, 0.68f, 64}, 0.3f}),
                         [](const auto &info) { return std::string(info.param.scene) == "ring" ? "ring" : "ball"; });

// What each map leaves out is added elsewhere exactly once: scenes that one
// integrator alone can light in full.

SceneDescription ball_under(bool point_light) {
  SceneDescription scene = builtin_scene("glass-sphere");
  if (!point_light) return scene;
  for (std::uint32_t &emission : scene.geometry.emission) emission = kNone;
  scene.emissions.clear();
  Light light;
  light.position = {-0.7f, 2.0f, -0.4f};
  light.intensity = RGB(2);
  scene.lights.push_back(light);
  return scene;
}

/// A square lamp of 1.5 m side at a height of 2.5 m, facing down.
void add_lamp(SceneDescription &scene) {
  Emission emission;
  emission.radiance.value = RGB(3);
  scene.emissions.push_back(emission);
  Geometry lamp;
  lamp.positions = {{-0.75f, 2.5f, -0.75f}, {0.75f, 2.5f, -0.75f}, {0.75f, 2.5f, 0.75f}, {-0.75f, 2.5f, 0.75f}};
  lamp.triangles = {{0, 1, 2}, {0, 2, 3}};
  lamp.uvs.resize(4);
  append_mesh(scene.geometry, lamp, "lamp", 0, static_cast<std::uint32_t>(scene.emissions.size() - 1));
}

struct Layers {
  double emitted = 0, direct = 0, indirect = 0, caustic = 0;
};

Layers layers(const Film &film) {
  Layers out;
  const double share = 1.0 / static_cast<double>(film.pixel_count());
  for (std::size_t i = 0; i < film.pixel_count(); ++i) {
    out.emitted += share * luminance(film.mean(Film::Layer::emitted, i));
    out.direct += share * luminance(film.mean(Film::Layer::direct, i));
    out.indirect += share * luminance(film.mean(Film::Layer::indirect, i));
    out.caustic += share * luminance(film.mean(Film::Layer::caustic, i));
  }
  return out;
}

TEST(SlowCausticLayers, OfAPointLightAreFoundByPathsAndPhotons) {
  const Stage stage(ball_under(true));
  const Layers paths = layers(stage.render(by_path(48, 64)));
  const Layers photons = layers(stage.render(by_photons(48, 16, 16, 300'000, "blocked")));
  EXPECT_GT(photons.caustic, 0.02 * photons.direct);
  // No ray meets a point: paths look up photons, too.
  EXPECT_NEAR(paths.caustic / photons.caustic, 1, 0.05);
  EXPECT_NEAR(photons.direct / paths.direct, 1, 0.01);
}

/// A lamp large enough for paths to meet it through the glass.
SceneDescription ball_under_large_lamp() {
  SceneDescription scene = ball_under(false);
  for (std::uint32_t &emission : scene.geometry.emission) emission = kNone;
  add_lamp(scene);
  return scene;
}

/// The emitted layer's mean over renders of several seeds, and its error.
std::pair<double, double> emitted_light(const Stage &stage, RenderSettings settings) {
  constexpr std::uint32_t kSeeds = 16;
  double sum = 0, squares = 0;
  for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
    const double value = layers(stage.render(settings)).emitted;
    sum += value / kSeeds;
    squares += value * value / kSeeds;
  }
  return {sum, std::sqrt((squares - sum * sum) / (kSeeds - 1))};
}

TEST(SlowCausticLayers, LampsAreSeenThroughGlassAlikeByPathsAndPhotons) {
  const Stage stage(ball_under_large_lamp());
  // The lamp's image in the glass is a few pixels, which take many camera samples: the ball alone is rendered.
  RenderSettings photons = by_photons(32, 1024, 1, 2000, "blocked"), paths = by_path(32, 1024);
  photons.guiding = false;
  photons.bounds = paths.bounds = {8, 4, 20, 21};
  const auto [path, path_error] = emitted_light(stage, paths);
  const auto [photon, photon_error] = emitted_light(stage, photons);
  fmt::print("emitted: paths {:.6f} +- {:.6f}, photons {:.6f} +- {:.6f}\n", path, path_error, photon, photon_error);
  ASSERT_LT(path_error + photon_error, 0.03 * path);
  // 4 standard errors: a false alarm in 16,000 runs of other seeds.
  EXPECT_NEAR(photon, path, 4 * std::hypot(path_error, photon_error));
}

TEST(SlowCausticLayers, OfALampAreTheSameByPathsAndPhotons) {
  const Stage stage(ball_under_large_lamp());
  const Layers paths = layers(stage.render(by_path(48, 2048)));
  const Layers photons = layers(stage.render(by_photons(48, 32, 16, 1'000'000, "blocked")));
  fmt::print(
      "paths {:.5f} {:.5f} {:.5f} {:.5f}, photons {:.5f} {:.5f} {:.5f} "
      "{:.5f}\n",
      paths.emitted, paths.direct, paths.indirect, paths.caustic, photons.emitted, photons.direct, photons.indirect,
      photons.caustic);
  EXPECT_NEAR(photons.direct / paths.direct, 1, 0.01);
  EXPECT_NEAR(photons.caustic / paths.caustic, 1, 0.03);
  EXPECT_NEAR(photons.indirect / paths.indirect, 1, 0.03);
}

/// The caustic layer of pictures: its flux, and the squared error of its pixels.
struct CausticError {
  double flux = 0, standard_error = 0, squared = 0;
};

CausticError caustic_error(const Stage &stage, RenderSettings settings, const Film &reference) {
  constexpr std::uint32_t kSeeds = 8;
  double flux_squares = 0;
  CausticError out;
  for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
    const Film film = stage.render(settings);
    double flux = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      const double value = luminance(film.mean(Film::Layer::caustic, i));
      flux += value;
      out.squared += std::pow(value - luminance(reference.mean(Film::Layer::caustic, i)), 2);
    }
    out.flux += flux / kSeeds;
    flux_squares += flux * flux / kSeeds;
  }
  out.standard_error = std::sqrt((flux_squares - out.flux * out.flux) / (kSeeds - 1));
  return out;
}

TEST(SlowCausticPaths, OfFewPhotonsIsMadeOfMorePaths) {
  const Stage stage(builtin_scene("ring"));
  RenderSettings settings = by_photons(64, 32, 25, 2'000'000, "blocked");
  const Film reference = stage.render(settings);
  settings.samples = 4;
  settings.photons = 20'000;
  settings.guiding = false;
  const CausticError more = caustic_error(stage, settings, reference);
  // A pass of a progressive render has the photons of that pass alone.
  settings.progressive = true;
  const CausticError alone = caustic_error(stage, settings, reference);
  EXPECT_GT(alone.flux, 0);
  EXPECT_NEAR(more.flux, alone.flux, 4 * std::hypot(more.standard_error, alone.standard_error));
  EXPECT_LT(more.squared, 0.8 * alone.squared);
}

}  // namespace
}  // namespace glowworm
