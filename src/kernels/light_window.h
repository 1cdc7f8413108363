// The window of the filter of gathered light (filter/light_filter.h): weighs and adds the pixels around those of a
// tile.
#pragma once
#include <cstddef>

namespace glowworm {

/// Radius of the window, pixels.
inline constexpr int kWindowReach = 8;
/// Floats of the widest vector. So many may be read after the pixels around a tile, and have no meaning.
inline constexpr std::size_t kWindowPadding = 16;
/// Squared difference of normals at which pixels show different surfaces. The mean normals of pixels at an edge are
/// shorter than 1, and alike along the edge.
inline constexpr float kNormalDifference = 0.2f;

/// Pixels around a tile; each pointer is at the tile's first one. Rows are `stride` floats apart. kWindowReach + 1
/// pixels on all sides of the tile can be read.
struct WindowPlanes {
  std::ptrdiff_t stride = 0;
  const float* normal[3] = {};   ///< NaN: like no other pixel
  const float* depth = nullptr;  ///< metres
  /// Change of depth from pixel to pixel, metres. Of two pixels the smaller one counts: at edges it is large.
  const float* slope = nullptr;
  const float* light[3] = {};       ///< W sr^-1 m^-2
  const float* level = nullptr;     ///< luminance of the light
  const float* variance = nullptr;  ///< of the level
};

/// Sums of a tile, row by row. With the border of a pixel that comparisons need, a row fills whole vectors; the columns
/// after the tile's have no meaning.
struct WindowSums {
  static constexpr int kWidth = 30, kHeight = 16;
  static constexpr std::ptrdiff_t kStride = 32;
  static constexpr std::size_t kFloats = static_cast<std::size_t>(kStride * kHeight);
  float light[3][kFloats];
  float weight[kFloats];
  float variance[kFloats];  ///< times squared weights
  float surface[kFloats];   ///< weights that the pixels would have if they showed the same light

  static std::size_t at(int x, int y) { return static_cast<std::size_t>(y * kStride + x); }
};

/// Adds to the sums of each pixel of a tile the pixels within kWindowReach, weighted by how far both show the same
/// surface and the same light. Only the first `height` rows are computed. Runs on the instruction set of set_simd().
void add_window(const WindowPlanes& planes, int height, WindowSums& sums);

namespace light_window {
/// Depths may differ by this share, beside what the slope of the surface explains.
inline constexpr float kDepthShare = 0.005f;
/// Least depth difference, metres: keeps its square above the least normal float.
inline constexpr float kLeastDepth = 1e-18f;
/// Share of the squared level that is added to variances, so that 0 / 0 counts as no difference, and their least value.
inline constexpr float kMinVariance = 1e-10f, kLeastVariance = 1e-30f;
/// Deviations above the expected difference up to which a neighbour counts in full, and beyond which it does not.
inline constexpr float kFullWeight = 0.5f, kNoWeight = 2.0f;
/// Squared difference over variance up to which a pixel counts in full that is much noisier, or much less noisy, than
/// the centre, and beyond which it does not. Of pixels that met n rare bright samples it is n; those at the edge of
/// something bright differ by more, and would shine into the dark pixels around them.
inline constexpr float kFullContrast = 4.0f, kNoContrast = 6.0f;
}  // namespace light_window

}  // namespace glowworm
