// Directions of diffuse reflection from many points at once, for nearly all final gather rays.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays for these kernels have kDiffuseRayPadding - 1 elements after the last point,
/// which may be read and written and have no meaning.
inline constexpr std::size_t kDiffuseRayPadding = 16;

/// Start points of diffuse rays. Arrays of `count` elements and the padding, index i one point.
struct DiffuseRayPoints {
  std::size_t count = 0;
  const std::uint32_t* sequence = nullptr;  ///< selects the point's random numbers, together with `sample`
  const std::uint32_t* sample = nullptr;
  const float* frame[9] = {};   ///< x, y, z of the shading frame's s, t and n; n on the visible side
  const float* normal[3] = {};  ///< unit, geometric, on the visible side
};

/// A cell of the square of random numbers, and the random numbers of its rays: point i takes the first pair of
/// Sampler(sobol, seed, hash_combine(sequence[i], sequence_salt), sample[i] * sample_stride + sample_offset).
struct DiffuseRayCell {
  std::uint32_t seed = 0, sequence_salt = 0, sample_stride = 1, sample_offset = 0;
  float low[2] = {0, 0};   ///< corner of the cell
  float side[2] = {1, 1};  ///< its size
};

/// Arrays of points of the unit square, one for each start point.
struct DiffuseSquare {
  float* x = nullptr;
  float* y = nullptr;
};

/// One ray for each point.
struct DiffuseRays {
  float* direction[3] = {};  ///< unit, world space
  float* cosine = nullptr;   ///< to the shading normal, of the direction and, where it is on the same side, of its
                             ///< mirror image in the surface: the pdf is cosine / pi per steradian; 0: no ray
};

/// The points of the cell that its random numbers choose. Runs on the instruction set of set_simd().
void diffuse_squares(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseSquare& out);

/// The directions of points of the square, in proportion to the cosine to the shading normal (Malley's method over the
/// concentric map, as core/warp.h); a direction that would pass through the surface is mirrored in it
/// (bsdf/shaded_surface.h). Runs on the instruction set of set_simd().
void diffuse_rays(const DiffuseRayPoints& points, const DiffuseSquare& square, const DiffuseRays& out);

}  // namespace glowworm
