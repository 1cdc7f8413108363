#include "session/gizmo.h"

#include <algorithm>
#include <cmath>

#include "session/camera_control.h"

namespace glowworm {

namespace {

/// Distance in the picture from p to the segment from a to b.
float distance_to_segment(Vec2 p, Vec2 a, Vec2 b) {
  const float dx = b.x - a.x, dy = b.y - a.y, squared = dx * dx + dy * dy;
  const float t = squared > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / squared, 0.0f, 1.0f) : 0.0f;
  return std::hypot(a.x + t * dx - p.x, a.y + t * dy - p.y);
}

}  // namespace

Vec3 axis_direction(int axis) { return {axis == 0 ? 1.0f : 0, axis == 1 ? 1.0f : 0, axis == 2 ? 1.0f : 0}; }

Gizmo make_gizmo(const Camera& camera, Vec3 origin, int width, int height) {
  const Projection at = project(camera, origin, width, height);
  if (!(at.depth > 0)) return {origin, 1};
  const Vec2 beside{at.film.x + 0.1f * static_cast<float>(std::min(width, height)), at.film.y};
  return {origin, std::max(length(unproject(camera, beside, width, height, at.depth) - origin), 1e-6f)};
}

int picked_axis(const Gizmo& gizmo, const Camera& camera, Vec2 film, int width, int height, float reach) {
  const Projection from = project(camera, gizmo.origin, width, height);
  if (!(from.depth > 0)) return -1;
  int best = -1;
  float nearest = reach;
  for (int axis = 0; axis < 3; ++axis) {
    const Projection to = project(camera, gizmo.origin + axis_direction(axis) * gizmo.length, width, height);
    if (!(to.depth > 0)) continue;
    const float distance = distance_to_segment(film, from.film, to.film);
    if (distance >= nearest) continue;
    nearest = distance;
    best = axis;
  }
  return best;
}

float axis_position(const Gizmo& gizmo, int axis, const Camera& camera, Vec2 film, int width, int height,
                    float otherwise) {
  Camera pinhole = camera;
  pinhole.lens_radius = 0;
  const CameraRay ray = generate_ray(pinhole, film, width, height, {0.5f, 0.5f});
  const Vec3 along = axis_direction(axis), offset = gizmo.origin - ray.origin;
  // The closest points of two lines.
  const float b = dot(along, ray.direction), denominator = 1 - b * b;
  if (denominator < 1e-4f) return otherwise;
  return (b * dot(offset, ray.direction) - dot(offset, along)) / denominator;
}

}  // namespace glowworm
