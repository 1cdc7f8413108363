// The window of the filter of gathered light (filter/light_filter.h): weighs and adds the pixels around each
// pixel of a tile.
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
  const float* shown = nullptr;     ///< luminance of all light of the pixel
  const float* variance = nullptr;  ///< of the level
  const float* spread = nullptr;    ///< variance of one sample's level, for find_noise()
  const float* noise = nullptr;     ///< of find_noise(), for add_window()
  bool lone = true;                 ///< LightEstimate::lone, for find_noise()
};

/// Sums of a tile, row by row. With the border of a pixel that comparisons need, a row fills whole vectors; the columns
/// after the tile's have no meaning.
struct WindowSums {
  static constexpr int kWidth = 30, kHeight = 16;
  static constexpr std::ptrdiff_t kStride = 32;
  static constexpr std::size_t kFloats = static_cast<std::size_t>(kStride * kHeight);
  float light[3][kFloats];
  float weight[kFloats];
  float variance[kFloats];   ///< times squared weights
  float surface[kFloats];    ///< weights that the pixels would have if they showed the same light
  float level[kFloats];      ///< weighted levels
  float step[2][kFloats];    ///< weighted steps to the pixels, along x and y
  float square[3][kFloats];  ///< weighted products of steps: xx, xy, yy
  float slope[2][kFloats];   ///< weighted products of levels and steps
  // Of the weights that the pixels would have by their surface and noise alone, whatever their levels.
  float any_weight[kFloats], any_step[2][kFloats];

  static std::size_t at(int x, int y) { return static_cast<std::size_t>(y * kStride + x); }
};

/// The variance that a sample of each pixel of a row is expected to have. The few samples of a pixel do not tell it:
/// they may miss what other pixels meet. So it is the mean over the surface in the window, on the side where that is
/// least: light that changes steeply, as beside a lamp, lies on the other side, and does not count. The sides are
/// quadrants in eight directions, with the pixel itself. They are as large as the window because a small side without
/// rare light says nothing: in a penumbra that few samples find, pixels beside others that have met light would keep
/// theirs, or none, and its limit would be ragged.
/// @param planes at the row's first pixel
/// @param noise  for `width` pixels; up to kWindowPadding floats after them are overwritten
void find_noise(const WindowPlanes& planes, int width, float* noise);

/// Adds to the sums of each pixel of a tile the pixels within kWindowReach, weighted by how far both show the same
/// surface, the same light and the same noise. Only the first `height` rows are computed. Runs on the instruction set
/// of set_simd().
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
/// Ratio of the noise of two pixels above which a neighbour counts in full; below, its weight falls with the cube.
/// Where few samples meet light, the noise of two sides differs by as much by chance. Beside a lamp that nearly touches
/// a surface the ratio is below 1e-3.
inline constexpr float kSameNoise = 0.1f;
/// Share of the squared luminance of all light that is added to the noise of a sample. So noise below 4% of the light
/// does not separate pixels. Without it the end of a penumbra is ragged, because some pixels there meet no light by
/// chance and then have no noise. The blur that it allows changes a pixel by a few percent at most.
inline constexpr float kLeastNoise = 0.002f;
/// A pixel's spread counts in its own noise up to this share of the sum of the others in the window, and, where lone
/// pixels may be lit, what exceeds kHidden of the squared light around. So a pixel that has met rare light, where
/// hardly any other has, is not separated from them and left as a speck, if its light changes them by a few percent at
/// most. A line through the window has as many pixels as the share asks for.
inline constexpr float kOwnShare = 1.0f / 16, kHidden = 16;
/// The other pixels of the window lie in octants; a side has two that follow each other.
inline constexpr int kOctants = 8, kSideOctants = 2, kOctantPixels = kWindowReach * (kWindowReach + 1) / 2;

/// Steps to a pixel of an octant. The first octant has its axis and not its diagonal, the second one the diagonal;
/// turns by 90 degrees give the others.
struct OctantStep {
  int x, y;
};
inline constexpr OctantStep octant_step(int octant, int pixel) {
  int x = 1, y = pixel;
  for (; y >= x; ++x) y -= x;
  OctantStep step{octant % 2 == 0 ? x : x - y, octant % 2 == 0 ? y : x};
  for (int turns = octant / 2; turns > 0; --turns) step = {-step.y, step.x};
  return step;
}
}  // namespace light_window

}  // namespace glowworm
