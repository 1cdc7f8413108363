// The filter of gathered light, on pictures with known noise.
#include "filter/light_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/parallel.h"

namespace glowworm {
namespace {

constexpr int kSide = 64;
constexpr std::uint32_t kSamples = 16;

/// One flat surface that faces the viewer.
FilterGuides flat_surface() {
  constexpr std::size_t kPixels = kSide * kSide;
  return {kSide, kSide, std::vector<Vec3>(kPixels, Vec3{0, 0, 1}), std::vector<float>(kPixels, 2.0f)};
}

/// What level(x, y) is, with normal noise of that standard error, which its samples say.
template <typename Level>
LightEstimate noisy(float error, Level&& level) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  LightEstimate out;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      out.level.push_back(level(x, y) + error * normal(random));
      out.light.push_back(RGB(out.level.back()));
      out.variance.push_back(error * error);
      out.samples.push_back(kSamples);
    }
  return out;
}

/// Root of the mean squared error over columns [first, last).
template <typename Level>
float error_of(const FilteredLight& filtered, Level&& level, int first = 0, int last = kSide) {
  double sum = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = first; x < last; ++x) sum += std::pow(filtered.light[y * kSide + x].g - level(x, y), 2);
  return static_cast<float>(std::sqrt(sum / (kSide * (last - first))));
}

float predicted_error(const FilteredLight& filtered) {
  double sum = 0;
  for (const float variance : filtered.variance)
    sum += double{variance} / static_cast<double>(filtered.variance.size());
  return static_cast<float>(std::sqrt(sum));
}

TEST(LightFilter, SmoothsNoiseAndEstimatesTheRest) {
  const auto level = [](int x, int y) { return 1 + 0.002f * static_cast<float>(x + y); };
  const FilteredLight filtered = filter_light(noisy(0.1f, level), flat_surface());
  const float left = error_of(filtered, level);
  EXPECT_LT(left, 0.025f);
  // There is no bias here, of which the prediction has a share.
  EXPECT_GT(predicted_error(filtered), left);
  EXPECT_LT(predicted_error(filtered), 1.8f * left);
}

TEST(LightFilter, PredictsErrorWhereLightHasAllScales) {
  const auto level = [](int x, int y) {
    const auto u = static_cast<float>(x), v = static_cast<float>(y);
    return 1 + 0.004f * v * std::sin(0.015f * u * u);
  };
  const FilteredLight filtered = filter_light(noisy(0.1f, level), flat_surface());
  const float left = error_of(filtered, level);
  EXPECT_NEAR(predicted_error(filtered), left, 0.25f * left);
}

/// Mean over a column of the filtered light.
float column_mean(const FilteredLight& filtered, int x) {
  float sum = 0;
  for (int y = 0; y < kSide; ++y) sum += filtered.light[static_cast<std::size_t>(y * kSide + x)].g / kSide;
  return sum;
}

/// The pixels around one at the border of a surface lie on one side, where light that rises is 4% brighter.
TEST(LightFilter, TakesTheLightOfTheRightPlaceAtBorders) {
  const auto level = [](int x, int) { return 1 + 0.02f * static_cast<float>(x); };
  const FilteredLight filtered = filter_light(noisy(0.3f, level), flat_surface());
  for (const int x : {0, 1, kSide - 2, kSide - 1}) EXPECT_NEAR(column_mean(filtered, x), level(x, 0), 0.02f) << x;
}

TEST(LightFilter, KeepsEdgesOfLight) {
  const auto level = [](int x, int) { return x < kSide / 2 ? 1.0f : 1.6f; };
  const FilteredLight filtered = filter_light(noisy(0.1f, level), flat_surface());
  EXPECT_LT(error_of(filtered, level, kSide / 2 - 2, kSide / 2 + 2), 0.1f);
  EXPECT_LT(error_of(filtered, level), 0.05f);
}

TEST(LightFilter, KeepsSurfacesApart) {
  const auto level = [](int x, int) { return x < kSide / 2 ? 1.0f : 1.15f; };
  FilterGuides guides = flat_surface();
  for (std::size_t i = 0; i < guides.size(); ++i)
    if (i % kSide >= kSide / 2) guides.normal[i] = {1, 0, 0};
  const LightEstimate estimate = noisy(0.1f, level);
  EXPECT_LT(error_of(filter_light(estimate, guides), level, kSide / 2 - 2, kSide / 2 + 2), 0.03f);
  for (std::size_t i = 0; i < guides.size(); ++i)
    if (i % kSide >= kSide / 2) {
      guides.normal[i] = {0, 0, 1};
      guides.depth[i] = 3;
    }
  EXPECT_LT(error_of(filter_light(estimate, guides), level, kSide / 2 - 2, kSide / 2 + 2), 0.03f);
}

