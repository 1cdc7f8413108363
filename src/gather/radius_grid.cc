#include "gather/radius_grid.h"

#include <algorithm>

namespace glowworm {

RadiusGrid::RadiusGrid(std::span<const Vec3> positions, std::span<const float> radii) {
  if (positions.empty()) return;
  for (const Vec3& p : positions) bounds_.grow(p);
  const Vec3 side = bounds_.diagonal();
  const float longest = side[bounds_.longest_axis()];
  // 64 cells along the longest side.
  const float cell_side = longest > 0 ? longest / 64 : 1.0f;
  for (int axis = 0; axis < 3; ++axis) size_[axis] = static_cast<int>(side[axis] / cell_side) + 1;
  cells_per_metre_ = Vec3{1, 1, 1} / cell_side;
  const std::size_t cells = static_cast<std::size_t>(size_[0]) * size_[1] * size_[2];
  std::vector<double> sum(cells, 0.0);
  std::vector<std::uint32_t> count(cells, 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t c = cell(positions[i]);
    sum[c] += radii[i];
    ++count[c];
  }
  mean_.resize(cells);
  for (std::size_t c = 0; c < cells; ++c) {
    mean_[c] = count[c] ? static_cast<float>(sum[c] / count[c]) : 0.0f;
    max_radius_ = std::max(max_radius_, mean_[c]);
  }
  fill_empty_cells(cell_side);
}

/// Gives a cell without photons the radius of photons that reach it from other cells, by distance along the axes.
void RadiusGrid::fill_empty_cells(float cell_side) {
  std::vector<float> left = mean_;  // the part of a cell's radius that extends beyond it
  const std::ptrdiff_t strides[3] = {1, size_[0], static_cast<std::ptrdiff_t>(size_[0]) * size_[1]};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool forward : {true, false}) {
      const auto cells = static_cast<std::ptrdiff_t>(mean_.size());
      for (std::ptrdiff_t i = 0; i < cells; ++i) {
        const std::ptrdiff_t c = forward ? i : cells - 1 - i;
        const std::ptrdiff_t along = c / strides[axis] % size_[axis];
        if (along == (forward ? 0 : size_[axis] - 1)) continue;
        const std::ptrdiff_t from = forward ? c - strides[axis] : c + strides[axis];
        const float reaches = left[from] - cell_side;
        if (reaches <= 0 || reaches <= left[c] || (mean_[c] > 0 && left[c] == mean_[c])) continue;
        left[c] = reaches;
        mean_[c] = mean_[from];
      }
    }
}

std::size_t RadiusGrid::cell(Vec3 p) const {
  const Vec3 scaled = (p - bounds_.min) * cells_per_metre_;
  const int x = std::clamp(static_cast<int>(scaled.x), 0, size_[0] - 1);
  const int y = std::clamp(static_cast<int>(scaled.y), 0, size_[1] - 1);
  const int z = std::clamp(static_cast<int>(scaled.z), 0, size_[2] - 1);
  return (static_cast<std::size_t>(z) * size_[1] + y) * size_[0] + x;
}

float RadiusGrid::radius(Vec3 p) const { return mean_.empty() ? 0.0f : mean_[cell(p)]; }

}  // namespace glowworm
