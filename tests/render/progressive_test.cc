// Progressive rendering: the error falls as a power of the number of passes, without a floor from the photons' blur.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

constexpr int kPictureSide = 12;
constexpr std::uint32_t kSeeds = 4;

/// Mean over pixels and channels of the relative squared difference.
double relative_mse(const std::vector<RGB>& a, const std::vector<RGB>& b, const std::vector<RGB>& scale) {
  const double floor = 0.1 * mean(scale).luminance();
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double difference = double(a[i][c]) - b[i][c];
      sum += difference * difference / (double(scale[i][c]) * scale[i][c] + floor * floor);
    }
  return sum / (3 * static_cast<double>(a.size()));
}

std::vector<RGB> path_traced(const Stage& stage, std::uint32_t seed) {
  RenderSettings settings = by_path(kPictureSide, 1 << 14);
  settings.indirect_only = true;
  settings.seed = seed;
  return pixels(stage.render(settings), true);
}

/// Root mean squared errors, one for each seed.
std::vector<double> errors(const Stage& stage, std::uint32_t passes, bool progressive,
                           const std::vector<RGB>& reference, double reference_mse) {
  std::vector<double> found;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    RenderSettings settings = by_photons(kPictureSide, passes, 16, 2000, "blocked");
    settings.indirect_only = true;
    settings.progressive = progressive;
    settings.seed = 10 + seed;
    const double mse = relative_mse(pixels(stage.render(settings), true), reference, reference);
    found.push_back(std::sqrt(std::max(mse - reference_mse, 0.0)));
  }
  return found;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double standard_error(const std::vector<double>& values) {
  const double m = mean_of(values);
  double sum = 0;
  for (const double v : values) sum += (v - m) * (v - m);
  const double n = static_cast<double>(values.size());
  return std::sqrt(sum / (n - 1) / n);
}

/// The power of the number of passes by which one error became the other, and its standard error.
struct Slope {
  double value, error;
};
Slope slope(const std::vector<double>& before, const std::vector<double>& after, double passes_ratio) {
  const double a = mean_of(before), b = mean_of(after);
  return {std::log(b / a) / std::log(passes_ratio),
          std::hypot(standard_error(before) / a, standard_error(after) / b) / std::log(passes_ratio)};
}

TEST(SlowProgressive, ErrorFallsAsAPowerOfThePassesWithoutAFloor) {
  const Stage stage(builtin_scene("cornell"));
  const std::vector<RGB> first = path_traced(stage, 1), second = path_traced(stage, 2);
  std::vector<RGB> reference;
  for (std::size_t i = 0; i < first.size(); ++i) reference.push_back((first[i] + second[i]) * 0.5f);
  // The mean of two has a quarter of the variance of their difference.
  const double reference_mse = relative_mse(first, second, reference) / 4;
  std::printf("path tracer: relative error %.4f\n", std::sqrt(reference_mse));
  constexpr std::uint32_t kPasses[] = {2, 8, 32, 128};
  std::vector<std::vector<double>> progressive;
  for (const std::uint32_t passes : kPasses) {
    progressive.push_back(errors(stage, passes, true, reference, reference_mse));
    std::printf("%4u passes: relative error %.4f +- %.4f\n", passes, mean_of(progressive.back()),
                standard_error(progressive.back()));
  }
  const std::vector<double> fixed = errors(stage, kPasses[3], false, reference, reference_mse);
  std::printf("%4u passes of one photon map: relative error %.4f +- %.4f\n", kPasses[3], mean_of(fixed),
              standard_error(fixed));
  const Slope all = slope(progressive.front(), progressive.back(), 64), last = slope(progressive[2], progressive[3], 4);
  std::printf("slope %.3f +- %.3f over all passes, %.3f +- %.3f over the last\n", all.value, all.error, last.value,
              last.error);
  // With alpha = 2/3 variance falls with the power -2/3 of the passes at least, and bias with -1/3 (Knaus and Zwicker,
  // section 3.3): the error with -1/3 at the slowest. At a confidence of 99.7%, three standard errors:
  EXPECT_LT(all.value - 3 * all.error, -1.0 / 3);
  EXPECT_LT(last.value - 3 * last.error, -1.0 / 3);
  EXPECT_LT(last.value + 3 * last.error, 0);
  EXPECT_LT(mean_of(progressive.back()) + 3 * standard_error(progressive.back()),
            mean_of(fixed) - 3 * standard_error(fixed));
}

}  // namespace
}  // namespace glowworm
