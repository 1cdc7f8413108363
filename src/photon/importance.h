// Where photons are of use: a grid of the places that the image asks for.
#pragma once
#include <cstdint>
#include <span>
#include <unordered_map>

#include "core/vec.h"

namespace glowworm {

/// How much the image asks of places, from a sample of its query points: "importons" gathered in cells of a grid, apart
/// by the axis that the surface faces most (so that a wall's two sides are told apart). Peter and Pietrek, "Importance
/// Driven Construction of Photon Maps", EGWR 1998; Keller and Wald, "Efficient Importance Sampling Techniques for the
/// Photon Map", VMV 2000.
class ImportanceGrid {
 public:
  ImportanceGrid() = default;  ///< asks for nothing
  /// @param positions metres; @param normals unit, on the side that is looked at; @param weights none negative: how
  /// much
  ///        the image depends on each point. All of one length.
  ImportanceGrid(std::span<const Vec3> positions, std::span<const Vec3> normals, std::span<const float> weights);

  bool empty() const { return cells_.empty(); }
  /// From 0 (nothing near is ever asked about) to 1, which it reaches at a tenth of what the image asks of its places
  /// in the mean: beyond, more photons would serve no better than elsewhere.
  float value(Vec3 position, Vec3 normal) const;
  /// Side of a cell, metres.
  float cell() const { return cell_; }

 private:
  std::uint64_t key(Vec3 position, Vec3 normal, int dx, int dy, int dz) const;

  std::unordered_map<std::uint64_t, float> cells_;
  float cell_ = 1;
};

}  // namespace glowworm
