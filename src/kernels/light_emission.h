// Photons as they leave lights, many at once. The plain loop that they are tested against is sample_emission()
// (scene/light_sampling.h), one photon at a time.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays given to these kernels go on for kLightEmissionPadding - 1 elements behind the
/// last photon: they may be read and written, and mean nothing.
inline constexpr std::size_t kLightEmissionPadding = 16;

/// How photons were chosen. Arrays of `count` elements and the padding, index i one photon.
struct EmissionChoices {
  std::size_t count = 0;
  const float* probability = nullptr;   ///< of the light
  const float* guide_weight = nullptr;  ///< factor on the flux
  const float* place[2] = {};           ///< numbers in [0, 1) for the place on the light
  const float* square[2] = {};          ///< numbers in [0, 1) for the direction
};

/// Triangles that emit; arrays as those of EmissionChoices, three of them the x, y and z of a vector.
struct EmittingTriangles {
  const float* corner[3] = {};               ///< first vertex, metres
  const float* edges[6] = {};                ///< from there to the second and third
  const float* normal[3] = {};               ///< unit, by the winding
  const float* offset = nullptr;             ///< rounding_offset(), metres
  const float* radiance[3] = {};             ///< at the place, W sr^-1 m^-2
  const std::uint32_t* two_sided = nullptr;  ///< 1 or 0
};

/// Light from directions far away, through the disc across them before the scene.
struct DistantLight {
  const float* direction[3] = {};   ///< of the light, unit
  const float* irradiance[3] = {};  ///< across the direction, W m^-2
  float center[3] = {};             ///< of the scene, metres
  float radius = 0;                 ///< of the scene, metres
};

/// Arrays as those of EmissionChoices.
struct EmittedRays {
  float* origin[3] = {};     ///< metres
  float* direction[3] = {};  ///< unit
  float* flux[3] = {};       ///< W, as sample_emission() gives it, times guide_weight
};

/// A place uniform by area and a direction in proportion to the cosine. Runs on the instruction set of set_simd().
void emit_from_triangles(const EmissionChoices& choices, const EmittingTriangles& triangles, const EmittedRays& out);
/// A place uniform on the disc, `radius` before the scene's centre. Runs on the instruction set of set_simd().
void emit_from_afar(const EmissionChoices& choices, const DistantLight& light, const EmittedRays& out);

}  // namespace glowworm
