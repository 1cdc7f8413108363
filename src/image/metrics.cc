#include "image/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr double kRelativeFloor = 0.01;   // limits the weight of black pixels in the reference
constexpr float kDifferenceFloor = 0.1f;  // its square root, for errors that are not squared

void check_sizes(const Image& image, const Image& reference) {
  if (image.width() != reference.width() || image.height() != reference.height()) {
    throw Error(fmt::format("pictures of different sizes cannot be compared: {} x {} and {} x {}", image.width(),
                            image.height(), reference.width(), reference.height()),
                "Render both at one size.");
  }
}

double ratio(double numerator, double denominator) {
  if (denominator == 0) return numerator == 0 ? 1 : std::numeric_limits<double>::infinity();
  return numerator / denominator;
}

// Mean of the smallest `kept` values.
double trimmed_mean(std::vector<double>& values, std::size_t kept) {
  if (kept == 0) return 0;
  std::sort(values.begin(), values.end());
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += values[i];
  return sum / static_cast<double>(kept);
}

}  // namespace

ImageComparison compare_images(const Image& image, const Image& reference, double left_out_share) {
  check_sizes(image, reference);
  if (!(left_out_share >= 0 && left_out_share < 1)) {
    throw Error(fmt::format("the share of pixels to leave out is {}", left_out_share), "Give a number in [0, 1).");
  }
  const std::vector<RGB> is = image.rgb(), should_be = reference.rgb();
  ImageComparison result;
  std::vector<double> squares, relative_squares;
  squares.reserve(is.size());
  relative_squares.reserve(is.size());
  double peak = 0, sum_image[3] = {}, sum_reference[3] = {}, luminance_image = 0, luminance_reference = 0;
  for (std::size_t i = 0; i < is.size(); ++i) {
    if (!is_finite(is[i]) || !is_finite(should_be[i])) {
      // Infinities of depth agree where both pictures show nothing.
      if (is[i] == should_be[i]) {
        squares.push_back(0);
        relative_squares.push_back(0);
      } else {
        ++result.non_finite_pixels;
      }
      continue;
    }
    double square = 0, relative_square = 0;
    for (int c = 0; c < 3; ++c) {
      const double value = is[i][c], truth = should_be[i][c], difference = value - truth;
      square += difference * difference / 3;
      relative_square += difference * difference / (truth * truth + kRelativeFloor) / 3;
      peak = std::max(peak, truth);
      sum_image[c] += value;
      sum_reference[c] += truth;
      result.largest_difference = std::max(result.largest_difference, std::abs(difference));
    }
    luminance_image += luminance(is[i]);
    luminance_reference += luminance(should_be[i]);
    squares.push_back(square);
    relative_squares.push_back(relative_square);
  }
  result.pixels = squares.size();
  if (result.pixels == 0)
    throw Error("the pictures cannot be compared: no pixel has finite numbers in both",
                "Look for what makes them infinite, or not a number.");
  const auto left_out = static_cast<std::size_t>(left_out_share * static_cast<double>(result.pixels));
  result.mse = trimmed_mean(squares, result.pixels - left_out);
  result.relative_mse = trimmed_mean(relative_squares, result.pixels - left_out);
  result.relative_rmse = std::sqrt(result.relative_mse);
  result.psnr = 10 * std::log10(ratio(peak * peak, result.mse));
  for (int c = 0; c < 3; ++c) result.mean_ratio[c] = ratio(sum_image[c], sum_reference[c]);
  result.luminance_ratio = ratio(luminance_image, luminance_reference);
  return result;
}

Image difference_picture(const Image& image, const Image& reference, float full_scale) {
  check_sizes(image, reference);
  if (!(full_scale > 0)) throw Error("the full scale of a difference picture must be positive");
  const std::vector<RGB> is = image.rgb(), should_be = reference.rgb();
  constexpr float kGrey = 0.2f;
  std::vector<RGB> colors(is.size());
  for (std::size_t i = 0; i < is.size(); ++i) {
    const float value = luminance(is[i]), truth = luminance(should_be[i]);
    if (!std::isfinite(value) || !std::isfinite(truth)) {
      colors[i] = {0, 1, 0};
      continue;
    }
    const float error = std::clamp((value - truth) / (std::abs(truth) + kDifferenceFloor) / full_scale, -1.0f, 1.0f);
    const RGB full = error > 0 ? RGB{1, 0, 0} : RGB{0, 0, 1};
    colors[i] = lerp(RGB(kGrey), full, std::abs(error));
  }
  Image picture(image.width(), image.height());
  picture.add_rgb("", colors);
  return picture;
}

}  // namespace glowworm
