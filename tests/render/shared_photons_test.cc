// Renders whose photons come from other processes have the bits of renders without them.
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

class SharedPhotonsTest : public FolderTest {
 protected:
  /// Renders alone, then by two processes at once, then by one that finds all.
  /// @param file beginning of the name of a file that they must share
  void expect_same_bits(const Stage& stage, RenderSettings settings, const std::string& file) const {
    const auto expected = stage.render(settings).save();
    settings.share = folder_;
    std::vector<std::uint32_t> bits[3];
    std::thread other([&] { bits[0] = stage.render(settings).save(); });
    bits[1] = stage.render(settings).save();
    other.join();
    const std::size_t files = count_files();
    EXPECT_GT(count_files(file), 0u);
    bits[2] = stage.render(settings).save();
    EXPECT_EQ(count_files(), files);
    for (const auto& own : bits) EXPECT_TRUE(own == expected);
  }

  std::size_t count_files(const std::string& beginning = "") const {
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
      files += entry.is_regular_file() && entry.path().filename().string().starts_with(beginning);
    return files;
  }
};

TEST_F(SharedPhotonsTest, OfACrowdOfPieces) {
  expect_same_bits(Stage(builtin_scene("cornell")), by_photons(16, 2, 4, 300'000, "blocked"), "global-factors.5-of-5");
}

TEST_F(SharedPhotonsTest, WhereGuidingPays) {
  // The next room is lit through a door ajar.
  expect_same_bits(Stage(builtin_scene("ajar")), by_photons(16, 2, 4, 20'000, "blocked"), "photon-guide");
}

TEST_F(SharedPhotonsTest, WithPathsTowardsCaustics) {
  RenderSettings settings = by_photons(64, 1, 64, 20'000, "blocked");
  settings.aovs = {"bias", "radius"};
  expect_same_bits(Stage(builtin_scene("glass-sphere")), settings, "photons-1-0");
}

TEST_F(SharedPhotonsTest, ThinnedAndOfOneRadius) {
  RenderSettings settings = by_photons(16, 1, 4, 10'000, "reverse");
  settings.fixed_radius = true;
  settings.thinned = 5000;
  expect_same_bits(Stage(builtin_scene("cornell")), settings, "photons-0");
}

TEST_F(SharedPhotonsTest, OfLightGroups) {
  RenderSettings settings = by_photons(16, 1, 4, 5000, "blocked");
  settings.light_groups = true;
  expect_same_bits(Stage(builtin_scene("atrium")), settings, "gather-guide");
}

TEST_F(SharedPhotonsTest, OfProgressiveRenders) {
  RenderSettings settings = by_photons(16, 3, 4, 5000, "blocked");
  settings.progressive = true;
  expect_same_bits(Stage(builtin_scene("cornell")), settings, "photons-0");
}

TEST_F(SharedPhotonsTest, RectanglesHaveThePhotonsOfTheWhole) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(16, 1, 4, 5000, "blocked");
  settings.share = folder_;
  stage.render(settings);
  const std::size_t files = count_files();
  settings.bounds = {4, 4, 8, 8};
  stage.render(settings);
  EXPECT_EQ(count_files(), files);
  settings.seed = 1;
  stage.render(settings);
  EXPECT_GT(count_files(), files);
}

TEST_F(SharedPhotonsTest, DoNotDependOnTheTime) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings;
  settings.width = settings.height = 32;
  settings.time_limit_s = 20;
  for (const bool shared : {false, true}) {
    if (shared) settings.share = folder_;
    Job job(stage.scene, stage.tracer, settings, nullptr, 19.999);
    job.wait();
    EXPECT_NE(job.is_fitted(), shared);
  }
}

}  // namespace
}  // namespace glowworm
