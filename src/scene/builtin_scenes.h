// The built-in scenes, one function each; builtin.h gives them by name.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// The measured Cornell box in metres: 38 triangles, open towards the camera. Source of geometry, spectra and camera:
/// https://www.graphics.cornell.edu/online/box/data.html.
SceneDescription builtin_cornell();

/// A colonnaded court of two storeys, 31 x 16 x 12 m, in sun and under a clear sky, all diffuse: about 100,000
/// triangles. Cameras: main (along the court), gallery (in the dim lower gallery), overview.
SceneDescription builtin_atrium();
/// The same with finer mouldings and more ornaments: over 1,200,000 triangles, to time ray tracing with.
SceneDescription builtin_atrium_large();

/// A closed box of side 1 m around the origin whose walls have albedo 0.5 and all emit radiance 1 inwards: the radiance
/// is 1 / (1 - 0.5) = 2 everywhere, in every direction.
SceneDescription builtin_furnace_box();

/// Adds a diffuse material and returns its index.
std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance);
/// Adds a one-sided emission and returns its index.
std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance);

}  // namespace glowworm
