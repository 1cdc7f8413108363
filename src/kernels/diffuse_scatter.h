// Scattering of many light paths at once by diffuse surfaces, for nearly all photons.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays for this kernel have kDiffuseScatterPadding - 1 elements after the last path,
/// which may be read and written and have no meaning.
inline constexpr std::size_t kDiffuseScatterPadding = 16;

/// Light paths at their hits. Arrays of `count` elements and the padding, index i one path, three arrays the x, y and z
/// of a vector. If the reflectance is black, the path ends and its other values are not used.
struct ArrivedPaths {
  std::size_t count = 0;
  const float* corner[3] = {};          ///< the first vertex of the triangle, metres
  const float* edges[6] = {};           ///< from there to the second and third
  const float* geometric[3] = {};       ///< unit normal of the triangle, by the winding
  const float* offset = nullptr;        ///< rounding_offset() of the triangle, metres
  const float* vertex_normals[9] = {};  ///< shading normals of the vertices; (0,0,0): the triangle's own
  const float* barycentric[2] = {};     ///< of the hit, weights of the second and third vertex
  const float* reflectance[3] = {};
  const float* back[3] = {};    ///< unit, back along the path
  const float* flux[3] = {};    ///< W
  const float* roulette = {};   ///< number in [0, 1) for Russian roulette
  const float* square[2] = {};  ///< numbers in [0, 1) for the direction
};

/// Outcome of a path, as bits.
enum DiffuseOutcome : std::uint32_t {
  kPhotonLeft = 1,  ///< a photon is stored
  kPathGoesOn = 2,  ///< the path continues
};

/// Arrays as in ArrivedPaths.
struct ScatteredPaths {
  std::uint32_t* outcome = nullptr;
  float* position[3] = {};     ///< of the photon, metres
  float* normal[3] = {};       ///< geometric, unit, on the side where the path arrived
  float* photon_flux[3] = {};  ///< W, with the arrival_factor() of the shading normal
  float* origin[3] = {};       ///< where the path continues, offset from the surface
  float* direction[3] = {};    ///< new direction, unit
  float* flux[3] = {};         ///< of the continued path, W; 0 if it ends
};

/// Scatters each path in a direction sampled in proportion to the cosine to the geometric normal (Malley's method over
/// the concentric map, as core/warp.h), or ends it by Russian roulette in proportion to the remaining flux. The shading
/// normal determines the factor on the flux (bsdf/shaded_surface.h). Runs on the instruction set of set_simd().
void diffuse_scatter(const ArrivedPaths& arrived, const ScatteredPaths& scattered);

}  // namespace glowworm
