// Light paths scattered by surfaces that only reflect diffusely, many at once: what nearly all photons come from.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays given to this kernel go on for kDiffuseScatterPadding - 1 elements behind the
/// last path: they may be read and written, and mean nothing.
inline constexpr std::size_t kDiffuseScatterPadding = 16;

/// Light paths that arrived at triangles. Arrays of `count` elements and the padding, index i one path, three arrays
/// the x, y and z of a vector. Where the reflectance is black nothing comes of a path, and the rest may be any numbers.
struct ArrivedPaths {
  std::size_t count = 0;
  const float* corner[3] = {};          ///< the first vertex of the triangle, metres
  const float* edges[6] = {};           ///< from there to the second and third
  const float* geometric[3] = {};       ///< unit normal of the triangle, by the winding
  const float* offset = nullptr;        ///< rounding_offset() of the triangle, metres
  const float* vertex_normals[9] = {};  ///< shading normals of the vertices; (0,0,0): the triangle's own
  const float* barycentric[2] = {};     ///< of the place, weights of the second and third vertex
  const float* reflectance[3] = {};
  const float* back[3] = {};    ///< unit, along the way that the path came
  const float* flux[3] = {};    ///< W
  const float* roulette = {};   ///< number in [0, 1) for Russian roulette
  const float* square[2] = {};  ///< numbers in [0, 1) for the direction
};

/// What comes of a path, as bits.
enum DiffuseOutcome : std::uint32_t {
  kPhotonLeft = 1,  ///< a photon is left
  kPathGoesOn = 2,  ///< the path leaves the surface
};

/// Arrays as those of ArrivedPaths.
struct ScatteredPaths {
  std::uint32_t* outcome = nullptr;
  float* position[3] = {};     ///< of the photon, metres
  float* normal[3] = {};       ///< geometric, unit, on the side that the path came from
  float* photon_flux[3] = {};  ///< W, with the arrival_factor() of the shading normal
  float* origin[3] = {};       ///< where the path goes on, moved off the surface
  float* direction[3] = {};    ///< where to, unit
  float* flux[3] = {};         ///< of the path that goes on, W; 0 where it ends
};

/// Scatters each path in a direction chosen in proportion to the cosine to the geometric normal (Malley's method over
/// the concentric map, as core/warp.h), or ends it by Russian roulette in proportion to the flux that is left. The
/// shading normal says how much arrives (bsdf/shaded_surface.h). Runs on the instruction set of set_simd().
void diffuse_scatter(const ArrivedPaths& arrived, const ScatteredPaths& scattered);

/// The same by plain loops over core/vec.h and core/warp.h, bit for bit: what the kernel is tested against.
void diffuse_scatter_reference(const ArrivedPaths& arrived, const ScatteredPaths& scattered);

}  // namespace glowworm
