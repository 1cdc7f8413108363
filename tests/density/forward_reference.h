#pragma once
#include <bit>
#include <cmath>

#include "kernels/forward.h"

namespace glowworm {

namespace {

/// Traversal by one query point.
class Walk {
 public:
  Walk(const ForwardTree& tree, const ForwardQueries& q, std::size_t i, ForwardCounts& counts)
      : tree_(tree),
        position_{q.x[i], q.y[i], q.z[i]},
        normal_{q.normal_x[i], q.normal_y[i], q.normal_z[i]},
        counts_(counts) {}

  void subtree(std::uint32_t node) {
    const ForwardNode at = tree_.nodes[node];
    const std::uint32_t axis = at.split & ForwardNode::kAxisMask;
    if (axis == ForwardNode::kLeaf) {
      shade(node);
      return;
    }
    const float fixed = tree_.fixed_reach;
    const ForwardReach reach = tree_.reach ? tree_.reach[node] : ForwardReach{fixed, fixed, fixed};
    const float distance = position_[axis] - std::bit_cast<float>(at.split);
    const bool left = distance < reach.left;
    const bool right = distance > -reach.right;
    if (std::abs(distance) < reach.own) shade(node);
    if (left) subtree(node + 1);
    if (right && at.right != 0) subtree(at.right);
  }

  float sum[3] = {0, 0, 0};

 private:
  void shade(std::uint32_t node) {
    const ForwardHot& hot = tree_.hot[node];
    const ForwardCold& cold = tree_.cold[node];
    ++counts_.shadings;
    ++counts_.active;
    const float x = position_[0] - hot.x, y = position_[1] - hot.y, z = position_[2] - hot.z;
    const float u = (x * x + y * y + z * z) * hot.inverse_radius_squared;
    const float cosine = normal_[0] * cold.normal[0] + normal_[1] * cold.normal[1] + normal_[2] * cold.normal[2];
    if (!(u < 1) || !(cosine > tree_.min_normal_cosine)) return;
    ++counts_.operations;
    for (int c = 0; c < 3; ++c) sum[c] += kernel_profile(tree_.kernel, u) * cold.flux[c];
  }

  const ForwardTree& tree_;
  float position_[3], normal_[3];
  ForwardCounts& counts_;
};

}  // namespace

/// forward_gather() in plain C++, one query point at a time, for tests.
inline void forward_gather_reference(const ForwardTree& tree, const ForwardQueries& queries, float* r, float* g,
                                     float* b, ForwardCounts& counts) {
  if (tree.count == 0) return;
  for (std::size_t i = 0; i < queries.count; ++i) {
    Walk walk(tree, queries, i, counts);
    walk.subtree(0);
    r[i] += walk.sum[0];
    g[i] += walk.sum[1];
    b[i] += walk.sum[2];
  }
}

}  // namespace glowworm