TEST(LightFilter, ConvergesToTheSamples) {
  const auto level = [](int x, int y) { return 1 + 0.1f * static_cast<float>((x / 2 + y / 2) % 2); };
  for (const float error : {0.16f, 0.04f, 0.01f}) {
    const float left = error_of(filter_light(noisy(error, level), flat_surface()), level);
    EXPECT_LT(left, error);
  }
}

/// The spread overstates the variance four times. Pixels are compared by variances corrected by the fourth root of
/// that.
TEST(LightFilter, KnowsThatStratifiedSamplesErrLessThanTheirSpread) {
  const auto level = [](int, int) { return 1.0f; };
  LightEstimate estimate = noisy(0.1f, level);
  for (float& variance : estimate.variance) variance *= 4;
  const FilteredLight filtered = filter_light(estimate, flat_surface());
  double mean = 0;
  for (const float variance : filtered.unfiltered) mean += variance;
  // The median of 1900 squares has a standard error of 5%, its fourth root of 1.25%; there are four of them.
  EXPECT_NEAR(mean / static_cast<double>(filtered.unfiltered.size()), 0.04 / std::sqrt(2.0), 0.0015);
}

/// A few samples are much brighter than all others. The filter must not leave them as specks.
TEST(LightFilter, SpreadsRareBrightSamples) {
  constexpr float kChance = 0.005f, kBright = 20, kLevel = 1 + kChance * kBright;
  LightEstimate estimate = noisy(0.1f, [](int, int) { return 1.0f; });
  std::mt19937 random(5);
  std::binomial_distribution<std::uint32_t> meets(kSamples, kChance);
  for (std::size_t i = 0; i < estimate.level.size(); ++i) {
    const float share = static_cast<float>(meets(random)) / kSamples;
    estimate.level[i] += kBright * share;
    estimate.light[i] = RGB(estimate.level[i]);
    // Stratified: the spread overstates the noise of the others ten times.
    estimate.variance[i] = 0.1f + kBright * kBright * share * (1 - share) / (kSamples - 1);
  }
  const FilteredLight filtered = filter_light(estimate, flat_surface());
  const auto bright = [](const RGB& light) { return light.g > kLevel + 0.5f; };
  EXPECT_GT(std::count_if(estimate.light.begin(), estimate.light.end(), bright), 100);
  EXPECT_LT(std::count_if(filtered.light.begin(), filtered.light.end(), bright), 5);
}

/// Of one surface whose light comes by rare bright samples.
LightEstimate rarely_bright(std::uint32_t samples) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform;
  LightEstimate out;
  for (int i = 0; i < kSide * kSide; ++i) {
    double sum = 0, squares = 0;
    for (std::uint32_t s = 0; s < samples; ++s) {
      const double value = 0.5 + uniform(random) + (uniform(random) < 0.005f ? 10.0 : 0.0);
      sum += value;
      squares += value * value;
    }
    const double n = samples, mean = sum / n;
    out.level.push_back(static_cast<float>(mean));
    out.light.push_back(RGB(out.level.back()));
    out.variance.push_back(static_cast<float>((squares / n - mean * mean) / (n - 1)));
    out.samples.push_back(samples);
  }
  return out;
}

TEST(LightFilter, KeepsTheLightOfRareBrightSamples) {
  for (const std::uint32_t samples : {4U, 16U}) {
    const LightEstimate estimate = rarely_bright(samples);
    const FilteredLight filtered = filter_light(estimate, flat_surface());
    double before = 0, after = 0;
    for (std::size_t i = 0; i < estimate.light.size(); ++i) {
      before += estimate.light[i].g;
      after += filtered.light[i].g;
    }
    EXPECT_NEAR(after / before, 1, 0.02) << samples;
  }
}

/// Sets the light of a pixel that something bright is seen in by some of its samples.
void see_something_bright(LightEstimate& estimate, std::size_t pixel) {
  estimate.level[pixel] = 5;
  estimate.light[pixel] = RGB(5.0f);
  estimate.variance[pixel] = 4;
}

TEST(LightFilter, KeepsTheLightOfBrightEdgesOutOfDarkPixels) {
  const auto level = [](int, int) { return 0.1f; };
  LightEstimate estimate = noisy(0.002f, level);
  for (int y = 0; y < kSide; y += 4) see_something_bright(estimate, static_cast<std::size_t>(y * kSide + kSide / 2));
  EXPECT_LT(error_of(filter_light(estimate, flat_surface()), level, kSide / 2 + 1, kSide / 2 + 4), 0.01f);
}

