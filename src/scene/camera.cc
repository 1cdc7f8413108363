#include "scene/camera.h"

#include <algorithm>
#include <cmath>

#include "core/frame.h"
#include "core/warp.h"

namespace glowworm {

namespace {

/// The same in units of half_extent.
ScreenWindow unit_window(const Camera& camera, float width, float height) {
  const float* window = camera.window;
  if (window[0] != 0 || window[1] != 0 || window[2] != 0 || window[3] != 0)
    return {window[0], window[1], window[2], window[3]};
  const float shorter = std::min(width, height);
  return {-width / shorter, width / shorter, -height / shorter, height / shorter};
}

/// The point of the picture plane under `film`, in units of half_extent.
Vec2 screen_point(const Camera& camera, Vec2 film, int width, int height) {
  const float w = static_cast<float>(std::max(width, 1)), h = static_cast<float>(std::max(height, 1));
  const auto [left, right, bottom, top] = unit_window(camera, w, h);
  return {left + (right - left) * (film.x / w), top + (bottom - top) * (film.y / h)};
}

}  // namespace

ScreenWindow screen_window(const Camera& camera, int width, int height) {
  const auto [left, right, bottom, top] =
      unit_window(camera, static_cast<float>(std::max(width, 1)), static_cast<float>(std::max(height, 1)));
  const float unit = camera.half_extent;
  return {left * unit, right * unit, bottom * unit, top * unit};
}

CameraRay generate_ray(const Camera& camera, Vec2 film, int width, int height, Vec2 lens) {
  const Transform& m = camera.to_world;
  const Vec2 p = screen_point(camera, film, width, height) * camera.half_extent;
  // Lengths are metres in the world, so only the directions of the axes count if to_world scales.
  Vec3 origin = m.translation, direction;
  if (is_angular(camera.kind)) {
    const Vec3 local = angular_direction(camera.kind, p);
    if (CameraRay{{}, local}.is_blind()) return {origin, local};
    direction = normalize(m.vector(local));
  } else if (camera.kind == CameraKind::orthographic) {
    origin += normalize(m.x) * p.x + normalize(m.y) * p.y;
    direction = normalize(m.z);
  } else {
    direction = m.vector({p.x, p.y, 1});
  }
  if (camera.lens_radius > 0) {
    // Metres along the axis for each length of `direction`.
    const float axial_speed = camera.kind == CameraKind::perspective ? length(m.z) : 1;
    const Vec3 focus = origin + direction * (camera.focal_distance / axial_speed);
    const Vec2 disk = square_to_disk(lens) * camera.lens_radius;
    origin += normalize(m.x) * disk.x + normalize(m.y) * disk.y;
    direction = focus - origin;
  }
  return {origin, normalize(direction)};
}

Vec3 angular_direction(CameraKind kind, Vec2 p) {
  if (kind == CameraKind::panorama) {
    if (std::abs(p.x) > kPi || std::abs(p.y) > kPi / 2) return {0, 0, 0};
    const float level = std::cos(p.y);
    return {level * std::sin(p.x), std::sin(p.y), level * std::cos(p.x)};
  }
  const float r = std::hypot(p.x, p.y);
  if (kind == CameraKind::hemispherical) {
    if (r > 1) return {0, 0, 0};
    return {p.x, p.y, std::sqrt((1 - r) * (1 + r))};
  }
  if (r > kPi) return {0, 0, 0};
  const float scale = r > 0 ? std::sin(r) / r : 1;
  return {p.x * scale, p.y * scale, std::cos(r)};
}

Vec2 angular_plane(CameraKind kind, Vec3 d) {
  if (kind == CameraKind::panorama) return {std::atan2(d.x, d.z), std::atan2(d.y, std::hypot(d.x, d.z))};
  if (kind == CameraKind::hemispherical) return {d.x, d.y};
  const float sine = std::hypot(d.x, d.y), scale = sine > 0 ? std::atan2(sine, d.z) / sine : 1;
  return {d.x * scale, d.y * scale};
}

double solid_angle_density(CameraKind kind, Vec2 p) {
  const double r = std::hypot(double{p.x}, double{p.y});
  if (kind == CameraKind::panorama) return std::abs(p.x) > kPi || std::abs(p.y) > kPi / 2 ? 0 : std::cos(double{p.y});
  if (kind == CameraKind::hemispherical) return r < 1 ? 1 / std::sqrt((1 - r) * (1 + r)) : 0;
  if (r > kPi) return 0;
  return r > 0 ? std::sin(r) / r : 1;
}

float half_extent_of(CameraKind kind, float field_of_view_degrees) {
  const float half = field_of_view_degrees * (kPi / 360);
  if (kind == CameraKind::perspective) return std::tan(half);
  return kind == CameraKind::hemispherical ? std::sin(std::min(half, kPi / 2)) : half;
}

bool same_view(const Camera& a, const Camera& b) {
  const Transform &m = a.to_world, &n = b.to_world;
  return a.kind == b.kind && m.x == n.x && m.y == n.y && m.z == n.z && m.translation == n.translation &&
         a.half_extent == b.half_extent && std::equal(std::begin(a.window), std::end(a.window), std::begin(b.window)) &&
         a.lens_radius == b.lens_radius && a.focal_distance == b.focal_distance;
}

Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float field_of_view_degrees) {
  const Vec3 towards = target - eye;
  const Vec3 forward = length_squared(towards) > 0 ? normalize(towards) : Vec3{0, 0, -1};
  Vec3 right = cross(forward, up);
  // When looking along `up`, any roll is possible.
  if (length_squared(right) <= 1e-12f * length_squared(up)) right = Frame::from_normal(forward).s;
  right = normalize(right);
  Camera camera;
  camera.to_world = {right, cross(right, forward), forward, eye};
  camera.half_extent = half_extent_of(camera.kind, field_of_view_degrees);
  return camera;
}

}  // namespace glowworm
