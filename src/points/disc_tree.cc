#include "points/disc_tree.h"

#include <algorithm>
#include <numeric>

namespace glowworm {

DiscTree::DiscTree(std::vector<Disc> discs) : discs_(std::move(discs)), order_(discs_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!discs_.empty()) build(0, static_cast<std::uint32_t>(discs_.size()));
}

/// Appends the node of discs order_[first..last), halved along the longest side of their centres' box.
void DiscTree::build(std::uint32_t first, std::uint32_t last) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Box3 box, centers;
  for (std::uint32_t i = first; i < last; ++i) {
    const Disc& disc = discs_[order_[i]];
    const Vec3 reach{disc.radius, disc.radius, disc.radius};
    box.grow(disc.center - reach);
    box.grow(disc.center + reach);
    centers.grow(disc.center);
  }
  nodes_[self].box = box;
  if (last - first <= kLeaf) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return;
  }
  const int axis = centers.longest_axis();
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float of_a = discs_[a].center[axis], of_b = discs_[b].center[axis];
                     return of_a != of_b ? of_a < of_b : a < b;
                   });
  build(first, middle);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(middle, last);
}

}  // namespace glowworm