/// Light of a samples' number of a surface with a lit line of less than a pixel's width, as beside a lamp that nearly
/// touches it, that leans by one column in four rows.
struct LitLine {
  static constexpr float kDark = 0.1f, kBright = 40;
  std::uint32_t samples;

  static bool meets(std::size_t pixel) { return pixel % kSide == kSide / 2 + pixel / kSide / 4 - kSide / 8; }

  LightEstimate estimate() const {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform;
    LightEstimate out;
    for (std::size_t i = 0; i < kSide * kSide; ++i) {
      double sum = 0, squares = 0;
      for (std::uint32_t s = 0; s < samples; ++s) {
        const double value = kDark * (0.95 + 0.1 * uniform(random)) + (meets(i) && uniform(random) < 0.2 ? kBright : 0);
        sum += value;
        squares += value * value;
      }
      const double n = samples, mean = sum / n;
      out.level.push_back(static_cast<float>(mean));
      out.light.push_back(RGB(out.level.back()));
      out.variance.push_back(static_cast<float>(std::max(squares / n - mean * mean, 0.0) / (n - 1)));
      out.samples.push_back(samples);
    }
    return out;
  }
};

/// Pixels beside the line that have not met its light have no noise that would tell them from those that have.
TEST(LightFilter, KeepsTheLightOfALineOutOfItsSurroundings) {
  for (const std::uint32_t samples : {2U, 4U, 8U, 16U}) {
    const FilteredLight filtered = filter_light(LitLine{samples}.estimate(), flat_surface());
    float largest = 0;
    double line = 0;
    for (std::size_t i = 0; i < filtered.light.size(); ++i) {
      if (LitLine::meets(i))
        line += filtered.light[i].g / kSide;
      else
        largest = std::max(largest, filtered.light[i].g);
    }
    EXPECT_LT(largest, 1.1f * LitLine::kDark) << samples;
    // A fifth of the samples meet the line: the standard error of the mean of all is a seventh at 2 samples.
    EXPECT_NEAR(line, 0.2 * LitLine::kBright, 0.2 * LitLine::kBright * 4 / std::sqrt(16.0 * samples)) << samples;
  }
}

/// Other light does not hide the light of the line where that would make a halo.
TEST(LightFilter, MakesNoHaloBesideOtherLight) {
  constexpr float kOther = LitLine::kBright / 10;
  for (const std::uint32_t samples : {4U, 8U, 16U}) {
    LightEstimate estimate = LitLine{samples}.estimate();
    estimate.beside.assign(estimate.light.size(), kOther);
    const FilteredLight filtered = filter_light(estimate, flat_surface());
    double halo = 0, count = 0;
    for (std::size_t i = 1; i + 1 < filtered.light.size(); ++i)
      if (!LitLine::meets(i) && (LitLine::meets(i - 1) || LitLine::meets(i + 1))) {
        halo += filtered.light[i].g - LitLine::kDark;
        ++count;
      }
    EXPECT_LT(halo / count, 0.02f * kOther) << samples;
  }
}

/// Pixels that differ from the mean of those around them, by more than a share of the light of one sample that meets
/// something bright.
int count_specks(const std::vector<RGB>& light, float of_sample) {
  int specks = 0;
  for (int y = 1; y < kSide - 1; ++y)
    for (int x = 1; x < kSide - 1; ++x) {
      float around = 0;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          if (u != x || v != y) around += light[static_cast<std::size_t>(v * kSide + u)].g / 8;
      specks += std::abs(light[static_cast<std::size_t>(y * kSide + x)].g - around) > 0.5f * of_sample;
    }
  return specks;
}

/// Light of a penumbra that few samples find: a sample of column x does so with chance(x).
template <typename Chance>
LightEstimate rare_light(std::uint32_t samples, float dark, float bright, Chance&& chance) {
  std::mt19937 random(11);
  LightEstimate out;
  for (int i = 0; i < kSide * kSide; ++i) {
    std::binomial_distribution<std::uint32_t> meets(samples, chance(i % kSide));
    const float share = static_cast<float>(meets(random)) / static_cast<float>(samples);
    out.level.push_back(dark + bright * share);
    out.light.push_back(RGB(out.level.back()));
    out.variance.push_back(bright * bright * share * (1 - share) / static_cast<float>(samples - 1));
    out.samples.push_back(samples);
  }
  return out;
}

