// Photon mapping against path tracing in mostly indirect light: equal means, and less error with more work.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

RenderSettings indirect(RenderSettings settings) {
  settings.indirect_only = true;
  return settings;
}

/// Mean luminance of the indirect light and the standard error of that, over renders of seeds of their own.
struct Estimate {
  double mean = 0, standard_error = 0;
};

Estimate estimate(const Stage& stage, RenderSettings settings, std::uint32_t renders) {
  double sum = 0, squares = 0;
  for (std::uint32_t i = 0; i < renders; ++i) {
    settings.seed = 100 + i;
    const double m = mean(stage.render(settings), true).luminance();
    sum += m;
    squares += m * m;
  }
  const double n = renders, average = sum / n;
  return {average, std::sqrt(std::max(0.0, squares / n - average * average) / (n - 1))};
}

/// Within 1% at a confidence of 99.7%: the ratio lies within 0.01 with three of its standard errors to spare.
TEST(SlowIndirectLight, HasTheMeanOfThePathTracer) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings path = indirect(by_path(0, 512)), photon = indirect(by_photons(0, 8, 16, 1'000'000, "blocked"));
  photon.nearest = 25;
  for (RenderSettings* settings : {&path, &photon}) {
    settings->width = 32;
    settings->height = 24;
  }
  const Estimate truth = estimate(stage, path, 6), found = estimate(stage, photon, 6);
  const double ratio = found.mean / truth.mean;
  const double error = ratio * std::hypot(truth.standard_error / truth.mean, found.standard_error / found.mean);
  printf("mean luminance ratio %.4f +- %.4f\n", ratio, error);
  EXPECT_LT(std::abs(ratio - 1) + 3 * error, 0.01);
}

/// Root of the mean relative squared error of the indirect light against a reference.
double relative_rmse(const std::vector<RGB>& found, const std::vector<RGB>& reference) {
  const double floor = 0.1 * mean(reference).luminance();
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double difference = found[i][c] - reference[i][c];
      sum += difference * difference / (double(reference[i][c]) * reference[i][c] + floor * floor);
    }
  return std::sqrt(sum / (3 * static_cast<double>(found.size())));
}

double relative_rmse(const Film& film, const std::vector<RGB>& reference) {
  return relative_rmse(pixels(film, true), reference);
}

/// Root of the mean of the squared errors of several seeds: photons of one seed may be lucky.
double relative_rmse_of_seeds(const Stage& stage, RenderSettings settings, const std::vector<RGB>& reference) {
  constexpr std::uint32_t kSeeds = 4;
  double squares = 0;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    settings.seed = seed;
    const double error = relative_rmse(stage.render(indirect(settings)), reference);
    squares += error * error;
  }
  return std::sqrt(squares / kSeeds);
}

class Convergence : public testing::TestWithParam<const char*> {};

