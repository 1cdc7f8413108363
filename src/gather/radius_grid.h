// A coarse grid of photon radii, which tells how far density estimation blurs around a point.
#pragma once
#include <span>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// Mean photon radius in the cells of a uniform grid. If a final gather ray is shorter than the radius at its end, the
/// estimate there would blur across the corner in which the gather point lies; such rays make a secondary gather.
class RadiusGrid {
 public:
  RadiusGrid() = default;
  /// @param positions of the photons, @param radii one for each photon; metres
  RadiusGrid(std::span<const Vec3> positions, std::span<const float> radii);

  /// The mean radius in the cell of p, metres. A cell without photons has the radius of photons that reach it, or 0.
  float radius(Vec3 p) const;
  /// Upper bound of radius(), metres.
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
