// Guided gather rays: less noise in rooms lit through an opening, and the same light.
#include "maps/gather_guiding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

/// Two renders of the same photons with independent gather rays.
struct Halves {
  Film first, second;

  Halves(const Stage& stage, RenderSettings settings)
      : first(stage.render(share(settings, 1))), second(stage.render(share(settings, 2))) {}

  static RenderSettings share(RenderSettings settings, std::uint32_t index) {
    settings.part = {index, 2};
    return settings;
  }
  double light() const { return (mean(first).luminance() + mean(second).luminance()) / 2; }
  /// Variance of light(), from the spread of the samples.
  double variance() const {
    double sum = 0;
    for (std::size_t i = 0; i < first.pixel_count(); ++i) sum += first.variance(i) + second.variance(i);
    return sum / 4 / std::pow(static_cast<double>(first.pixel_count()), 2);
  }
  /// Mean squared relative difference of pixels, without the worst 2%.
  double noise() const {
    std::vector<double> squares;
    for (std::size_t i = 0; i < first.pixel_count(); ++i) {
      const double a = luminance(first.radiance(i, false)), b = luminance(second.radiance(i, false));
      squares.push_back((a - b) * (a - b) / ((a + b) * (a + b) / 4 + 0.01));
    }
    std::sort(squares.begin(), squares.end());
    squares.resize(squares.size() * 49 / 50);
    return std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size());
  }
};

TEST(SlowGatherGuiding, LowersTheNoiseAndKeepsTheLight) {
  const Stage stage(builtin_scene("ajar"));
  RenderSettings settings = by_photons(64, 32, 25, 100'000, "blocked");
  const Halves guided(stage, settings);
  settings.gather_guiding = false;
  const Halves plain(stage, settings);
  const double error = std::sqrt(guided.variance() + plain.variance());
  EXPECT_NEAR(guided.light(), plain.light(), 4 * error) << "four standard errors";
  EXPECT_LT(4 * error, 0.02 * plain.light()) << "the test above finds 2%";
  EXPECT_LT(guided.noise(), 0.6 * plain.noise());
}

/// The guide of a small picture of a built-in scene.
GatherGuide learned(const char* scene, int side, Statistics& statistics) {
  const Stage stage(builtin_scene(scene));
  MemoryBudget budget(std::uint64_t{1} << 30);
  PhotonMaps maps(budget);
  PhotonMapSettings photons;
  photons.photons = 50'000;
  maps.update(*stage.tracer, photons, statistics);
  PassSettings settings;
  settings.width = settings.height = side;
  settings.light_samples = 2;
  settings.secondary_gather = false;
  return learn_gather_guide(*stage.tracer, maps, stage.scene->camera(""), settings, budget, statistics);
}

TEST(GatherGuiding, DoesNotCountAmongTheRaysOfTheRender) {
  Statistics statistics;
  EXPECT_FALSE(learned("ajar", 128, statistics).empty());
  EXPECT_EQ(statistics.count(Counter::gather_rays), 0u);
}

TEST(GatherGuiding, IsLeftOutWhereItGainsLittle) {
  Statistics statistics;
  EXPECT_TRUE(learned("atrium", 64, statistics).empty());
}

}  // namespace
}  // namespace glowworm
