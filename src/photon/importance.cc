#include "photon/importance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/archive.h"

namespace glowworm {

namespace {

/// Cells along the longest side of the box that holds nine tenths of the points on each axis.
constexpr float kCellsAcross = 32;
/// Share of the mean importance at which a place counts in full.
constexpr double kFullShare = 0.1;

/// Extent along one axis without the outermost twentieths, so that a few points on far hills do not enlarge all cells.
float inner_extent(std::span<const Vec3> positions, int axis) {
  std::vector<float> values;
  for (const Vec3& p : positions) values.push_back(p[axis]);
  const auto rank = static_cast<std::ptrdiff_t>(values.size() / 20);
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  const float low = values[static_cast<std::size_t>(rank)];
  std::nth_element(values.begin(), values.end() - 1 - rank, values.end());
  return values[values.size() - 1 - static_cast<std::size_t>(rank)] - low;
}

std::uint64_t facing(Vec3 n) {
  const Vec3 a{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  return static_cast<std::uint64_t>(2 * axis + (n[axis] < 0 ? 1 : 0));
}

}  // namespace

ImportanceGrid::ImportanceGrid(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::span<const float> weights) {
  if (positions.empty()) return;
  float extent = 0;
  for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, inner_extent(positions, axis));
  cell_ = (extent > 0 ? extent : 1.0f) / kCellsAcross;
  // The sum of a cell and its neighbours: kernels overlap cells, and the sample of points has gaps.
  std::vector<std::uint64_t> own;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    own.push_back(key(positions[i], normals[i], 0, 0, 0));
    if (!(weights[i] > 0)) continue;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) cells_[key(positions[i], normals[i], dx, dy, dz)] += weights[i];
  }
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    sum += static_cast<double>(weights[i]) * cells_[own[i]];
    total += weights[i];
  }
  const double full = total > 0 ? kFullShare * sum / total : 1;
  for (auto& [place, value] : cells_) value = static_cast<float>(std::min(1.0, value / full));
}

float ImportanceGrid::value(Vec3 position, Vec3 normal) const {
  const auto found = cells_.find(key(position, normal, 0, 0, 0));
  return found == cells_.end() ? 0.0f : found->second;
}

template <typename Archive>
void ImportanceGrid::transfer(Archive& archive) {
  std::vector<std::uint64_t> places;
  std::vector<float> values;
  for (const auto& [place, value] : cells_) {
    places.push_back(place);
    values.push_back(value);
  }
  transfer_all(archive, cell_, places, values);
  if constexpr (Archive::kReads) {
    require(cell_ > 0 && std::isfinite(cell_) && places.size() == values.size());
    cells_.clear();
    for (std::size_t i = 0; i < places.size(); ++i) {
      require(values[i] >= 0 && values[i] <= 1);
      cells_[places[i]] = values[i];
    }
  }
}
template void ImportanceGrid::transfer(ArchiveWriter& archive);
template void ImportanceGrid::transfer(ArchiveReader& archive);

std::uint64_t ImportanceGrid::key(Vec3 position, Vec3 normal, int dx, int dy, int dz) const {
  // 20 bits an axis: cells a million apart share a key, which makes guiding slightly less efficient but stays correct.
  const auto part = [&](float x, int d) {
    const double cell = std::floor(static_cast<double>(x) / cell_) + d;
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::clamp(cell, -1e15, 1e15))) & 0xfffffu;
  };
  return (facing(normal) << 60) | (part(position.x, dx) << 40) | (part(position.y, dy) << 20) | part(position.z, dz);
}

}  // namespace glowworm
