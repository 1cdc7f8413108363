// The noise of photon maps: predicted from one map, and seen in the spread of several.
#include "render/photon_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

/// The map shown directly, with little noise beside that of the photons.
RenderSettings few_photons(std::uint32_t seed, std::uint64_t photons) {
  RenderSettings settings = by_photons(48, 8, 0, photons, "blocked");
  settings.integrator = Integrator::photons;
  settings.seed = seed;
  return settings;
}

TEST(PhotonNoise, IsTheSpreadOfMapsWithOtherPhotons) {
  constexpr std::uint32_t kRenders = 24;
  const Stage stage(builtin_scene("cornell"));
  std::vector<std::vector<double>> pixels;
  double predicted = 0;
  for (std::uint32_t seed = 0; seed < kRenders; ++seed) {
    const Film film = stage.render(few_photons(seed, 4000));
    predicted += film.photon_variance() / kRenders;
    pixels.emplace_back();
    for (std::size_t i = 0; i < film.pixel_count(); ++i) pixels.back().push_back(luminance(film.radiance(i, false)));
  }
  const std::size_t count = pixels.front().size();
  std::vector<double> mean(count), variance(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::vector<double>& picture : pixels) mean[i] += picture[i] / kRenders;
    for (const std::vector<double>& picture : pixels)
      variance[i] += (picture[i] - mean[i]) * (picture[i] - mean[i]) / (kRenders - 1);
  }
  double level = 0, spread = 0;
  for (const double m : mean) level += m / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i)
    spread += variance[i] / (mean[i] * mean[i] + 0.01 * level * level) / static_cast<double>(count);
  EXPECT_NEAR(std::sqrt(predicted / spread), 1, 0.2);
}

TEST(PhotonNoise, FallsWithTheirNumber) {
  const Stage stage(builtin_scene("ajar"));
  const auto variance = [&](std::uint64_t photons) {
    RenderSettings settings = by_photons(64, 2, 16, photons, "blocked");
    double sum = 0;
    for (settings.seed = 0; settings.seed < 4; ++settings.seed) sum += stage.render(settings).photon_variance();
    return sum;
  };
  const double ratio = variance(5000) / variance(80'000);
  EXPECT_GT(ratio, 4) << "sixteen times the photons";
  EXPECT_LT(ratio, 64);
}

TEST(PhotonNoise, IsNotSharedWherePhotonsAreNot) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = few_photons(1, 4000);
  settings.progressive = true;
  EXPECT_EQ(stage.render(settings).photon_variance(), 0);
  EXPECT_EQ(stage.render(by_path(16, 2)).photon_variance(), 0);
}

TEST(PhotonNoise, OfPartsIsMeasuredByTheFirst) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(32, 2, 4, 20'000, "blocked");
  const Film measured = stage.render(settings);
  settings.part = {2, 2};
  const Film second = stage.render(settings);
  EXPECT_GT(measured.photon_variance(), 0);
  EXPECT_EQ(second.photon_variance(), 0) << "the first part measures";
  settings.part = {1, 2};
  Film merged = stage.render(settings);
  ASSERT_TRUE(merged.restore(second.save()));
  EXPECT_EQ(pixels(merged), pixels(measured));
  EXPECT_GT(merged.photon_variance(), 0);
}

TEST(PhotonNoise, OfADamagedFilmIsRefused) {
  const Stage stage(builtin_scene("cornell"));
  const Film film = stage.render(few_photons(1, 4000));
  std::vector<std::uint32_t> state = film.save();
  Film restored = film.like(film.bounds());
  ASSERT_TRUE(restored.restore(state));
  EXPECT_EQ(restored.photon_variance(), film.photon_variance());
  for (const double impossible : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto bits = std::bit_cast<std::uint64_t>(impossible);
    state[2] = static_cast<std::uint32_t>(bits);
    state[3] = static_cast<std::uint32_t>(bits >> 32);
    Film damaged = film.like(film.bounds());
    EXPECT_FALSE(damaged.restore(state)) << impossible;
  }
}

}  // namespace
}  // namespace glowworm