/// Pixels in full shadow have no noise, so those at the end of its penumbra are averaged with pixels of the lit side
/// alone, whose mean is brighter by nearly one column's rise.
TEST(LightFilter, MakesNoStepAtTheEndOfAPenumbra) {
  constexpr int kFirst = kSide / 2 + 2, kLast = kFirst + 6;
  for (const std::uint32_t samples : {4U, 8U, 16U}) {
    const float rise = 0.16f / static_cast<float>(samples);
    const auto chance = [&](int x) { return std::min(rise * static_cast<float>(std::max(x - kSide / 2, 0)), 1.0f); };
    const FilteredLight filtered = filter_light(rare_light(samples, 0, 1, chance), flat_surface());
    float excess = 0;
    for (int x = kFirst; x < kLast; ++x) excess += (column_mean(filtered, x) - chance(x)) / (kLast - kFirst);
    EXPECT_NEAR(excess, 0, 0.5f * rise) << samples;
  }
}

/// At the end of a penumbra some pixels meet light by chance, and others do not. If the filter separates them, the end
/// is ragged. Other light hides the blur of averaging both.
TEST(LightFilter, EndsPenumbrasSmoothlyBesideOtherLight) {
  for (const std::uint32_t samples : {4U, 8U, 16U}) {
    const float rise = 0.16f / static_cast<float>(samples);
    const auto chance = [&](int x) { return std::min(rise * static_cast<float>(std::max(x - kSide / 2, 0)), 1.0f); };
    LightEstimate estimate = rare_light(samples, 0, 1, chance);
    estimate.beside.assign(estimate.light.size(), 0.5f);
    const FilteredLight filtered = filter_light(estimate, flat_surface());
    double steps = 0;  // mean square of those along the edge
    for (int x = kSide / 2; x < kSide / 2 + 8; ++x)
      for (int y = 1; y < kSide; ++y) {
        const auto i = static_cast<std::size_t>(y * kSide + x);
        steps += std::pow(filtered.light[i].g - filtered.light[i - kSide].g, 2) / (8 * (kSide - 1));
      }
    EXPECT_LT(std::sqrt(steps), rise) << samples;
    for (int x = kSide / 2 - 8; x < kSide / 2 + 8; ++x)
      EXPECT_NEAR(column_mean(filtered, x), chance(x), 1.5 * rise) << x;
  }
}

/// Where rare light ends, few pixels have met it. Their own noise must not keep their light from being spread.
TEST(LightFilter, LeavesFewSpecksAtTheEndOfRareLight) {
  for (const std::uint32_t samples : {4U, 8U, 16U}) {
    const float of_sample = 1 / static_cast<float>(samples), speck = 0.4f * of_sample;
    const auto chance = [&](int x) { return x < kSide / 2 ? 0 : 0.01f * of_sample; };
    LightEstimate estimate = rare_light(samples, 0, 1, chance);
    estimate.beside.assign(estimate.light.size(), of_sample);
    EXPECT_LT(count_specks(filter_light(estimate, flat_surface()).light, speck),
              count_specks(estimate.light, speck) / 2)
        << samples;
  }
}

/// A lamp that nearly touches a surface lights little of it, and hardly a sample finds that light. It is so bright that
/// it must not be spread.
TEST(LightFilter, MakesNoHaloOfLoneBrightPixels) {
  constexpr float kOther = 0.01f;
  for (const std::uint32_t samples : {2U, 4U, 8U}) {
    LightEstimate estimate = rare_light(samples, 0, 1, [](int) { return 0.0f; });
    estimate.beside.assign(estimate.light.size(), kOther);
    const float mean = 1 / static_cast<float>(samples);
    constexpr std::size_t kPixel = kSide / 2 * kSide + kSide / 2;
    estimate.light[kPixel] = RGB(mean);
    estimate.level[kPixel] = mean;
    estimate.variance[kPixel] = mean * mean;
    FilteredLight filtered = filter_light(estimate, flat_surface());
    float brightest = 0;
    for (std::size_t i = 0; i < filtered.light.size(); ++i)
      if (i != kPixel) brightest = std::max(brightest, filtered.light[i].g);
    EXPECT_LT(brightest, 0.02f * kOther) << samples;
    // Gathered light is never alone: there it is a rare sample, whose light is spread.
    estimate.lone = false;
    filtered = filter_light(estimate, flat_surface());
    EXPECT_LT(filtered.light[kPixel].g, 0.05f * mean) << samples;
  }
}

