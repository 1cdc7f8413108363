#include "scene/projection.h"

#include <algorithm>

namespace glowworm {

Projection project(const Camera& camera, Vec3 point, int width, int height) {
  const Transform& m = camera.to_world;
  const Vec3 offset = point - m.translation;
  Vec2 plane;
  Projection out;
  if (camera.kind == CameraKind::orthographic) {
    plane = {dot(offset, normalize(m.x)), dot(offset, normalize(m.y))};
    out.depth = dot(offset, normalize(m.z));
  } else if (is_angular(camera.kind)) {
    const Vec3 seen = inverse(m).vector(offset);
    plane = angular_plane(camera.kind, normalize(seen));
    out.depth = camera.kind == CameraKind::hemispherical && seen.z < 0 ? seen.z : length(offset);
  } else {
    const float d = 1 / m.determinant();
    const float z = dot(cross(m.x, m.y), offset) * d;
    plane = {dot(cross(m.y, m.z), offset) * d / z, dot(cross(m.z, m.x), offset) * d / z};
    out.depth = z > 0 ? length(offset) : z;
  }
  const float w = static_cast<float>(std::max(width, 1)), h = static_cast<float>(std::max(height, 1));
  float left = camera.window[0], right = camera.window[1], bottom = camera.window[2], top = camera.window[3];
  if (left == 0 && right == 0 && bottom == 0 && top == 0) {
    right = w / std::min(w, h);
    left = -right;
    top = h / std::min(w, h);
    bottom = -top;
  }
  const Vec2 p = plane * (1 / camera.half_extent);
  out.film = {(p.x - left) / (right - left) * w, (top - p.y) / (top - bottom) * h};
  return out;
}

Vec3 unproject(const Camera& camera, Vec2 film, int width, int height, float depth) {
  Camera pinhole = camera;
  pinhole.lens_radius = 0;
  const CameraRay ray = generate_ray(pinhole, film, width, height, {0.5f, 0.5f});
  return ray.origin + ray.direction * depth;
}

}  // namespace glowworm
