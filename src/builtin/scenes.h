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

/// A closed sphere of radius 0.5 m around the origin, flat-shaded, with the same walls and the same answer: 2
/// everywhere.
SceneDescription builtin_furnace_sphere();
/// A ball of clear glass (index 1.5) over a floor under a small bright square light.
SceneDescription builtin_glass_sphere();
/// An upright metal ring on a floor under a small light from the side, which draws a cardioid caustic.
SceneDescription builtin_ring();
/// A closed room of 5 x 3 x 4 m with thick walls and one window of a hundredth of its inner surface, under sun and sky.
SceneDescription builtin_window_room();

/// A furnished room in which nearly all light is indirect: it comes through a door left ajar from a corridor with a
/// lamp. All diffuse.
SceneDescription builtin_ajar();

/// Adds a diffuse material and returns its index.
std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance);
/// Adds a one-sided emission and returns its index.
std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance);

}  // namespace glowworm
