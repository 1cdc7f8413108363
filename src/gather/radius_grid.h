// A coarse field of photon radii: how far density estimation blurs around a place.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// Mean photon radius by cells of a uniform grid. Where a final gather ray is shorter than the radius at its end, the
/// estimate there would blur over the corner that the gather point lies in; such rays gather once more.
class RadiusGrid {
 public:
  RadiusGrid() = default;
  /// @param positions of the photons, @param radii one each; metres
  RadiusGrid(std::span<const Vec3> positions, std::span<const float> radii);

  /// The mean radius in the cell of p; where it holds no photon, that of a cell whose photons reach it, or 0. Metres.
  float radius(Vec3 p) const;
  /// No radius() is above this. Metres.
  float max_radius() const { return max_radius_; }

 private:
  void fill_empty_cells(float cell_side);
  std::size_t cell(Vec3 p) const;
  Box3 bounds_;
  Vec3 cells_per_metre_;
  int size_[3] = {0, 0, 0};
  std::vector<float> mean_;
  float max_radius_ = 0;
};

}  // namespace glowworm
