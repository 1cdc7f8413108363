#pragma once
#include "kernels/blocked.h"

namespace glowworm {

/// blocked_sum() in plain C++, every photon of the blocks against every point in single precision: the reference for
/// tests of the vector code. Does not count steps.
inline void blocked_sum_reference(const BlockTree& tree, std::size_t blocks, const QueryRun& run,
                                  BlockedCounts& counts) {
  for (std::size_t i = 0; i < run.count; ++i) {
    float sum[3] = {0, 0, 0};
    for (std::size_t block = 0; block < blocks; ++block)
      for (int lane = 0; lane < kBlockWidth; ++lane) {
        const PhotonBlock& p = tree.blocks[block];
        const float dx = run.position[0][i] - p.x[lane], dy = run.position[1][i] - p.y[lane],
                    dz = run.position[2][i] - p.z[lane];
        const float t = (dx * dx + dy * dy + dz * dz) * p.inverse_radius_squared[lane];
        const float cosine =
            run.normal[0][i] * p.nx[lane] + run.normal[1][i] * p.ny[lane] + run.normal[2][i] * p.nz[lane];
        ++counts.tested;
        if (!(t < 1) || !(cosine > tree.min_normal_cosine)) continue;
        ++counts.evaluated;
        const float w = kernel_profile(tree.kernel, t);
        sum[0] += w * p.r[lane];
        sum[1] += w * p.g[lane];
        sum[2] += w * p.b[lane];
      }
    for (int c = 0; c < 3; ++c) run.sum[c][i] = sum[c];
  }
}

}  // namespace glowworm
