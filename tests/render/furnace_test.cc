// Closed scenes: if every surface emits 1 and reflects half, radiance is 2 everywhere.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

/// Emission over one minus albedo.
constexpr double kFurnace = 2;
constexpr double kFurnaceTolerance = 0.005;

void expect_furnace(const Film& film) {
  const Mean found = mean(film);
  for (const double v : found.value) EXPECT_NEAR(v / kFurnace, 1, kFurnaceTolerance);
}

class Furnace : public testing::TestWithParam<const char*> {};

TEST_P(Furnace, ByPathTracing) {
  const Stage stage(builtin_scene(GetParam()));
  expect_furnace(stage.render(by_path(16, 256)));
}

/// At the settings that a render has by itself.
TEST_P(Furnace, ByPhotonMapping) {
  const Stage stage(builtin_scene(GetParam()));
  for (const char* engine : {"knn", "blocked"}) {
    SCOPED_TRACE(engine);
    expect_furnace(stage.render(by_photons(16, 4, 25, 500'000, engine)));
  }
}

/// Secondary gathers sample lights that touch the corners that they start in: no sample may be far off.
TEST(SlowFurnaceCorners, HaveNoBrightSpecks) {
  const Stage stage(builtin_scene("furnace-box"));
  for (const RGB& pixel : pixels(stage.render(by_photons(48, 16, 16, 100'000)))) EXPECT_NEAR(pixel.r, kFurnace, 0.2);
}

class SlowFurnace : public Furnace {};

/// The gathered light by itself, where nothing exact makes an error look smaller: the mean over four photon maps, whose
/// standard error is 0.13%.
TEST_P(SlowFurnace, IndirectLightAlone) {
  const Stage stage(builtin_scene(GetParam()));
  for (const char* engine : {"knn", "blocked"}) {
    RenderSettings settings = by_photons(16, 4, 25, 500'000, engine);
    settings.indirect_only = true;
    Mean sum{};
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
      settings.seed = seed;
      const Mean found = mean(stage.render(settings), true);
      for (int c = 0; c < 3; ++c) sum.value[c] += found.value[c] / 4;
    }
    for (const double v : sum.value) EXPECT_NEAR(v, 0.5, 0.5 * kFurnaceTolerance) << engine;
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowFurnace, testing::Values("furnace-box", "furnace-sphere"),
                         [](const auto& info) { return std::string(info.param) == "furnace-box" ? "box" : "sphere"; });
INSTANTIATE_TEST_SUITE_P(Closed, Furnace, testing::Values("furnace-box", "furnace-sphere"),
                         [](const auto& info) { return std::string(info.param) == "furnace-box" ? "box" : "sphere"; });

}  // namespace
}  // namespace glowworm
