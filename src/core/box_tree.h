// A tree over boxes, which finds those that a ray meets.
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
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
  explicit BoxTree(std::span<const Box3> boxes);

  bool empty() const { return nodes_.empty(); }
  /// Calls visit(index) for each box that a ray meets, in an order of the tree's, until visit returns false.
  /// @param length in multiples of the direction, may be infinite @param margin around each box, metres
  template <class Visit>
  void for_met(Vec3 origin, Vec3 direction, float length, float margin, Visit&& visit) const {
    if (nodes_.empty()) return;
    const Vec3 inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
    std::uint32_t stack[kMaxDepth + 1], depth = 0, at = 0;
    for (;;) {
      const Node& node = nodes_[at];
      if (meets_box(node.box, origin, inverse, length, margin)) {
        if (!node.is_leaf) {
          stack[depth++] = node.other;
          ++at;
          continue;
        }
        if (!visit(node.other)) return;
      }
      if (depth == 0) return;
      at = stack[--depth];
    }
  }
  /// Whether a ray meets one of the boxes; as for_met().
  bool meets(Vec3 origin, Vec3 direction, float length, float margin) const {
    bool any = false;
    for_met(origin, direction, length, margin, [&](std::uint32_t) { return !(any = true); });
    return any;
  }

 private:
  static constexpr std::uint32_t kMaxDepth = 32;
  /// A leaf has one box, and its index as `other`. The first child of an inner node follows it; `other` is the second.
  struct Node {
    Box3 box;
    std::uint32_t other = 0;
    bool is_leaf = false;
  };

  void build(std::span<const Box3> boxes, std::span<std::uint32_t> order);

  std::vector<Node> nodes_;
};

}  // namespace glowworm
