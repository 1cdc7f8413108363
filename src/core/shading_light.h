// What shading normals do to flux that arrives at surfaces and leaves them; bsdf/shaded_surface.h says why.
#pragma once
#include <algorithm>
#include <cmath>

namespace glowworm {

/// Where cosines to the surface itself are small, the factors on flux have no bounds; they end here. With an angle a
/// between the normals, that takes sin^2(a) / kMaxShadingFactor of even light.
inline constexpr float kMaxShadingFactor = 256;
/// The least cosine that the factors divide by.
inline constexpr float kMinShadingCosine = 1e-6f;

/// Factor on arriving flux: density estimation counts flux by the geometric cosine, BSDFs count it by the shading one,
/// of the direction and, where it lies on the same side, of its mirror image in the surface. The mean of the factor
/// over uniform light is 1.
/// @param shading, geometric cosines of the arriving direction to the two normals, of which the latter is not negative
/// @param normals cosine between the normals
inline float arrival_factor(float shading, float geometric, float normals) {
  const float mirrored = shading - 2 * geometric * normals;
  const float both = std::max(shading, 0.0f) + std::max(mirrored, 0.0f);
  return std::min(both / std::max(geometric, kMinShadingCosine), kMaxShadingFactor);
}

}  // namespace glowworm
