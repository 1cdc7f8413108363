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
/// The atrium with finer mouldings and more ornaments: over 1,200,000 triangles, for timing ray tracing.
SceneDescription builtin_atrium_large();

/// A closed box of side 1 m around the origin. All walls have albedo 0.5 and emit radiance 1 W sr^-1 m^-2 inwards, so
/// the radiance is 1 / (1 - 0.5) = 2 W sr^-1 m^-2 everywhere and in every direction.
SceneDescription builtin_furnace_box();

/// A closed sphere of radius 0.5 m around the origin, flat-shaded, with the same walls and the same radiance of 2 W
/// sr^-1 m^-2.
SceneDescription builtin_furnace_sphere();
/// A ball of clear glass (index 1.5) over a floor under a small bright square light.
SceneDescription builtin_glass_sphere();
/// An upright metal ring on a floor, lit from the side by a small light: it casts a cardioid caustic.
SceneDescription builtin_ring();
/// A closed room of 5 x 3 x 4 m with thick walls, under sun and sky. Its only window is a hundredth of its inner
/// surface.
SceneDescription builtin_window_room();

/// A room of 4 x 2.8 x 5 m full of haze, into which the sun shines through the slats of a window.
SceneDescription builtin_shafts();
/// A ball of clear glass in gas over a floor: its caustic is seen in the gas.
SceneDescription builtin_glass_in_gas();

/// A furnished room with nearly only indirect light: a lamp in a corridor shines through a door left ajar. All diffuse.
SceneDescription builtin_ajar();

class MeshBuilder;

/// Adds a material and returns its index.
std::uint32_t add_material(SceneDescription& scene, const Material& material);
/// Smooth glass of index 1.5 that absorbs nothing.
Material clear_glass();
/// Adds a diffuse material and returns its index.
std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance);
/// Adds a one-sided emission and returns its index.
std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance);
/// Adds a square at `center` that emits towards `target`. @param side metres
void add_square_light(SceneDescription& scene, MeshBuilder& mesh, Vec3 center, Vec3 target, float side, RGB radiance);
/// Adds an upright camera. @param degrees field of view
void add_camera(SceneDescription& scene, const char* name, Vec3 eye, Vec3 target, float degrees);
/// Sets the default size of pictures, in pixels.
void set_size(SceneDescription& scene, int width, int height);

}  // namespace glowworm
