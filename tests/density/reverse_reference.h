#pragma once
#include "kernels/reverse.h"

namespace glowworm {

namespace {

/// Adds one photon to all points of a leaf.
void add_to_leaf(const ReverseNode& leaf, const float* points, float* sums, const ReversePhotons& photons,
                 std::uint32_t j, ReverseCounts& counts) {
  const std::size_t n = leaf.count();
  for (std::size_t i = 0; i < n; ++i) {
    ++counts.tested;
    const float x = points[i] - photons.x[j], y = points[n + i] - photons.y[j], z = points[2 * n + i] - photons.z[j];
    const float u = (x * x + (y * y + z * z)) * photons.inverse_radius_squared[j];
    if (!(u < 1)) continue;
    const float cosine = points[3 * n + i] * photons.normal_x[j] + points[4 * n + i] * photons.normal_y[j] +
                         points[5 * n + i] * photons.normal_z[j];
    if (!(cosine > photons.min_normal_cosine)) continue;
    ++counts.operations;
    const float weight = kernel_profile(photons.kernel, u);
    sums[i] += weight * photons.r[j];
    sums[n + i] += weight * photons.g[j];
    sums[2 * n + i] += weight * photons.b[j];
  }
}

/// Adds one photon to all points of the part.
void add_to_part(const ReverseSubtreeView& part, const ReversePhotons& photons, std::uint32_t j,
                 ReverseCounts& counts) {
  std::vector<std::uint32_t> pending{part.root};
  while (!pending.empty()) {
    const std::uint32_t at = pending.back();
    const ReverseNode& node = part.nodes[at];
    pending.pop_back();
    if (node.is_leaf()) {
      const std::size_t first = node.first() - part.first_point;
      add_to_leaf(node, part.points + first * kReverseFields, part.sums + first * kReverseSums, photons, j, counts);
    } else {
      pending.push_back(node.right());
      pending.push_back(at + 1);
    }
  }
}

}  // namespace

/// reverse_sum() in plain C++, for tests: every photon of the clusters against every point of the part. Counts `tested`
/// and `operations`.
inline void reverse_sum_reference(const ReverseSubtreeView& part, const ReversePhotons& photons,
                                  std::span<const ReverseCluster> clusters, ReverseCounts& counts) {
  for (const ReverseCluster& cluster : clusters) {
    for (std::uint32_t j = cluster.first; j < cluster.first + cluster.count; ++j) add_to_part(part, photons, j, counts);
  }
}

}  // namespace glowworm
