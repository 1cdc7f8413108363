// Camera movements: each function returns the moved camera. Mirroring cameras stay mirrored, and all properties that
// are not mentioned (field of view, lens, window) stay.
#pragma once
#include "core/vec.h"
#include "scene/projection.h"

namespace glowworm {

/// The world axis, with sign, nearest to the camera's up direction: y for most files, z for some.
Vec3 nearest_up(const Camera& camera);

/// Unit viewing direction.
Vec3 forward(const Camera& camera);

/// Turns around the point `pivot_distance` metres in front: by `yaw` radians about `up`, then by `pitch` about the
/// camera's own horizontal; stops short of looking along `up`.
Camera orbit(const Camera& camera, float pivot_distance, Vec3 up, float yaw, float pitch);

/// Turns in place, by the same angles.
Camera look(const Camera& camera, Vec3 up, float yaw, float pitch);

/// Moves along its own axes (right, up, forward), metres.
Camera fly(const Camera& camera, Vec3 by);

/// Turns to look at a point of the world, keeping `up` up.
Camera look_towards(const Camera& camera, Vec3 point, Vec3 up);

/// Places the camera at `eye`, looking at `target`. Throws Error if both are equal or `up` is along the view.
Camera placed(const Camera& camera, Vec3 eye, Vec3 target, Vec3 up);

}  // namespace glowworm
