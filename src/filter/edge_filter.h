// The filter of edges: pixels that see several surfaces, of which filter_light() finds none alike.
#pragma once
#include <cstdint>
#include <vector>

#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// A picture and what its pixels show; arrays of width * height entries, row by row. Features are means over all
/// samples of a pixel, with 0 for those that hit nothing, so that a pixel at an edge has a mean of those on both sides.
struct EdgePicture {
  int width = 0, height = 0;
  std::vector<Vec3> normal;
  std::vector<float> depth;  ///< metres
  std::vector<RGB> albedo;
  std::vector<float> variance;  ///< of the luminance of light before filters, for light alone
  std::vector<std::uint32_t> samples;
};

/// Replaces pixels whose noise the light filter left by what the filtered pixels around them predict: a linear function
/// of the features and of the place in the picture, fitted by least squares with a weak prior (as in Bitterli et al.,
/// "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings", EGSR 2016). Radiance at an edge
/// of two surfaces of even light is such a function.
///
/// The prediction and the pixel's own mean are weighted by their inverse variances, so the result converges to the mean
/// of the samples. The variance comes from the neighbours: a pixel's own would favour dark samples.
/// A pixel at an edge of surfaces with more noise than all others of these in its window has met rare light, which is
/// spread over them. Elsewhere, as beside a lamp, such light stays.
///
/// The same bits for any number of threads; linear in pixels. Nothing changes if a pixel has fewer than two samples.
/// @param radiance W sr^-1 m^-2, of filter_light(); changed in place
/// @param variance of its luminance; changed in place
void filter_edges(const EdgePicture& picture, std::vector<RGB>& radiance, std::vector<float>& variance);

}  // namespace glowworm
