#include "density/blocked_queries.h"

#include <algorithm>
#include <cmath>

#include "core/hilbert.h"
#include "core/parallel.h"
#include "density/reorder.h"

namespace glowworm {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;
// Points of a bucket that are aimed at: their records stay in the second-level cache while they are sorted.
constexpr std::size_t kPointsWanted = 1024;
constexpr std::size_t kMostCells = 4096;
// Rounds of dividing a bucket that is too large, before its points are taken as they are.
constexpr int kMostRounds = 8;
constexpr std::uint16_t kNoCell = 0xffff;

/// A grid of equal cubes over a box, of no more cells than asked for.
class Cells {
 public:
  Cells(const Box3& box, std::size_t most_cells) {
    if (box.empty()) return;
    origin_ = box.min;
    const Vec3 d = box.diagonal();
    const float longest = std::max(d.x, std::max(d.y, d.z));
    if (!(longest > 0) || !std::isfinite(longest) || most_cells < 2) return;
    // The largest number along the longest side with which all cells are few enough.
    const auto along = [&](float side, int n) {
      return std::min(n, 1 + static_cast<int>(side / longest * static_cast<float>(n)));
    };
    const auto cells = [&](int n) {
      return static_cast<std::size_t>(along(d.x, n)) * static_cast<std::size_t>(along(d.y, n)) *
             static_cast<std::size_t>(along(d.z, n));
    };
    int low = 1, high = static_cast<int>(most_cells);
    while (low < high) {
      const int middle = (low + high + 1) / 2;
      if (cells(middle) <= most_cells)
        low = middle;
      else
        high = middle - 1;
    }
    for (int axis = 0; axis < 3; ++axis) last_[axis] = static_cast<float>(along(d[axis], low) - 1);
    const float scale = static_cast<float>(low) / longest;
    scale_ = std::isfinite(scale) ? scale : 0;
    count_ = cells(low);
    stride_y_ = static_cast<std::uint32_t>(last_[0]) + 1;
    stride_z_ = stride_y_ * (static_cast<std::uint32_t>(last_[1]) + 1);
  }

  std::size_t count() const { return count_; }
  /// @param p finite
  std::uint32_t cell(Vec3 p) const { return along(p.x, 0) + stride_y_ * along(p.y, 1) + stride_z_ * along(p.z, 2); }

 private:
  std::uint32_t along(float p, int axis) const {
    return static_cast<std::uint32_t>(
        static_cast<std::int32_t>(std::clamp((p - origin_[axis]) * scale_, 0.0f, last_[axis])));
  }
  Vec3 origin_;
  float scale_ = 0;
  float last_[3] = {0, 0, 0};
  std::uint32_t stride_y_ = 1, stride_z_ = 1;
  std::size_t count_ = 1;
};

/// Counts cells piece by piece, and turns the counts into the places where each piece writes the points of each cell.
class CellCounts {
 public:
  CellCounts(std::size_t items, std::size_t cells)
      : pieces_((items + kPiece - 1) / kPiece), cells_(cells), places_(pieces_ * cells) {}
  std::uint32_t* piece(std::size_t i) { return &places_[i * cells_]; }
  /// Sums up in order of (cell, piece), from `first` on; appends a bucket for each cell that is not empty.
  void sum(std::uint32_t first, std::vector<QueryBuckets::Bucket>& buckets) {
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      const std::uint32_t begin = first;
      for (std::size_t piece = 0; piece < pieces_; ++piece) {
        std::uint32_t& place = places_[piece * cells_ + cell];
        const std::uint32_t count = place;
        place = first;
        first += count;
      }
      if (first > begin) buckets.push_back({begin, first});
    }
  }

 private:
  std::size_t pieces_, cells_;
  std::vector<std::uint32_t> places_;
};

std::size_t cells_for(std::size_t points) { return std::clamp<std::size_t>(points / kPointsWanted, 1, kMostCells); }

Box3 bounds_of_bucket(std::span<const BucketPoint> points) {
  Box3 box;
  for (const BucketPoint& p : points) box.grow(p.position);
  return box;
}

/// Which of the six directions of the axes a normal is nearest to.
std::uint32_t direction_of(Vec3 n) {
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  if (x >= y && x >= z) return n.x < 0 ? 1 : 0;
  if (y >= z) return n.y < 0 ? 3 : 2;
  return n.z < 0 ? 5 : 4;
}

}  // namespace

