// Emission of many photons at once. The reference for tests is sample_emission() (scene/light_sampling.h), which
// samples one photon at a time.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Lanes of the widest vector. Arrays for these kernels have kLightEmissionPadding - 1 elements after the last photon,
/// which may be read and written and have no meaning.
inline constexpr std::size_t kLightEmissionPadding = 16;

/// How each photon was chosen. Arrays of `count` elements and the padding, one element per photon.
struct EmissionChoices {
  std::size_t count = 0;
  const float* probability = nullptr;   ///< of the light
  const float* guide_weight = nullptr;  ///< factor on the flux
  const float* place[2] = {};           ///< numbers in [0, 1) for the point on the light
  const float* square[2] = {};          ///< numbers in [0, 1) for the direction
};

/// Emitting triangles; arrays as in EmissionChoices, three of them for x, y and z of a vector.
struct EmittingTriangles {
  const float* corner[3] = {};               ///< first vertex, metres
  const float* edges[6] = {};                ///< from there to the second and third
  const float* normal[3] = {};               ///< unit, by the winding
  const float* offset = nullptr;             ///< rounding_offset(), metres
  const float* radiance[3] = {};             ///< at the point, W sr^-1 m^-2
  const std::uint32_t* two_sided = nullptr;  ///< 1 or 0
};

/// A directional light or environment. Photons start on a disc in front of the scene, perpendicular to the direction.
struct DistantLight {
  const float* direction[3] = {};   ///< of the light, unit
  const float* irradiance[3] = {};  ///< perpendicular to the direction, W m^-2
  float center[3] = {};             ///< of the scene, metres
  float radius = 0;                 ///< of the scene, metres
};

/// Arrays as in EmissionChoices.
struct EmittedRays {
  float* origin[3] = {};     ///< metres
  float* direction[3] = {};  ///< unit
  float* flux[3] = {};       ///< W, as from sample_emission(), times guide_weight
};

/// Samples a point uniformly by area, and a direction in proportion to the cosine. Runs on the instruction set of
/// set_simd().
void emit_from_triangles(const EmissionChoices& choices, const EmittingTriangles& triangles, const EmittedRays& out);
/// Samples a point uniformly on the disc, `radius` in front of the scene's centre. Runs on the instruction set of
/// set_simd().
void emit_from_afar(const EmissionChoices& choices, const DistantLight& light, const EmittedRays& out);

}  // namespace glowworm
