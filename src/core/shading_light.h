// What shading normals do to light that arrives at surfaces and leaves them.
#pragma once
#include <algorithm>
#include <cmath>

namespace glowworm {

/// Cosine below which a viewer sees too little of a shading normal's side: there it is turned.
inline constexpr float kLeastShadingCosine = 1e-3f;

/// Where cosines to the surface itself are so small, these factors would have no bounds; they end here.
inline constexpr float kMostShadingFactor = 8;

/// Factor on arriving flux whose photon counts for density estimation: that counts flux by the geometric cosine, the
/// BSDF's outgoing light goes by the shading one (Veach 1997, section 5.3.4). Cosines of the arriving direction to the
/// two normals, without signs.
inline float arrival_correction(float shading_cosine, float geometric_cosine) {
  return std::min(shading_cosine / std::max(geometric_cosine, 1e-6f), kMostShadingFactor);
}

/// Factor on scattered flux: the adjoint BSDF under shading normals (Veach 1997, equation 5.19). Cosines of the
/// directions in and out to the shading normal and to the geometric one, with or without signs.
inline float adjoint_factor(float shading_in, float shading_out, float geometric_in, float geometric_out) {
  return std::min(std::abs(shading_in * geometric_out / std::max(std::abs(geometric_in * shading_out), 1e-9f)),
                  kMostShadingFactor);
}

}  // namespace glowworm
