// Notes on automatically chosen settings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene.h"
#include "scene/scene_parts.h"
#include "settings/settings.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(ChoiceNotes, NameChosenSettingsAndNoGivenOnes) {
  const Scene scene(builtin_scene("cornell"));
  RenderSettings asked;
  asked.photons = 4000;
  asked.engine = "forward";
  const RenderSettings chosen = resolve(asked, scene);
  const std::vector<std::string> notes = choice_notes(asked, chosen);
  EXPECT_THAT(notes, Contains(HasSubstr(std::to_string(chosen.samples) + " samples")));
  EXPECT_THAT(notes, Contains(HasSubstr(std::to_string(chosen.gather) + " gather rays")));
  EXPECT_THAT(notes, Contains(HasSubstr("k = " + std::to_string(chosen.nearest))));
  EXPECT_THAT(notes, Not(Contains(HasSubstr("photons:"))));
  EXPECT_THAT(notes, Not(Contains(HasSubstr("engine"))));
}

TEST(ResolvedSettings, ThinPhotonsForTheReverseEngineAlone) {
  const Scene scene(builtin_scene("cornell"));
  RenderSettings asked;
  asked.thinned = 1000;
  EXPECT_EQ(resolve(asked, scene).thinned, 0u);
  asked.engine = "reverse";
  EXPECT_EQ(resolve(asked, scene).thinned, 1000u);
  asked.thinned = 0;
  EXPECT_EQ(resolve(asked, scene).thinned, 0u);
}

TEST(ResolvedSettings, FewGatherRaysTakeFewPhotons) {
  const Scene scene(builtin_scene("cornell"));
  RenderSettings asked;
  asked.width = 128;
  asked.height = 100;
  asked.gather = 12;
  asked.samples = 4;
  EXPECT_EQ(resolve(asked, scene).photons, 300'000u) << "half of the rays";
  asked.samples = 8;
  EXPECT_EQ(resolve(asked, scene).photons, 500'000u);
  asked.progressive = true;
  EXPECT_EQ(resolve(asked, scene).photons, 500'000u) << "passes do not add up to one map";
  asked.progressive = false;
  asked.width = asked.height = 10;
  EXPECT_EQ(resolve(asked, scene).photons, 250'000u);
  asked.of_points = true;
  EXPECT_EQ(resolve(asked, scene).photons, 500'000u) << "sensors";
}

TEST(ResolvedSettings, PhotonsGrowWithSamplesThatAreKnown) {
  const Scene scene(builtin_scene("cornell"));
  RenderSettings asked;
  asked.width = asked.height = 512;
  const std::uint64_t usual = resolve(asked, scene).photons;
  asked.samples = 2 * kDefaultSamples;
  const RenderSettings more = resolve(asked, scene);
  EXPECT_NEAR(static_cast<double>(more.photons), 2.0 * static_cast<double>(usual), 0.1 * static_cast<double>(usual));
  EXPECT_THAT(choice_notes(asked, more), Contains(HasSubstr("at most 4000000")));
  asked.samples = 1000;
  EXPECT_EQ(resolve(asked, scene).photons, 4'000'000u);
  asked.progressive = true;
  EXPECT_LT(resolve(asked, scene).photons, usual) << "each pass has its own";
  asked.progressive = false;
  asked.samples = 0;
  asked.noise_target = 0.01;
  EXPECT_EQ(resolve(asked, scene).photons, usual);
}

TEST(ResolvedSettings, PhotonsOfSmallPicturesGrowWithSamplesAndTime) {
  const Scene scene(builtin_scene("cornell"));
  RenderSettings asked;
  asked.width = 128;
  asked.height = 72;
  asked.samples = 64;
  EXPECT_NEAR(static_cast<double>(resolve(asked, scene).photons), 1.2e6, 0.1e6);
  asked.of_points = true;
  EXPECT_EQ(resolve(asked, scene).photons, 500'000u) << "the noise of points is their own";
  asked.of_points = false;
  asked.samples = 0;
  asked.time_limit_s = 5;
  EXPECT_EQ(resolve(asked, scene).photons, 200'000u);
  asked.time_limit_s = 80;
  EXPECT_EQ(resolve(asked, scene).photons, 3'200'000u);
}

TEST(DefaultThreads, FitIntoTheMemory) {
  EXPECT_EQ(default_threads(1'000'000, 16), 1);
  EXPECT_EQ(default_threads(64'000'000, 1), 1);
  EXPECT_EQ(default_threads(64'000'000, 16), 2);
  EXPECT_EQ(default_threads(1'000'000'000, 16), 16);
  EXPECT_EQ(default_threads(1'000'000'000, 64), 31);
}

TEST(Choices, PicturesHaveTheShapeOfTheCameraOrTheFilm) {
  SceneDescription d = floor_description();
  d.cameras.push_back(square_view({0, 1, 0}, {0, -1, 0}, 1, 2));
  d.cameras.back().aspect = 2;
  d.cameras.push_back(d.cameras.back());
  d.cameras.back().name = "upright";
  d.cameras.back().aspect = 0.5f;
  const auto size = [&](const std::string& camera) {
    RenderSettings asked;
    asked.camera = camera;
    const RenderSettings chosen = resolve(asked, Scene(d));
    return std::pair(chosen.width, chosen.height);
  };
  EXPECT_EQ(size(""), std::pair(512, 256));
  EXPECT_EQ(size("upright"), std::pair(256, 512));
  d.film.width = 320, d.film.height = 200;
  EXPECT_EQ(size(""), std::pair(320, 200));
}

}  // namespace
}  // namespace glowworm
