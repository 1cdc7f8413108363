// Moving a point along the axes of the world with the pointer.
#pragma once
#include "core/vec.h"
#include "scene/camera.h"

namespace glowworm {

/// Handles at a point: one along each axis of the world, drawn `length` metres long.
struct Gizmo {
  Vec3 origin;
  float length = 1;
};

/// A gizmo of constant size on the screen: about a tenth of the picture.
Gizmo make_gizmo(const Camera& camera, Vec3 origin, int width, int height);

/// The axis (0, 1, 2) whose handle is within `reach` pixels of a point of the picture, or -1.
int picked_axis(const Gizmo& gizmo, const Camera& camera, Vec2 film, int width, int height, float reach);

/// Position of the pointer along an axis, in metres from the origin: the point of the axis nearest to the ray under it.
/// Returns `otherwise` if the ray is along the axis.
float axis_position(const Gizmo& gizmo, int axis, const Camera& camera, Vec2 film, int width, int height,
                    float otherwise);

/// The unit vector of an axis.
Vec3 axis_direction(int axis);

}  // namespace glowworm
