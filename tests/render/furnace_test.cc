// Closed scenes: where every surface emits 1 and reflects half, radiance is 2 everywhere.
#include <gtest/gtest.h>

#include "render/render_testing.h"
#include "scene/builtin.h"

namespace glowworm {
namespace {

/// Emission over one minus albedo.
constexpr double kFurnace = 2;
constexpr double kTolerance = 0.005;

void expect_furnace(const Film& film) {
  const Mean found = mean(film);
  for (const double v : found.value) EXPECT_NEAR(v / kFurnace, 1, kTolerance);
}

class Furnace : public testing::TestWithParam<const char*> {};

TEST_P(Furnace, ByPathTracing) {
  const Stage stage(builtin_scene(GetParam()));
  expect_furnace(stage.render(by_path(16, 256)));
}

TEST_P(Furnace, ByPhotonMappingWithKnn) {
  const Stage stage(builtin_scene(GetParam()));
  RenderSettings settings = by_photons(16, 4, 25, 200'000, "knn");
  settings.nearest = 20;
  expect_furnace(stage.render(settings));
}

TEST_P(Furnace, ByPhotonMappingWithBlocked) {
  const Stage stage(builtin_scene(GetParam()));
  RenderSettings settings = by_photons(16, 4, 25, 200'000, "blocked");
  settings.nearest = 20;
  expect_furnace(stage.render(settings));
}

/// The gathered light by itself. At edges a part of the kernels lies beyond the surface: the estimate loses about 0.7
/// radii times the length of the edges over the area, so the radii must be small.
TEST_P(Furnace, IndirectLightAlone) {
  const Stage stage(builtin_scene(GetParam()));
  for (const char* engine : {"knn", "blocked"}) {
    RenderSettings settings = by_photons(16, 4, 25, 1'000'000, engine);
    settings.nearest = 16;
    settings.indirect_only = true;
    const Mean found = mean(stage.render(settings), true);
    for (const double v : found.value) EXPECT_NEAR(v, 0.5, 0.5 * kTolerance) << engine;
  }
}

INSTANTIATE_TEST_SUITE_P(Closed, Furnace, testing::Values("furnace-box", "furnace-sphere"),
                         [](const auto& info) { return std::string(info.param) == "furnace-box" ? "box" : "sphere"; });

}  // namespace
}  // namespace glowworm
