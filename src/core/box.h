// Axis-aligned boxes.
#pragma once
#include <algorithm>
#include <limits>

#include "core/vec.h"

namespace glowworm {

/// An axis-aligned box in metres. A default-constructed box is empty: min is above max.
struct Box3 {
  Vec3 min{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
           std::numeric_limits<float>::infinity()};
  Vec3 max{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
           -std::numeric_limits<float>::infinity()};

  bool empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
  Vec3 diagonal() const { return max - min; }
  Vec3 center() const { return (min + max) * 0.5f; }
  void grow(Vec3 p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void grow(const Box3& b) {
    grow(b.min);
    grow(b.max);
  }
  bool contains(Vec3 p) const {
    return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z && p.z <= max.z;
  }
  /// The axis (0, 1 or 2) of the longest side; the first of them if several are equal.
  int longest_axis() const {
    const Vec3 d = diagonal();
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  }
};

}  // namespace glowworm
