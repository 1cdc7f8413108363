// The built-in scenes, one function each; builtin.h gives them by name.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// The measured Cornell box in metres: 38 triangles, open towards the camera. Source of geometry, spectra and camera:
/// https://www.graphics.cornell.edu/online/box/data.html.
SceneDescription builtin_cornell();

/// A closed box of side 1 m around the origin whose walls have albedo 0.5 and all emit radiance 1 inwards: the radiance
/// is 1 / (1 - 0.5) = 2 everywhere, in every direction.
SceneDescription builtin_furnace_box();

/// Adds a diffuse material and returns its index.
std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance);
/// Adds a one-sided emission and returns its index.
std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance);

}  // namespace glowworm
