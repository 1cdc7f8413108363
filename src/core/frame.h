// Orthonormal frames: directions in and out of the shading coordinates in which the normal is +z.
#pragma once
#include <cmath>

#include "core/vec.h"

namespace glowworm {

/// An orthonormal right-handed frame whose third axis is the normal.
struct Frame {
  Vec3 s, t, n;

  /// A frame around the unit vector n (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
  static Frame from_normal(Vec3 n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  Vec3 to_local(Vec3 v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
  Vec3 to_world(Vec3 v) const { return s * v.x + t * v.y + n * v.z; }
};

/// v turned by a rotation vector (axis times radians; Rodrigues' formula).
inline Vec3 rotate(Vec3 v, Vec3 rotation_vector) {
  const float angle = length(rotation_vector);
  if (angle == 0) return v;
  const Vec3 axis = rotation_vector / angle;
  const float c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

}  // namespace glowworm
