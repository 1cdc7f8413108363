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

/// A gizmo that looks equally large wherever it is: about a tenth of the picture.
Gizmo make_gizmo(const Camera& camera, Vec3 origin, int width, int height);

/// The axis (0, 1, 2) whose handle is within `reach` pixels of a point of the picture, or -1.
int picked_axis(const Gizmo& gizmo, const Camera& camera, Vec2 film, int width, int height, float reach);

/// How far along an axis from the origin, in metres, the pointer is: the point of the axis nearest to the ray under it.
/// The last value holds (`otherwise`) where the ray is along the axis.
float axis_position(const Gizmo& gizmo, int axis, const Camera& camera, Vec2 film, int width, int height,
                    float otherwise);

/// The unit vector of an axis.
Vec3 axis_direction(int axis);

}  // namespace glowworm
