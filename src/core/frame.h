// Orthonormal frames: directions in and out of the shading coordinates in which the normal is +z.
#pragma once
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

}  // namespace glowworm
