// The photons of the blocked engine: sorted into blocks of eight, with a tree of boxes over them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_array.h"
#include "density/engine.h"
#include "kernels/blocked.h"

namespace glowworm {

/// Photons in blocks. Photons that can be in no kernel (radius 0, or not finite themselves) are left out.
class BlockedIndex {
 public:
  /// Builds on all threads; the same index for any number of them. @param policy fixed or per_photon
  BlockedIndex(const PhotonBatch& photons, const RadiusPolicy& policy);
  BlockedIndex() = default;

  /// The view that the kernels work on; valid as long as this is neither moved nor destroyed.
  BlockTree tree() const;
  /// Photons in the blocks.
  std::size_t size() const { return size_; }
  /// By place (8 times the block plus the lane): the direction of the photon there, unit, back along its way.
  std::span<const Vec3> directions() const { return directions_.span(); }
  /// Bytes held for so many photons.
  static std::uint64_t bytes(std::size_t photons);

 private:
  void build_nodes();

  LargeArray<PhotonBlock> blocks_;
  std::vector<BlockNode> nodes_;          // level 0 first
  std::vector<std::size_t> level_first_;  // where each level begins in nodes_
  LargeArray<Vec3> directions_;
  std::size_t size_ = 0;
  KernelShape kernel_ = KernelShape::epanechnikov;
  float min_normal_cosine_ = 0;
};

}  // namespace glowworm
