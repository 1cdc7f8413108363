// Affine maps of space.
#pragma once
#include "core/vec.h"

namespace glowworm {

/// An affine map: the columns of its linear part, and its translation (metres).
struct Transform {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, translation{0, 0, 0};

  Vec3 vector(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3 point(Vec3 p) const { return vector(p) + translation; }
  float determinant() const { return dot(x, cross(y, z)); }
  /// Transforms a normal by the cofactor matrix. That needs no inverse, and mirroring maps keep the normal on its side
  /// of the surface. The result is not normalised.
  Vec3 normal(Vec3 n) const {
    const Vec3 mapped = cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z;
    return determinant() < 0 ? -mapped : mapped;
  }
};

/// The map that applies b, then a.
inline Transform operator*(const Transform& a, const Transform& b) {
  return {a.vector(b.x), a.vector(b.y), a.vector(b.z), a.point(b.translation)};
}

/// The inverse of an affine map. The determinant must not be zero.
inline Transform inverse(const Transform& m) {
  const float d = 1 / m.determinant();
  const Vec3 r0 = cross(m.y, m.z) * d, r1 = cross(m.z, m.x) * d, r2 = cross(m.x, m.y) * d;
  Transform out{{r0.x, r1.x, r2.x}, {r0.y, r1.y, r2.y}, {r0.z, r1.z, r2.z}, {0, 0, 0}};
  out.translation = -out.vector(m.translation);
  return out;
}

}  // namespace glowworm
