// Measures of the difference between a picture and its reference.
#pragma once
#include <cstddef>

#include "core/rgb.h"
#include "image/image.h"

namespace glowworm {

/// Result of compare_images. I: the picture, R: the reference; means are over pixels and the three channels.
struct ImageComparison {
  double mse = 0;                     ///< mean of (I - R)^2
  double relative_mse = 0;            ///< mean of (I - R)^2 / (R^2 + 0.01)
  double relative_rmse = 0;           ///< its square root
  double psnr = 0;                    ///< dB: 10 log10(P^2 / mse), P the maximum of R; infinite if mse is 0
  double mean_ratio[3] = {};          ///< mean of I over mean of R, for red, green and blue
  double luminance_ratio = 0;         ///< the same for luminance
  double largest_difference = 0;      ///< maximum |I - R|
  std::size_t pixels = 0;             ///< number of pixels compared, including those left out as the worst
  std::size_t non_finite_pixels = 0;  ///< in either picture, unless equal infinities; excluded from all of the above
};

/// Bytes that compare_images() and difference_picture() take for a pixel.
inline constexpr std::size_t kComparisonBytes = 4 * sizeof(RGB) + 2 * sizeof(double);

/// Compares the beauty of two pictures of equal size. Throws Error if the sizes differ, a picture has no R, G, B, or no
/// pixel is finite in both. The
/// ratio of two zeros is 1; the ratio of one and zero is infinite.
/// @param left_out_share share in [0, 1) of the pixels to exclude from mse and relative_mse, so that a few fireflies of
/// a noisy reference have no effect; each measure excludes the pixels with its largest errors
ImageComparison compare_images(const Image& image, const Image& reference, double left_out_share = 0);

/// Signed relative error of the luminance, (I - R) / (|R| + 0.1), in false colour: grey where both agree, red where the
/// picture is too bright, blue where it is too dark, saturated at an error of `full_scale`, and green where a number is
/// not finite. Values are linear; use write_png() with ToneCurve::srgb.
Image difference_picture(const Image& image, const Image& reference, float full_scale = 0.5f);

}  // namespace glowworm