QueryBuckets::QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last) {
  const std::size_t n = last - first;
  const Cells cells(bounds_of(std::span(points.position).subspan(first, n)), cells_for(n));
  CellCounts counts(n, cells.count());
  std::vector<std::uint16_t> cell_of(n);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = counts.piece(begin / kPiece);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 p = points.position[first + i];
      cell_of[i] = kNoCell;
      if (!is_finite(p) || !is_finite(points.normal[first + i])) continue;
      const std::uint32_t cell = cells.cell(p);
      cell_of[i] = static_cast<std::uint16_t>(cell);
      ++count[cell];
    }
  });
  std::vector<Bucket> buckets;
  counts.sum(0, buckets);
  points_.resize(buckets.empty() ? 0 : buckets.back().last);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* place = counts.piece(begin / kPiece);
    for (std::size_t i = begin; i < end; ++i) {
      if (cell_of[i] == kNoCell) continue;
      const std::size_t q = first + i;
      points_[place[cell_of[i]]++] = {points.position[q], points.normal[q], static_cast<std::uint32_t>(q),
                                      points.bsdf[q] == kLambertianQuery};
    }
  });
  buckets_.reserve(buckets.size());
  for (const Bucket& bucket : buckets) divide(bucket, kMostRounds);
}

void QueryBuckets::divide(Bucket bucket, int rounds_left) {
  const std::size_t n = bucket.last - bucket.first;
  if (n <= kMostPoints) {
    buckets_.push_back(bucket);
    return;
  }
  const std::vector<BucketPoint> copy(points_.begin() + bucket.first, points_.begin() + bucket.last);
  const Cells cells(bounds_of_bucket(copy), cells_for(n));
  if (rounds_left == 0 || cells.count() == 1) {
    for (std::uint32_t first = bucket.first; first < bucket.last; first += kMostPoints)
      buckets_.push_back({first, std::min(bucket.last, first + static_cast<std::uint32_t>(kMostPoints))});
    return;
  }
  CellCounts counts(n, cells.count());
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = counts.piece(begin / kPiece);
    for (std::size_t i = begin; i < end; ++i) ++count[cells.cell(copy[i].position)];
  });
  std::vector<Bucket> parts;
  counts.sum(bucket.first, parts);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* place = counts.piece(begin / kPiece);
    for (std::size_t i = begin; i < end; ++i) points_[place[cells.cell(copy[i].position)]++] = copy[i];
  });
  for (const Bucket& part : parts) divide(part, rounds_left - 1);
}

std::uint64_t QueryBuckets::bytes(std::size_t points) {
  const std::uint64_t pieces = (points + kPiece - 1) / kPiece;
  return points * (sizeof(BucketPoint) + sizeof(std::uint16_t)) +
         (pieces * sizeof(std::uint32_t) + sizeof(Bucket)) * cells_for(points);
}

void BucketOrder::sort(std::span<const BucketPoint> points) {
  const std::size_t n = points.size();
  // As many levels of the curve as make cells of about four points on a surface.
  int bits = 0;
  while (bits < 7 && (std::size_t{8} << (2 * bits)) < n) ++bits;
  const CubeGrid grid(bounds_of_bucket(points), bits);
  // The upper digit holds the group in its highest three bits.
  const int key_bits = 3 * bits + 3, low_bits = std::min(key_bits / 2, 3 * bits), high_bits = key_bits - low_bits;
  std::vector<std::uint32_t> low_count(std::size_t{1} << low_bits), high_count(std::size_t{1} << high_bits);
  const std::uint32_t low_mask = (1u << low_bits) - 1;
  entries_.resize(n);
  other_.resize(n);
  order_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const BucketPoint& p = points[i];
    const std::uint32_t group = p.lambertian ? direction_of(p.normal) : static_cast<std::uint32_t>(kNotLambertian);
    const auto cell = static_cast<std::uint32_t>(hilbert_key_of_morton(grid.morton(p.position), bits));
    const std::uint32_t key = group << (3 * bits) | cell;
    entries_[i] = {key, static_cast<std::uint32_t>(i)};
    ++low_count[key & low_mask];
    ++high_count[key >> low_bits];
  }
  const auto to_places = [](std::vector<std::uint32_t>& counts) {
    std::uint32_t sum = 0;
    for (std::uint32_t& count : counts) {
      const std::uint32_t here = count;
      count = sum;
      sum += here;
    }
  };
  to_places(low_count);
  to_places(high_count);
  for (const Entry& entry : entries_) other_[low_count[entry.key & low_mask]++] = entry;
  // The upper digit holds the group in its highest three bits.
  for (std::size_t g = 0; g <= kGroups; ++g) first_[g] = high_count[g << (high_bits - 3)];
  for (const Entry& entry : other_) order_[high_count[entry.key >> low_bits]++] = entry.place;
}

}  // namespace glowworm
