// Points and affine maps in double precision: the coordinates of files may have more digits than float holds.
#pragma once
#include <cmath>

#include "core/transform.h"
#include "core/vec.h"

namespace glowworm {

/// Three doubles: a point (metres) or a direction.
struct Vec3d {
  double x = 0, y = 0, z = 0;
  constexpr Vec3d() = default;
  constexpr Vec3d(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  constexpr explicit Vec3d(Vec3 v) : x(v.x), y(v.y), z(v.z) {}
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vec3d operator+(Vec3d a, Vec3d b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3d operator-(Vec3d a) { return {-a.x, -a.y, -a.z}; }
inline Vec3d operator*(Vec3d a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline bool operator==(Vec3d a, Vec3d b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline double dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3d cross(Vec3d a, Vec3d b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3d a) { return std::sqrt(dot(a, a)); }
inline bool is_finite(Vec3d a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// The nearest floats.
inline Vec3 narrow(Vec3d v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

/// A Transform in double precision.
struct TransformDouble {
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, translation{0, 0, 0};

  Vec3d vector(Vec3d v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3d point(Vec3d p) const { return vector(p) + translation; }
  double determinant() const { return dot(x, cross(y, z)); }
  /// The nearest map in floats to places relative to `origin`.
  Transform relative_to(Vec3 origin) const {
    return {narrow(x), narrow(y), narrow(z), narrow(translation - Vec3d(origin))};
  }
};

/// The map that applies b, then a.
inline TransformDouble operator*(const TransformDouble& a, const TransformDouble& b) {
  return {a.vector(b.x), a.vector(b.y), a.vector(b.z), a.point(b.translation)};
}

/// The inverse of an affine map. The determinant must not be zero.
inline TransformDouble inverse(const TransformDouble& m) {
  const double d = 1 / m.determinant();
  const Vec3d r0 = cross(m.y, m.z) * d, r1 = cross(m.z, m.x) * d, r2 = cross(m.x, m.y) * d;
  TransformDouble out{{r0.x, r1.x, r2.x}, {r0.y, r1.y, r2.y}, {r0.z, r1.z, r2.z}, {0, 0, 0}};
  out.translation = -out.vector(m.translation);
  return out;
}

}  // namespace glowworm