/// The light of a penumbra falls evenly from one side of the picture to the other, and few samples find it: a pixel at
/// the middle that has met none has no noise either, and must not be told from others by that.
TEST(LightFilter, LeavesNoSpecksInPenumbrasOfRareLight) {
  constexpr float kBright = 1, kDark = 0.1f;
  for (const std::uint32_t samples : {2U, 4U, 8U, 16U}) {
    const auto chance = [&](int x) { return 0.8f / static_cast<float>(samples * kSide) * static_cast<float>(x); };
    const auto level = [&](int x, int) { return kDark + kBright * chance(x); };
    const LightEstimate estimate = rare_light(samples, kDark, kBright, chance);
    const FilteredLight filtered = filter_light(estimate, flat_surface());
    const float of_sample = kBright / static_cast<float>(samples);
    EXPECT_GT(count_specks(estimate.light, of_sample), 1000) << samples;
    // Beside the dark side no pixel around may have met light: without that, 56 to 94 are left.
    EXPECT_LT(count_specks(filtered.light, of_sample), 30) << samples;
    EXPECT_LT(error_of(filtered, level), 0.13f * of_sample) << samples;
  }
}

TEST(LightFilter, KeepsPixelsBetweenTwoDepthsApart) {
  const auto level = [](int, int) { return 1.0f; };
  LightEstimate estimate = noisy(0.01f, level);
  FilterGuides guides = flat_surface();
  for (int y = 0; y < kSide; ++y) {
    const auto pixel = static_cast<std::size_t>(y * kSide + kSide / 2);
    see_something_bright(estimate, pixel);
    estimate.variance[pixel] = 16;  // so that the noise alone does not tell them apart
    guides.depth[pixel] = 3;
  }
  EXPECT_LT(error_of(filter_light(estimate, guides), level, kSide / 2 + 1, kSide / 2 + 4), 0.02f);
}

TEST(LightFilter, SkipsPixelsWithoutSurfaceOrVariance) {
  const auto level = [](int x, int y) { return static_cast<float>((x * 7 + y * 13) % 5); };
  FilterGuides guides = flat_surface();
  std::fill(guides.depth.begin(), guides.depth.end(), std::numeric_limits<float>::infinity());
  LightEstimate estimate = noisy(0.1f, level);
  const FilteredLight in_the_sky = filter_light(estimate, guides);
  estimate.samples[0] = 1;
  const FilteredLight of_one = filter_light(estimate, flat_surface());
  for (std::size_t i = 0; i < guides.size(); ++i) {
    ASSERT_EQ(in_the_sky.light[i], estimate.light[i]);
    ASSERT_EQ(of_one.light[i], estimate.light[i]);
  }
}

TEST(LightFilter, FiltersPixelsOfTwoSurfacesAlongTheirEdge) {
  const LightEstimate estimate = noisy(0.1f, [](int, int) { return 1.0f; });
  FilterGuides guides = flat_surface();
  // A column of pixels that see half of another surface.
  const int column = guides.width / 2;
  const auto at = [&](int y) { return static_cast<std::size_t>(y * guides.width + column); };
  for (int y = 0; y < guides.height; ++y) guides.normal[at(y)] = (guides.normal[at(y)] + Vec3{1, 0, 0}) * 0.5f;
  const FilteredLight filtered = filter_light(estimate, guides);
  double before = 0, after = 0;
  for (int y = 0; y < guides.height; ++y) {
    before += std::pow(estimate.light[at(y)].g - 1, 2);
    after += std::pow(filtered.light[at(y)].g - 1, 2);
  }
  EXPECT_LT(after, 0.5 * before);
}

TEST(LightFilter, FiltersTheWantedRowsAlone) {
  const LightEstimate estimate = noisy(0.1f, [](int x, int y) { return 1 + 0.01f * static_cast<float>(x + y); });
  const FilteredLight all = filter_light(estimate, flat_surface());
  const FilteredLight some = filter_light(estimate, flat_surface(), {13, 40});
  for (std::size_t i = 0; i < all.light.size(); ++i) {
    const bool wanted = i >= 13 * kSide && i < 40 * kSide;
    ASSERT_EQ(some.light[i], wanted ? all.light[i] : RGB()) << i;
    ASSERT_EQ(some.variance[i], wanted ? all.variance[i] : 0) << i;
  }
}

TEST(LightFilter, GivesTheSameBitsForAnyNumberOfThreads) {
  const LightEstimate estimate = noisy(0.1f, [](int x, int) { return 1 + 0.01f * static_cast<float>(x); });
  set_thread_count(1);
  const FilteredLight one = filter_light(estimate, flat_surface());
  set_thread_count(3);
  const FilteredLight three = filter_light(estimate, flat_surface());
  set_thread_count(0);
  EXPECT_TRUE(one.light == three.light);
  EXPECT_EQ(one.variance, three.variance);
}

}  // namespace
}  // namespace glowworm
