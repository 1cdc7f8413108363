// Directions of diffuse reflection from many points at once: what nearly all final gather rays are.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays given to these kernels go on for kDiffuseRayPadding - 1 elements behind the last
/// point: they may be read and written, and mean nothing.
inline constexpr std::size_t kDiffuseRayPadding = 16;

/// Points that diffuse rays leave. Arrays of `count` elements and the padding, index i one point.
struct DiffuseRayPoints {
  std::size_t count = 0;
  const std::uint32_t* sequence = nullptr;  ///< names the point's random numbers, with `sample`
  const std::uint32_t* sample = nullptr;
  const float* frame[9] = {};   ///< x, y, z of the shading frame's s, t and n; n on the side that is seen
  const float* normal[3] = {};  ///< unit, geometric, on the side that is seen
};

/// A cell of the square of random numbers, and which numbers a ray in it is made of: point i takes the first pair of
/// Sampler(sobol, seed, hash_combine(sequence[i], sequence_salt), sample[i] * sample_stride + sample_offset).
struct DiffuseRayCell {
  std::uint32_t seed = 0, sequence_salt = 0, sample_stride = 1, sample_offset = 0;
  float low[2] = {0, 0};   ///< corner of the cell
  float side[2] = {1, 1};  ///< its size
};

/// One ray for each point.
struct DiffuseRays {
  float* direction[3] = {};  ///< unit, world space
  float* cosine = nullptr;   ///< to the shading normal, of the direction and, where it is on the same side, of its
                             ///< mirror image in the surface: the pdf is cosine / pi per steradian; 0: no ray
};

/// Chooses a direction in proportion to the cosine to the shading normal for each point (Malley's method over the
/// concentric map, as core/warp.h); mirrors it in the surface where it would go through that (bsdf/shaded_surface.h).
/// Runs on the instruction set of set_simd().
void diffuse_rays(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseRays& out);

/// The same by plain loops over core/random.h and core/warp.h, bit for bit: what the kernel is tested against.
void diffuse_rays_reference(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseRays& out);

}  // namespace glowworm
