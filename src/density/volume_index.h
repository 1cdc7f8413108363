// Volume photons, or pieces of beams, sorted into blocks of eight, with a tree of boxes for each medium.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/rgb.h"
#include "density/volume_radii.h"
#include "kernels/volume.h"
#include "points/volume_photons.h"

namespace glowworm {

/// Photons or pieces in blocks. What no segment can see (without flux or radius, or not finite) is left out.
class VolumeIndex {
 public:
  using Key = std::pair<std::uint32_t, std::uint32_t>;  ///< medium and part
  /// What one part of a medium holds.
  struct Medium {
    Key key;          ///< VolumePhotons::medium, and which of BeamPieces::parts
    Box3 bounds;      ///< around the photons, grown by their radii
    float reach = 0;  ///< mean over blocks of the largest radius and half of the longest side, metres
    std::size_t first_block = 0;
    std::vector<std::size_t> level_first;  ///< where each level begins in the nodes
  };

  /// Builds on all threads; the index does not depend on their number. @param flux of the photons, W
  /// @param scale factor on the radii
  VolumeIndex(const VolumePhotons& photons, std::span<const RGB> flux, const PhotonKernels& kernels, float scale);
  VolumeIndex(const VolumeBeams& beams, std::span<const RGB> flux, const BeamPieces& pieces, float scale);
  VolumeIndex() = default;

  /// Parts of media, in ascending order of indices and parts.
  std::span<const Medium> media() const { return media_; }
  /// How many parts the photons of a medium are divided into.
  std::uint32_t parts(std::uint32_t medium) const { return medium < parts_.size() ? parts_[medium] : 1; }
  bool empty() const { return media_.empty(); }
  bool has_beams() const { return beams_.size() > 0; }
  /// The view for the kernels; valid until this object is moved or destroyed.
  VolumeTree tree(const Medium& medium) const;

  /// Most bytes of an index of that many photons, or of beams of that many pieces, without its table of media.
  static std::uint64_t photon_bytes(std::size_t photons);
  static std::uint64_t piece_bytes(std::size_t pieces);

 private:
  template <class Items, class Block>
  void build(const Items& items, LargeArray<Block>& blocks);
  template <class Block>
  void build_nodes(Medium& medium, std::span<const Block> blocks);

  LargeArray<VolumePhotonBlock> photons_;
  LargeArray<BeamBlock> beams_;
  std::vector<VolumeNode> nodes_;
  std::vector<Medium> media_;
  std::vector<std::uint32_t> parts_;
};

}  // namespace glowworm
