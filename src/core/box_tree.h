// A tree over boxes that finds whether a ray meets one.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// Whether a ray meets a box, but for the rounding of its direction.
/// @param inverse of the coordinates of the direction @param length of the ray, in multiples of its direction
/// @param margin around the box, metres
inline bool meets_box(const Box3& box, Vec3 origin, Vec3 inverse, float length, float margin = 0) {
  float near = 0, far = length;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = box.min[axis] - margin - origin[axis], high = box.max[axis] + margin - origin[axis];
    const bool backwards = std::signbit(inverse[axis]);
    const float in = (backwards ? high : low) * inverse[axis], out = (backwards ? low : high) * inverse[axis];
    // Where a ray runs along a side, 0 times infinity is no number, which changes neither.
    near = in > near ? in : near;
    far = out < far ? out : far;
  }
  return near <= far * (1 + 0x1p-20f);
}

/// A binary tree of boxes. Immutable; calls are thread-safe.
class BoxTree {
 public:
  BoxTree() = default;
  /// @param boxes not empty ones
  explicit BoxTree(std::vector<Box3> boxes);

  bool empty() const { return nodes_.empty(); }
  /// Whether a ray meets one of the boxes.
  /// @param length in multiples of the direction, may be infinite @param margin around each box, metres
  bool meets(Vec3 origin, Vec3 direction, float length, float margin) const;

 private:
  static constexpr std::uint32_t kMaxDepth = 32;
  /// A leaf has one box and `other` 0; the first child of an inner node follows it.
  struct Node {
    Box3 box;
    std::uint32_t other = 0;
  };

  void build(std::vector<Box3>& boxes, std::size_t first, std::size_t last);

  std::vector<Node> nodes_;
};

}  // namespace glowworm
