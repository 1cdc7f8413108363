// Reverse photon mapping: [HHS05].
#pragma once
#include <cstdint>
#include <memory>

#include "density/engine.h"
#include "density/reverse_tree.h"

namespace glowworm {

struct ReverseOptions {
  /// Query points in a leaf at most, 1 to 255: T_m of [HHS05].
  std::uint32_t leaf_size = ReverseTree::kLeafSize;
  /// Photons that are searched for at once at most, 1 to 64; 1: each on its own. The answers are the same bits.
  std::uint32_t cluster_size = ReverseCluster::kMaxCount;
};

/// make_reverse_engine() with other options.
std::unique_ptr<DensityEngine> make_reverse_engine(const ReverseOptions& options);

}  // namespace glowworm
