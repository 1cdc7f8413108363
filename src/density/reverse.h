// Reverse photon mapping: [HHS05].
#pragma once
#include <cstdint>
#include <memory>

#include "density/engine.h"
#include "density/reverse_tree.h"

namespace glowworm {

struct ReverseOptions {
  /// Query points in a leaf at most, 1 to 255: T_m of [HHS05]; 0: from the number of points per photon. The results are
  /// the same, bit for bit.
  std::uint32_t leaf_size = 0;
  /// Photons that search together at most, 1 to 64; 1: each alone. The results are the same, bit for bit.
  std::uint32_t cluster_size = ReverseCluster::kMaxCount;
};

/// T_m for so many query points and photons: if points are dense beside photons, even a large leaf is a small part of a
/// photon's kernel, and saves tests of photons against boxes.
std::uint32_t reverse_leaf_size(std::size_t points, std::size_t photons);

/// make_reverse_engine() with other options.
std::unique_ptr<DensityEngine> make_reverse_engine(const ReverseOptions& options);

}  // namespace glowworm
