// A view of a scene that names no camera.
#pragma once
#include "scene/camera.h"
#include "scene/geometry.h"

namespace glowworm {

/// A camera that sees the scene: from outside and a little above; where the scene is a box open to one side (its other
/// walls face the middle), straight into the opening; where walls stand all around, from within the room
/// or court.
/// @param center, radius of a sphere around the geometry, metres
Camera default_camera(const Geometry& geometry, Vec3 center, float radius);

}  // namespace glowworm
