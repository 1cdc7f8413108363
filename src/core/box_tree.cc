#include "core/box_tree.h"

#include <algorithm>

namespace glowworm {

BoxTree::BoxTree(std::vector<Box3> boxes) {
  if (!boxes.empty()) build(boxes, 0, boxes.size());
}

void BoxTree::build(std::vector<Box3>& boxes, std::size_t first, std::size_t last) {
  const std::size_t at = nodes_.size();
  Node node;
  for (std::size_t i = first; i < last; ++i) node.box.grow(boxes[i]);
  nodes_.push_back(node);
  if (last - first == 1) return;
  const int axis = node.box.longest_axis();
  const std::size_t middle = first + (last - first) / 2;
  const auto place = [&](std::size_t i) { return boxes.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(place(first), place(middle), place(last), [axis](const Box3& a, const Box3& b) {
    return a.min[axis] + a.max[axis] < b.min[axis] + b.max[axis];
  });
  build(boxes, first, middle);
  nodes_[at].other = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, middle, last);
}

bool BoxTree::meets(Vec3 origin, Vec3 direction, float length, float margin) const {
  if (nodes_.empty()) return false;
  const Vec3 inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
  std::uint32_t stack[kMaxDepth + 1], depth = 0, at = 0;
  for (;;) {
    const Node& node = nodes_[at];
    if (meets_box(node.box, origin, inverse, length, margin)) {
      if (node.other == 0) return true;
      stack[depth++] = node.other;
      ++at;
      continue;
    }
    if (depth == 0) return false;
    at = stack[--depth];
  }
}

}  // namespace glowworm
