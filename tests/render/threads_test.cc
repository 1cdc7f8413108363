// The same picture, bit for bit, for any number of threads.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "core/parallel.h"
#include "density/engine.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

void expect_same_picture(const Stage& stage, const RenderSettings& settings) {
  set_thread_count(1);
  const Film film = stage.render(settings);
  set_thread_count(2);
  EXPECT_TRUE(film.save() == stage.render(settings).save());
  set_thread_count(0);
  EXPECT_GT(mean(film, settings.indirect_only).luminance(), 0);
  EXPECT_EQ(film.not_finite(), 0u);
}

TEST(Threads, DoNotChangeTracedPaths) {
  for (const char* name : {"cornell", "glass-sphere", "window-room"})
    expect_same_picture(Stage(builtin_scene(name)), by_path(40, 8));
}

TEST(Threads, DoNotChangePhotonMappingOfAnyEngine) {
  const Stage cornell(builtin_scene("cornell")), glass(builtin_scene("glass-sphere"));
  for (const std::string& engine : engine_names()) {
    // Brute force goes over all pairs: it gets few of them.
    const bool brute = engine == "brute";
    const RenderSettings settings = by_photons(brute ? 8 : 24, 2, brute ? 4 : 16, brute ? 500 : 10'000, engine.c_str());
    SCOPED_TRACE(engine);
    expect_same_picture(cornell, settings);
    expect_same_picture(glass, settings);
  }
}

TEST(Threads, DoNotChangeThePhotonsShownOrAProgressiveRender) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(40, 2, 16, 20'000, "blocked");
  settings.progressive = true;
  expect_same_picture(stage, settings);
  settings.integrator = Integrator::photons;
  expect_same_picture(stage, settings);
}

TEST(Threads, RepeatedRendersAreTheSameAndSeedsDiffer) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(24, 1, 16, 10'000, "knn");
  const std::vector<std::uint32_t> first = stage.render(settings).save();
  EXPECT_EQ(first, stage.render(settings).save());
  settings.seed = 1;
  EXPECT_NE(first, stage.render(settings).save());
}

}  // namespace
}  // namespace glowworm
