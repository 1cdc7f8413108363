#include "scene/default_camera.h"

#include <array>
#include <cmath>
#include <limits>

namespace glowworm {

namespace {

constexpr std::array<Vec3, 6> kSides = {Vec3{0, 0, 1},  Vec3{1, 0, 0}, Vec3{0, 0, -1},
                                        Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}};
constexpr std::size_t kLevel = 4, kUp = 4;  ///< the first four are level

enum class Side : std::uint8_t {
  open,
  wall,   ///< a surface that faces the centre
  solid,  ///< a surface that faces away
};

/// First hit of a ray from `origin` (Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
Side first_surface(const Geometry& geometry, Vec3 origin, Vec3 direction) {
  float nearest = std::numeric_limits<float>::infinity();
  Side side = Side::open;
  for (const auto& [a, b, c] : geometry.triangles) {
    const Vec3 p = geometry.positions[a], e1 = geometry.positions[b] - p, e2 = geometry.positions[c] - p;
    const Vec3 h = cross(direction, e2);
    const float determinant = dot(e1, h);
    if (determinant == 0) continue;
    const Vec3 s = (origin - p) / determinant;
    const float u = dot(s, h);
    const Vec3 q = cross(s, e1);
    const float v = dot(direction, q), t = dot(e2, q);
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest)) continue;
    nearest = t;
    side = determinant > 0 ? Side::wall : Side::solid;
  }
  return side;
}

Vec3 half_extent(const Box3& box) { return box.diagonal() * 0.5f; }

/// Into the open side of a box whose other walls fill the rest of the picture.
Camera into_opening(const Box3& box, Vec3 side) {
  constexpr float kDegrees = 40, kMargin = 1.04f;
  const Vec3 half = half_extent(box);
  const float across = std::abs(side.x) > 0 ? half.z : half.x, depth = std::abs(side.x) > 0 ? half.x : half.z;
  const float distance = std::max(across, half.y) * kMargin / std::tan(kDegrees / 2 * kPi / 180);
  return look_at(box.center() + side * (depth + distance), box.center(), {0, 1, 0}, kDegrees);
}

/// Along the room's longer side, from near one end of it.
Camera within(const Box3& box) {
  constexpr float kDegrees = 75, kBack = 0.8f;
  const Vec3 half = half_extent(box);
  const Vec3 along = half.x > half.z ? Vec3{half.x, 0, 0} : Vec3{0, 0, half.z};
  return look_at(box.center() + along * kBack, box.center() - along, {0, 1, 0}, kDegrees);
}

/// The whole sphere, from the front, a little from above and from the right.
Camera from_outside(Vec3 center, float radius) {
  constexpr float kDegrees = 45;
  const float distance = radius / std::sin(kDegrees / 2 * kPi / 180);
  return look_at(center + normalize(Vec3{0.4f, 0.3f, 1}) * distance, center, {0, 1, 0}, kDegrees);
}

}  // namespace

Camera default_camera(const Geometry& geometry, Vec3 center, float radius) {
  const Box3 box = geometry.bounds();
  std::size_t walls = 0, open = kSides.size();
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    const Side side = first_surface(geometry, center, kSides[i]);
    walls += side == Side::wall;
    if (side == Side::open) open = i;
  }
  const bool is_box = walls == kSides.size() - 1 && open < kLevel;
  const bool is_room = walls == kSides.size() || (walls == kSides.size() - 1 && open == kUp);
  Camera camera = is_box ? into_opening(box, kSides[open]) : is_room ? within(box) : from_outside(center, radius);
  camera.name = "default";
  return camera;
}

}  // namespace glowworm
