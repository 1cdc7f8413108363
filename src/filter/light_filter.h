// The filter of gathered light: averages pixels whose difference their statistics cannot tell from noise.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// Surfaces in a picture; arrays of width * height entries, row by row.
struct FilterGuides {
  int width = 0, height = 0;
  std::vector<Vec3> normal;  ///< mean over the samples of a pixel, not of unit length at edges; (0, 0, 0) for nothing;
                             ///< NaN: the pixel is like no other
  std::vector<float> depth;  ///< metres along the camera ray; infinity for nothing

  std::size_t size() const { return normal.size(); }
};

/// Light divided by albedo, as samples of each pixel estimate it; entries as in FilterGuides.
struct LightEstimate {
  std::vector<RGB> light;       ///< mean over samples; W sr^-1 m^-2
  std::vector<float> level;     ///< its luminance, of which the variance is known
  std::vector<float> variance;  ///< of `level`, from the spread of the samples
  std::vector<std::uint32_t> samples;
  /// Luminance of the other light of each pixel, as `level`, which hides a little noise; empty: none.
  std::vector<float> beside;
  /// Whether a pixel may be lit where none around it is, as direct light beside a lamp does. Gathered light comes from
  /// all around: where a lone pixel has more, it has met a rare sample.
  bool lone = true;
};

/// Whether a pixel with this mean normal of its samples shows an edge of a surface.
inline bool shows_edge(Vec3 normal) { return length_squared(normal) < 0.95f; }

/// Rows [first, end) of a picture.
struct FilteredRows {
  int first = 0, end = std::numeric_limits<int>::max();  ///< at least 0; beyond the picture: its height
};

/// Result of filter_light(); rows that are left out hold zeros.
struct FilteredLight {
  std::vector<RGB> light;         ///< W sr^-1 m^-2
  std::vector<float> variance;    ///< of its luminance, with the square of the filter's bias
  std::vector<float> unfiltered;  ///< variance of the luminance before the filter
};

/// Replaces each pixel by a mean over those around it that show the same surface and the same light. Whether two pixels
/// show the same light is decided by Welch's t-test over the differences of the 3 x 3 pixels around both (Sakai et al.,
/// "A Statistical Approach to Monte Carlo Denoising", SIGGRAPH Asia 2024; over patches as in Rousselle et al.,
/// "Adaptive Rendering with Non-Local Means Filtering", 2012). With more samples the variances fall and the test
/// detects smaller differences, so the result converges to the mean of the samples.
///
/// A test cannot tell a few bright samples beside a lamp from noise, and pixels that have not met such samples have
/// small variances. So only pixels whose surroundings are equally noisy are averaged (find_noise() in
/// kernels/light_window.h): noise spreads as far as it occurs.
///
/// Where these pixels lie on one side, as at edges of surfaces and at ends of penumbras, their mean belongs to
/// another place. So a linear function is fitted to them, whose value at the pixel is what counts (local linear
/// regression: J. Fan, "Design-adaptive Nonparametric Regression", Journal of the American Statistical Association 87,
/// 1992).
///
/// Samples of one pixel are stratified, so their spread overstates the error of their mean. Fourth differences of
/// neighbouring pixels measure by how much. Pixels are compared by variances that are scaled by the fourth root of
/// that, which is what stratification gains at edges of light. Variances of the result are scaled by all of it, but by
/// no less than n^-0.5 of n samples.
///
/// The same bits for any number of threads; linear in pixels.
/// Light comes back as it is where a pixel has fewer than two samples.
/// @param rows whose light is wanted: the others only help
FilteredLight filter_light(const LightEstimate& estimate, const FilterGuides& guides, FilteredRows rows = {});

/// The variance that the level of each pixel is expected to have, by the samples of the pixels around it
/// (find_noise()). At edges of light it is smaller than the variance of the pixel's own samples, which stratification
/// makes too large.
std::vector<float> expected_variance(const LightEstimate& estimate, const FilterGuides& guides);

/// Bytes that filter_light() takes for each pixel, with its arguments and its result.
inline constexpr std::size_t kFilterBytesEach = 2 * (sizeof(Vec3) + 6 * sizeof(RGB)) + 16;

}  // namespace glowworm