TEST_P(Convergence, ErrorFallsWithPhotonsAndWithGatherRays) {
  const Stage stage(builtin_scene(GetParam()));
  const std::vector<RGB> reference = pixels(stage.render(indirect(by_path(12, 16384))), true);
  double last = 1e9;
  for (const std::uint64_t photons : {500u, 4'000u, 32'000u, 256'000u}) {
    const double error = relative_rmse_of_seeds(stage, by_photons(12, 64, 64, photons, "blocked"), reference);
    printf("%s, %llu photons: relative RMSE %.4f\n", GetParam(), static_cast<unsigned long long>(photons), error);
    EXPECT_LT(error, last) << photons << " photons";
    last = error;
  }
  last = 1e9;
  for (const std::uint32_t gather : {4u, 32u, 256u}) {
    const double error =
        relative_rmse(stage.render(indirect(by_photons(12, 4, gather, 256'000, "blocked"))), reference);
    printf("%s, %u gather rays: relative RMSE %.4f\n", GetParam(), gather, error);
    EXPECT_LT(error, last) << gather << " gather rays";
    last = error;
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, Convergence, testing::Values("cornell", "ajar"),
                         [](const auto& info) { return std::string(info.param); });

/// The secondary gather reduces the error in corners, where photons blur most. Compares the pixels that it changes,
/// with the same photons and the same first rays.
TEST(SlowSecondaryGather, ReducesTheErrorInCorners) {
  const Stage stage(builtin_scene("cornell"));
  const std::vector<RGB> reference = pixels(stage.render(indirect(by_path(16, 2048))), true);
  for (const char* engine : {"knn", "blocked"}) {
    RenderSettings settings = indirect(by_photons(16, 16, 64, 2'000, engine));
    const std::vector<RGB> with = pixels(stage.render(settings), true);
    settings.secondary_gather = false;
    const std::vector<RGB> without = pixels(stage.render(settings), true);
    std::vector<RGB> corners, with_gather, without_gather;
    for (std::size_t i = 0; i < with.size(); ++i) {
      if (std::abs(luminance(with[i]) / luminance(without[i]) - 1) < 0.01) continue;
      corners.push_back(reference[i]);
      with_gather.push_back(with[i]);
      without_gather.push_back(without[i]);
    }
    ASSERT_GT(corners.size(), 10u) << engine;
    const double with_error = relative_rmse(with_gather, corners),
                 without_error = relative_rmse(without_gather, corners);
    printf("%s, %zu pixels: relative RMSE %.4f with secondary gather, %.4f without\n", engine, corners.size(),
           with_error, without_error);
    EXPECT_LT(with_error, without_error) << engine;
  }
}

/// A glossy floor whose pixels reflect a spot of a lit wall that is smaller than the photons' discs. With a secondary
/// gather, their noise is not that of a few photons, and their mean is that of paths.
TEST(SlowSecondaryGather, TakesPhotonNoiseFromGlossyReflections) {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[1].kind = MaterialKind::conductor;
  d.materials[1].use_reflectance = true;
  d.materials[1].roughness_u.value = d.materials[1].roughness_v.value = 0.15f;
  add_quad(d, {-2, -1, -2}, {4, 0, 0}, {0, 0, 4});
  add_quad(d, {-2, 0, 0}, {4, 0, 0}, {0, 2, 0}, 1);
  d.lights.push_back(point_light());
  d.lights.back().position = {0, 0.5f, 1.5f};
  d.cameras.push_back(square_view({0, 1, 0}, normalize({0, 1, 0.6f}), 2, 0.1f));
  const Stage stage(std::move(d));
  RenderSettings settings = indirect(by_photons(4, 64, 16, 500, "blocked"));
  settings.guiding = false;
  const Estimate with = estimate(stage, settings, 12);
  settings.secondary_gather = false;
  const Estimate without = estimate(stage, settings, 12), paths = estimate(stage, indirect(by_path(4, 4096)), 4);
  EXPECT_LT(with.standard_error, 0.5 * without.standard_error);
  EXPECT_NEAR(with.mean, paths.mean, 4 * std::hypot(with.standard_error, paths.standard_error));
}

/// A corner of three half-metallic mirrors of which a lamp lights one: what a secondary ray meets is chosen
/// independently of what the ray before it met.
TEST(SlowSecondaryGather, ChoosesLobesIndependently) {
  SceneDescription d;
  Material half_metal;
  half_metal.kind = MaterialKind::metallic_roughness;
  half_metal.reflectance.value = RGB(0.9f);
  half_metal.metallic.value = 0.5f;
  half_metal.roughness_u.value = half_metal.roughness_v.value = 0;
  d.materials.push_back(half_metal);
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add_quad(d, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  add_quad(d, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  Light lamp;
  lamp.kind = LightKind::spot;
  lamp.position = {0.5f, 0.5f, 3};
  lamp.direction = {0, 0, -1};
  lamp.intensity = RGB(20.0f);
  lamp.cos_inner = std::cos(0.1f);
  lamp.cos_outer = std::cos(0.14f);
  d.lights.push_back(lamp);
  d.cameras.push_back(square_view({0, 0.05f, 0.2f}, {1, 0, 0}, 2, 0.1f));
  const Stage stage(std::move(d));
  RenderSettings settings = indirect(by_photons(4, 64, 16, 2'000, "blocked"));
  settings.guiding = false;
  // Each sample of the path tracer has photons of its own, of the light by mirrors.
  const Estimate gathered = estimate(stage, settings, 12), paths = estimate(stage, indirect(by_path(4, 1024)), 4);
  EXPECT_NEAR(gathered.mean, paths.mean, 4 * std::hypot(gathered.standard_error, paths.standard_error));
  EXPECT_LT(gathered.standard_error, 0.03 * paths.mean);
}

}  // namespace
}  // namespace glowworm
