#include "density/reorder.h"

#include <algorithm>
#include <numeric>

#include "core/hilbert.h"
#include "core/parallel.h"
#include "core/radix_sort.h"

namespace glowworm {

namespace {

constexpr std::size_t kReorderPiece = std::size_t{1} << 14;

/// Makes the order along the curve that of an octree in Hilbert child order, which does not divide cells of at most
/// `threshold` points, nor those of the last level: their points keep the order that they had before.
/// @param points of a cell of the level, by their keys of all levels
void restore_order_in_cells(std::span<KeyedIndex<std::uint64_t>> points, int level, int last_level,
                            std::uint32_t threshold) {
  if (points.size() <= threshold || level >= last_level) {
    std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return;
  }
  const int shift = 3 * (kHilbertMaxBits - 1 - level);
  const auto begin_of = [&](std::size_t child) {
    return std::partition_point(points.begin(), points.end(),
                                [&](const auto& p) { return (p.key >> shift & 7) < child; });
  };
  parallel_for_each(8, points.size() > kReorderPiece ? 1 : 8, [&](std::size_t child) {
    restore_order_in_cells({begin_of(child), begin_of(child + 1)}, level + 1, last_level, threshold);
  });
}

template <typename Key>
std::vector<std::uint32_t> indices_of(const std::vector<KeyedIndex<Key>>& sorted) {
  std::vector<std::uint32_t> order(sorted.size());
  parallel_for_each(sorted.size(), kReorderPiece, [&](std::size_t i) { order[i] = sorted[i].index; });
  return order;
}

/// Points by their places on the curve, and their indices.
template <typename Key>
std::vector<KeyedIndex<Key>> sorted_along_curve(std::span<const Vec3> points, const CubeGrid& grid, int depth) {
  std::vector<KeyedIndex<Key>> pairs(points.size());
  parallel_for_each(points.size(), kReorderPiece, [&](std::size_t i) {
    pairs[i] = {static_cast<Key>(hilbert_key_of_morton(grid.morton(points[i]), depth)), static_cast<std::uint32_t>(i)};
  });
  radix_sort(pairs, 3 * depth);
  return pairs;
}

}  // namespace

int automatic_depth(std::size_t points, std::size_t photons) {
  // Points lie on surfaces: the walls of a closed box pass through 6 * 4^b cells of a grid of b bits, and its contents
  // add some; 8 * 4^b is an estimate. Cells of 8 points fill a packet. Cells of one or two photons are small beside a
  // radius that holds dozens, so smaller cells save nothing.
  const double cells = std::min(static_cast<double>(points) / 8, static_cast<double>(photons));
  int depth = 0;
  while (depth < 10 && 8.0 * static_cast<double>(std::uint64_t{1} << (2 * depth)) < cells) ++depth;
  return depth;
}

std::vector<std::uint32_t> hilbert_order(std::span<const Vec3> points, const Box3& bounds, std::size_t photons,
                                         const ReorderSettings& settings) {
  const bool automatic = settings.depth == kAutomaticDepth;
  if (settings.method == ReorderMethod::octree) {
    const int depth = automatic ? kHilbertMaxBits : std::clamp(settings.depth, 0, kHilbertMaxBits);
    const CubeGrid grid(bounds, kHilbertMaxBits);
    auto pairs = sorted_along_curve<std::uint64_t>(points, grid, kHilbertMaxBits);
    restore_order_in_cells(pairs, 0, depth, std::max(settings.threshold, 1u));
    return indices_of(pairs);
  }
  if (settings.method == ReorderMethod::radix) {
    const int depth =
        automatic ? automatic_depth(points.size(), photons) : std::clamp(settings.depth, 0, kHilbertMaxBits);
    const CubeGrid grid(bounds, depth);
    return depth <= 10 ? indices_of(sorted_along_curve<std::uint32_t>(points, grid, depth))
                       : indices_of(sorted_along_curve<std::uint64_t>(points, grid, depth));
  }
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

Box3 bounds_of(std::span<const Vec3> points) {
  std::vector<Box3> boxes((points.size() + kReorderPiece - 1) / kReorderPiece);
  parallel_for(0, points.size(), kReorderPiece, [&](std::size_t first, std::size_t last) {
    Box3 box;
    for (std::size_t i = first; i < last; ++i)
      if (is_finite(points[i])) box.grow(points[i]);
    boxes[first / kReorderPiece] = box;
  });
  Box3 bounds;
  for (const Box3& box : boxes)
    if (!box.empty()) bounds.grow(box);
  return bounds;
}

}  // namespace glowworm
