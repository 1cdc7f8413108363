// Flux of each light source.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// Radiance of an emission averaged over a triangle, W sr^-1 m^-2: exact where it is constant, the mean of points, one
/// to a texel, where it is textured; black only where all texels are. `scene` gives the emissions and textures; its own
/// geometry is not looked at.
RGB mean_radiance(const Geometry& geometry, const SceneDescription& scene, std::uint32_t triangle);

/// Flux of an emissive triangle, W: pi A L, twice where it is two-sided.
RGB triangle_power(const Geometry& geometry, const SceneDescription& scene, std::uint32_t triangle);

/// Flux of a light, W. For a directional light, the flux through a disc of the scene's radius (metres).
RGB light_power(const Light& light, float scene_radius);

/// Share (0 to 1) of a spot's intensity at an angle whose cosine to its direction is cos_theta: Khronos'
/// KHR_lights_punctual, "Inner and Outer Cone Angles", or smoothstep in the cosine as in pbrt-v4's spot.
float spot_falloff(const Light& light, float cos_theta);

/// Mean of spot_falloff() over the cosines between the two cones.
inline float mean_spot_falloff(const Light& light) { return light.gltf_falloff ? 1.0f / 3 : 0.5f; }

}  // namespace glowworm
