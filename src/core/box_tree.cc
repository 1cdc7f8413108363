#include "core/box_tree.h"

#include <algorithm>
#include <numeric>

namespace glowworm {

BoxTree::BoxTree(std::span<const Box3> boxes) {
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  if (!boxes.empty()) build(boxes, order);
}

void BoxTree::build(std::span<const Box3> boxes, std::span<std::uint32_t> order) {
  const std::size_t at = nodes_.size();
  Node node;
  for (const std::uint32_t i : order) node.box.grow(boxes[i]);
  node.is_leaf = order.size() == 1;
  if (node.is_leaf) node.other = order[0];
  nodes_.push_back(node);
  if (node.is_leaf) return;
  const int axis = node.box.longest_axis();
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return boxes[a].min[axis] + boxes[a].max[axis] < boxes[b].min[axis] + boxes[b].max[axis];
                   });
  build(boxes, order.first(half));
  nodes_[at].other = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, order.subspan(half));
}

}  // namespace glowworm
