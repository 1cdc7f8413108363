// Flux of each light source.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// Flux of emissive triangles, W: pi A L, or twice that if they are two-sided. L of a textured emission is the mean of
/// samples, one per texel, or fewer if that would exceed about 20 million samples in total. It is black only if all
/// texels were read and are black. Runs on all threads. `scene` provides emissions and textures; its own geometry is
/// ignored.
std::vector<RGB> triangle_powers(const Geometry& geometry, const SceneDescription& scene,
                                 const std::vector<std::uint32_t>& triangles);

/// Flux of a light, W. For a directional light, the flux through a disc of the scene's radius (metres).
RGB light_power(const Light& light, float scene_radius);

/// Share (0 to 1) of a spot's intensity at an angle with cosine cos_theta to its direction.
float spot_falloff(const Light& light, float cos_theta);

/// Intensity of a luminaire in a direction (unit, world space, away from it), as a factor on Light::intensity.
float table_intensity(const Light& luminaire, Vec3 direction);

/// Radiance of an emission in a direction (unit, world space, away from it), as a factor on Emission::radiance.
inline float relative_radiance(const Emission& e, Vec3 direction) {
  if (!e.profile) return 1;
  return e.profile->relative_radiance(luminaire_axes(e.right, e.aim).to_local(direction));
}

/// Mean of spot_falloff() over the cosines between the two cones.
inline float mean_spot_falloff(const Light& light) {
  return light.falloff == SpotFalloff::smoothstep ? 0.5f : light.falloff == SpotFalloff::quadratic ? 1.0f / 3 : 0.2f;
}

}  // namespace glowworm
