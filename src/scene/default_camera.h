// A default view of a scene without cameras.
#pragma once
#include "scene/camera.h"
#include "scene/geometry.h"

namespace glowworm {

/// Returns a camera that sees the scene: from outside and slightly above. If the scene is a box with one open side (its
/// other walls face the centre), straight into the opening.
/// If walls surround it, from inside the room or court.
/// @param center, radius of a sphere around the geometry, metres
Camera default_camera(const Geometry& geometry, Vec3 center, float radius);

}  // namespace glowworm
