#include "session/camera_control.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/frame.h"

namespace glowworm {

namespace {

/// Cosine of the smallest angle to `up` at which a camera may look: about 2 degrees.
constexpr float kSteepest = 0.9994f;

Transform turned(const Transform& m, Vec3 rotation, Vec3 about) {
  return {rotate(m.x, rotation), rotate(m.y, rotation), rotate(m.z, rotation),
          about + rotate(m.translation - about, rotation)};
}

Camera turn_about(const Camera& camera, Vec3 point, Vec3 up, float yaw, float pitch) {
  Camera out = camera;
  out.to_world = turned(out.to_world, up * yaw, point);
  const Vec3 ahead = forward(out), across = cross(ahead, up);
  if (length_squared(across) < 1e-6f) return out;
  const float now = std::asin(std::clamp(dot(ahead, up), -1.0f, 1.0f)), steepest = std::asin(kSteepest);
  const float next = std::clamp(now + pitch, std::min(-steepest, now), std::max(steepest, now));
  out.to_world = turned(out.to_world, normalize(across) * (next - now), point);
  return out;
}

}  // namespace

Vec3 nearest_up(const Camera& camera) {
  const Vec3 up = normalize(camera.to_world.y);
  int axis = 1;
  for (const int other : {0, 2})
    if (std::abs(up[other]) > std::abs(up[axis]) + 1e-4f) axis = other;
  const float sign = up[axis] < 0 ? -1.0f : 1.0f;
  return {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
}

Vec3 forward(const Camera& camera) { return normalize(camera.to_world.z); }

Camera orbit(const Camera& camera, float pivot_distance, Vec3 up, float yaw, float pitch) {
  return turn_about(camera, camera.to_world.translation + forward(camera) * pivot_distance, up, yaw, pitch);
}

Camera look(const Camera& camera, Vec3 up, float yaw, float pitch) {
  return turn_about(camera, camera.to_world.translation, up, yaw, pitch);
}

Camera fly(const Camera& camera, Vec3 by) {
  Camera out = camera;
  const Transform& m = camera.to_world;
  out.to_world.translation += normalize(m.x) * by.x + normalize(m.y) * by.y + normalize(m.z) * by.z;
  return out;
}

Camera look_towards(const Camera& camera, Vec3 point, Vec3 up) {
  const Vec3 offset = point - camera.to_world.translation;
  if (length_squared(offset) == 0) return camera;
  const Vec3 wanted = normalize(offset);
  if (std::abs(dot(wanted, up)) > kSteepest) return camera;
  return placed(camera, camera.to_world.translation, point, up);
}

Camera placed(const Camera& camera, Vec3 eye, Vec3 target, Vec3 up) {
  const Vec3 offset = target - eye, across = cross(offset, up);
  if (!(length_squared(offset) > 0) || !(length_squared(across) > 1e-12f * length_squared(offset) * length_squared(up)))
    throw Error("a view needs two different points, and an up that is not along the line between them");
  const Vec3 z = normalize(offset), right = normalize(across);
  Camera out = camera;
  const Transform& m = camera.to_world;
  // look_at() makes x, y, z a left-handed frame; a camera whose frame is right-handed mirrors its picture.
  const float mirrored = m.determinant() > 0 ? -1.0f : 1.0f;
  out.to_world = {right * (length(m.x) * mirrored), cross(right, z) * length(m.y), z * length(m.z), eye};
  return out;
}

}  // namespace glowworm
