// Effects of shading normals on arriving and leaving flux; bsdf/shaded_surface.h explains them.
#pragma once
#include <algorithm>

namespace glowworm {

/// The factors are unbounded as the cosine to the geometric normal goes to zero, so they are clamped to this. If the
/// normals differ by an angle a, the clamp loses a share sin^2(a) / kMaxShadingFactor of uniform light.
inline constexpr float kMaxShadingFactor = 256;
/// The smallest cosine that the factors divide by.
inline constexpr float kMinShadingCosine = 1e-6f;

/// Factor on arriving flux. Density estimation weights flux by the geometric cosine, but BSDFs weight it by the shading
/// cosine. The factor converts one into the other, and adds the direction's mirror image in the surface if that is
/// above the shading normal. Its mean over uniform light is 1.
/// @param shading, geometric cosines of the arriving direction to the two normals; `geometric` is not negative
/// @param normals cosine between the normals
inline float arrival_factor(float shading, float geometric, float normals) {
  const float mirrored = shading - 2 * geometric * normals;
  const float both = std::max(shading, 0.0f) + std::max(mirrored, 0.0f);
  return std::min(both / std::max(geometric, kMinShadingCosine), kMaxShadingFactor);
}

}  // namespace glowworm
