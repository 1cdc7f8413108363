// The photons of the blocked engine: sorted into blocks of eight, with a tree of boxes over them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_array.h"
#include "density/engine.h"
#include "kernels/blocked.h"

namespace glowworm {

/// Photons in blocks. Photons that no kernel can contain (radius 0, or not finite) are left out.
class BlockedIndex {
 public:
  /// Builds on all threads; the index does not depend on their number. @param fluxes of the photons, W
  /// @param policy fixed or per_photon @param photon_of_place receives the photon in each place; null: not wanted
  BlockedIndex(const PhotonBatch& photons, std::span<const RGB> fluxes, const RadiusPolicy& policy,
               std::vector<std::uint32_t>* photon_of_place = nullptr);
  BlockedIndex() = default;

  /// The view for the kernels; valid until this object is moved or destroyed.
  BlockTree tree() const;
  /// Number of photons in the blocks.
  std::size_t size() const { return size_; }
  /// By place (8 times the block plus the lane): the direction of the photon, unit, back along its path.
  std::span<const Vec3> directions() const { return directions_.span(); }
  /// Bytes that an index of so many photons holds, without cuts.
  static std::uint64_t bytes(std::size_t photons);
  /// Bytes of the cuts.
  std::uint64_t cut_bytes() const { return cuts_.size() * sizeof(BlockCuts) + cut_of_block_.size() * sizeof(cuts_[0]); }

 private:
  void build_nodes();
  void add_cuts(std::span<const PhotonCuts> cuts, std::span<const std::uint32_t> places);

  LargeArray<PhotonBlock> blocks_;
  std::vector<BlockNode> nodes_;          // level 0 first
  std::vector<std::size_t> level_first_;  // where each level begins in nodes_
  LargeArray<Vec3> directions_;
  LargeArray<std::uint32_t> cut_of_block_;  // BlockTree::cut_of_block; empty without cuts
  std::vector<BlockCuts> cuts_;
  std::size_t size_ = 0;
  KernelShape kernel_ = KernelShape::epanechnikov;
  float min_normal_cosine_ = 0;
};

}  // namespace glowworm
