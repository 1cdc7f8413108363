// Where photons are useful: a grid of the places that the image depends on.
#pragma once
#include <cstdint>
#include <span>
#include <unordered_map>

#include "core/vec.h"

namespace glowworm {

/// Importance of places to the image, from a sample of its query points: "importons" in the cells of a grid, separated
/// by the main axis of their normal (so the two sides of a wall differ). Peter and Pietrek, "Importance Driven
/// Construction of Photon Maps", EGWR 1998; Keller and Wald, "Efficient Importance Sampling Techniques for the Photon
/// Map", VMV 2000.
class ImportanceGrid {
 public:
  ImportanceGrid() = default;  ///< zero everywhere
  /// @param positions metres; @param normals unit, on the visible side; @param weights importance of each point, not
  /// negative. All of one length.
  ImportanceGrid(std::span<const Vec3> positions, std::span<const Vec3> normals, std::span<const float> weights);

  bool empty() const { return cells_.empty(); }
  /// From 0 (no query point is near) to 1, which is reached at a tenth of the mean importance: beyond it, more photons
  /// do not help more than elsewhere.
  float value(Vec3 position, Vec3 normal) const;
  /// Side of a cell, metres.
  float cell() const { return cell_; }

  /// Throws InvalidArchive (core/archive.h) if no grid can hold what is read.
  template <typename Archive>
  void transfer(Archive& archive);

 private:
  std::uint64_t key(Vec3 position, Vec3 normal, int dx, int dy, int dz) const;

  std::unordered_map<std::uint64_t, float> cells_;
  float cell_ = 1;
};

}  // namespace glowworm
