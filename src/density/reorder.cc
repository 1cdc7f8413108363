#include "density/reorder.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/hilbert.h"
#include "core/parallel.h"
#include "core/radix_sort.h"

namespace glowworm {

namespace {

constexpr std::size_t kReorderPiece = std::size_t{1} << 14;

/// Points by Morton code at the finest level: each level of the octree is three bits.
using CodedPoint = KeyedIndex<std::uint64_t>;

/// A cell of the octree: a run of the points, and the orientation of the curve in it.
struct Cell {
  std::size_t first, last;
  int level;  // halvings so far
  unsigned orientation;
};

/// Divides the points of cells in Hilbert child order.
class OctreeOrder {
 public:
  OctreeOrder(std::vector<CodedPoint> points, std::uint32_t threshold, int depth)
      : points_(std::move(points)), scratch_(points_.size()), threshold_(std::max(threshold, 1u)), depth_(depth) {}

  std::vector<CodedPoint> run() {
    // Large cells one after another, each on all threads; then small ones in parallel.
    std::vector<Cell> large{{0, points_.size(), 0, 0}}, small;
    while (!large.empty()) {
      const Cell cell = large.back();
      large.pop_back();
      if (cell.last - cell.first <= kReorderPiece || cell.level >= depth_) {
        small.push_back(cell);
        continue;
      }
      const std::array<std::size_t, 9> ends = divide(cell);
      for (unsigned place = 8; place-- > 0;) large.push_back(child(cell, ends, place));
    }
    parallel_for_each(small.size(), 4, [&](std::size_t i) { order_within(small[i]); });
    return std::move(points_);
  }

 private:
  unsigned place_of(const CodedPoint& p, const Cell& cell) const {
    return kHilbert.place[cell.orientation][p.key >> (3 * (kHilbertMaxBits - 1 - cell.level)) & 7] & 7;
  }

  Cell child(const Cell& cell, const std::array<std::size_t, 9>& ends, unsigned place) const {
    const unsigned octant = kHilbert.octant[cell.orientation][place];
    return {ends[place], ends[place + 1], cell.level + 1, unsigned{kHilbert.place[cell.orientation][octant]} >> 3};
  }

  void order_within(const Cell& cell) {
    if (cell.last - cell.first <= threshold_ || cell.level >= depth_) return;
    const std::array<std::size_t, 9> ends = divide(cell);
    for (unsigned place = 0; place < 8; ++place) order_within(child(cell, ends, place));
  }

  /// Sorts the points of a cell by octant; returns where the points of each child begin, and the end.
  std::array<std::size_t, 9> divide(const Cell& cell) {
    const std::size_t pieces = (cell.last - cell.first + kReorderPiece - 1) / kReorderPiece;
    std::vector<std::array<std::size_t, 8>> next(pieces);
    parallel_for(cell.first, cell.last, kReorderPiece, [&](std::size_t first, std::size_t last) {
      auto& count = next[(first - cell.first) / kReorderPiece];
      for (std::size_t i = first; i < last; ++i) ++count[place_of(points_[i], cell)];
    });
    std::array<std::size_t, 9> ends{};
    std::size_t sum = cell.first;
    for (unsigned place = 0; place < 8; ++place) {
      ends[place] = sum;
      for (auto& counts : next) {
        const std::size_t count = counts[place];
        counts[place] = sum;
        sum += count;
      }
    }
    ends[8] = sum;
    parallel_for(cell.first, cell.last, kReorderPiece, [&](std::size_t first, std::size_t last) {
      auto& to = next[(first - cell.first) / kReorderPiece];
      for (std::size_t i = first; i < last; ++i) scratch_[to[place_of(points_[i], cell)]++] = points_[i];
    });
    parallel_for(cell.first, cell.last, kReorderPiece, [&](std::size_t first, std::size_t last) {
      std::copy(scratch_.begin() + static_cast<std::ptrdiff_t>(first),
                scratch_.begin() + static_cast<std::ptrdiff_t>(last),
                points_.begin() + static_cast<std::ptrdiff_t>(first));
    });
    return ends;
  }

  std::vector<CodedPoint> points_, scratch_;
  std::uint32_t threshold_;
  int depth_;
};

template <typename Key>
std::vector<std::uint32_t> indices_of(const std::vector<KeyedIndex<Key>>& sorted) {
  std::vector<std::uint32_t> order(sorted.size());
  parallel_for_each(sorted.size(), kReorderPiece, [&](std::size_t i) { order[i] = sorted[i].index; });
  return order;
}

/// Pairs (key(point), index), made on all threads.
template <typename Key, typename Function>
std::vector<KeyedIndex<Key>> keyed(std::span<const Vec3> points, const Function& key) {
  std::vector<KeyedIndex<Key>> pairs(points.size());
  parallel_for_each(points.size(), kReorderPiece, [&](std::size_t i) {
    pairs[i] = {static_cast<Key>(key(points[i])), static_cast<std::uint32_t>(i)};
  });
  return pairs;
}

template <typename Key>
std::vector<std::uint32_t> radix_order(std::span<const Vec3> points, const CubeGrid& grid, int depth) {
  auto pairs = keyed<Key>(points, [&](Vec3 p) { return hilbert_key_of_morton(grid.morton(p), depth); });
  radix_sort(pairs, 3 * depth);
  return indices_of(pairs);
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
    auto coded = keyed<std::uint64_t>(points, [&](Vec3 p) { return grid.morton(p); });
    return indices_of(OctreeOrder(std::move(coded), settings.threshold, depth).run());
  }
  if (settings.method == ReorderMethod::radix) {
    const int depth =
        automatic ? automatic_depth(points.size(), photons) : std::clamp(settings.depth, 0, kHilbertMaxBits);
    const CubeGrid grid(bounds, depth);
    return depth <= 10 ? radix_order<std::uint32_t>(points, grid, depth)
                       : radix_order<std::uint64_t>(points, grid, depth);
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
