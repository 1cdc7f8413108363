#include "density/blocked_queries.h"

#include <algorithm>
#include <bit>
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
// How far ahead of its use memory is asked for, in points.
constexpr std::size_t kAhead = 24;
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

/// Turns counts by (piece, cell) into the places where each piece puts the points of each cell, from `first` on; a
/// bucket for each cell that is not empty.
std::vector<QueryBuckets::Bucket> places_from_counts(std::span<std::uint32_t> counts, std::size_t cells,
                                                     std::uint32_t first) {
  std::vector<QueryBuckets::Bucket> buckets;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const std::uint32_t begin = first;
    for (std::size_t i = cell; i < counts.size(); i += cells) {
      const std::uint32_t count = counts[i];
      counts[i] = first;
      first += count;
    }
    if (first > begin) buckets.push_back({begin, first});
  }
  return buckets;
}

std::size_t pieces_of(std::size_t n) { return (n + kPiece - 1) / kPiece; }

std::size_t cells_for(std::size_t points) { return std::clamp<std::size_t>(points / kPointsWanted, 1, kMostCells); }

Box3 bounds_of_bucket(std::span<const BucketPoint> points) {
  Box3 box;
  for (const BucketPoint& p : points) box.grow(p.position);
  return box;
}

/// Bit i of a small number at place 3 i.
struct Spread {
  static constexpr int kBits = 7;
  std::uint32_t bits[1 << kBits] = {};
  constexpr Spread() {
    for (std::uint32_t v = 0; v < (1u << kBits); ++v)
      for (int bit = 0; bit < kBits; ++bit) bits[v] |= (v >> bit & 1) << (3 * bit);
  }
};
constexpr Spread kSpread;

/// Hilbert keys of a few bits: what hilbert_key() gives, from tables that stay in the first-level cache.
class LocalKeys {
 public:
  static constexpr int kMostBits = Spread::kBits;
  LocalKeys(const Box3& box, int bits) : grid_(box, bits), bits_(bits) {}
  std::uint32_t key(Vec3 p) const {
    const GridCell cell = grid_.cell(p);
    const std::uint32_t morton = kSpread.bits[cell.x] | kSpread.bits[cell.y] << 1 | kSpread.bits[cell.z] << 2;
    unsigned orientation = 0;
    std::uint32_t key = 0;
    int shift = 3 * bits_ - 6;
    if (bits_ & 1) {
      const unsigned step = kHilbert.place[0][morton >> (shift + 3)];
      key = step & 7;
      orientation = step >> 3;
      shift -= 3;
    }
    for (; shift >= 0; shift -= 6) {
      const unsigned step = kHilbert.place2[orientation][morton >> shift & 63];
      key = key << 6 | (step & 63);
      orientation = step >> 6;
    }
    return key;
  }

 private:
  CubeGrid grid_;
  int bits_;
};

/// Which of the six directions of the axes a normal is nearest to. Without branches, which would be guessed wrong.
std::uint32_t direction_of(Vec3 n) {
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const unsigned of_two = y > x;
  const unsigned third = z > std::max(x, y);
  const unsigned axis = of_two + third * (2 - of_two);
  const float along[3] = {n.x, n.y, n.z};
  return 2 * axis + (std::bit_cast<std::uint32_t>(along[axis]) >> 31);
}

}  // namespace

QueryBuckets::QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last) : first_(first) {
  const std::size_t n = last - first;
  const Cells cells(bounds_of(std::span(points.position).subspan(first, n)), cells_for(n));
  cells_ = cells.count();
  cell_of_ = LargeArray<std::uint16_t>(n);
  places_ = LargeArray<std::uint32_t>(pieces_of(n) * cells_);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = &places_[begin / kPiece * cells_];
    std::fill_n(count, cells_, 0u);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 p = points.position[first + i];
      cell_of_[i] = kNoCell;
      if (!is_finite(p) || !is_finite(points.normal[first + i])) continue;
      const std::uint32_t cell = cells.cell(p);
      cell_of_[i] = static_cast<std::uint16_t>(cell);
      ++count[cell];
    }
  });
  const std::vector<Bucket> buckets = places_from_counts(places_.span(), cells_, 0);
  const std::size_t taken = buckets.empty() ? 0 : buckets.back().last;
  points_ = LargeArray<BucketPoint>(taken);
  answers_ = LargeArray<RGB>(taken);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* places = &places_[begin / kPiece * cells_];
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < end && cell_of_[i + kAhead] != kNoCell)
        __builtin_prefetch(&points_[places[cell_of_[i + kAhead]]], 1);
      if (cell_of_[i] == kNoCell) continue;
      const std::size_t q = first + i;
      const std::uint32_t place = places[cell_of_[i]]++;
      points_[place] = {points.position[q], points.normal[q], points.bsdf[q], place};
    }
  });
  buckets_.reserve(buckets.size());
  for (const Bucket& bucket : buckets) divide(bucket, kMostRounds);
}

void QueryBuckets::add_answers(const QueryPoints& points, std::span<RGB> radiance) {
  parallel_for(0, cell_of_.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    // Each place stands behind the last point that was put there: backwards, it leads from point to point.
    std::uint32_t* places = &places_[begin / kPiece * cells_];
    for (std::size_t i = end; i-- > begin;) {
      if (i >= begin + kAhead && cell_of_[i - kAhead] != kNoCell)
        __builtin_prefetch(&answers_[places[cell_of_[i - kAhead]]] - 1);
      if (cell_of_[i] == kNoCell) continue;
      const RGB answer = answers_[--places[cell_of_[i]]];
      const std::size_t q = first_ + i;
      radiance[q] += points.bsdf[q] == kLambertianQuery ? points.reflectance[q] * answer : answer;
    }
  });
}

void QueryBuckets::divide(Bucket bucket, int rounds_left) {
  const std::size_t n = bucket.last - bucket.first;
  if (n <= kMostPoints) {
    buckets_.push_back(bucket);
    return;
  }
  const std::vector<BucketPoint> copy(&points_[bucket.first], &points_[bucket.first] + n);
  const Cells cells(bounds_of_bucket(copy), cells_for(n));
  if (rounds_left == 0 || cells.count() == 1) {
    for (std::uint32_t first = bucket.first; first < bucket.last; first += kMostPoints)
      buckets_.push_back({first, std::min(bucket.last, first + static_cast<std::uint32_t>(kMostPoints))});
    return;
  }
  std::vector<std::uint32_t> places(pieces_of(n) * cells.count());
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = &places[begin / kPiece * cells.count()];
    for (std::size_t i = begin; i < end; ++i) ++count[cells.cell(copy[i].position)];
  });
  const std::vector<Bucket> parts = places_from_counts(places, cells.count(), bucket.first);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* place = &places[begin / kPiece * cells.count()];
    for (std::size_t i = begin; i < end; ++i) points_[place[cells.cell(copy[i].position)]++] = copy[i];
  });
  for (const Bucket& part : parts) divide(part, rounds_left - 1);
}

std::uint64_t QueryBuckets::bytes(std::size_t points) {
  return points * (sizeof(BucketPoint) + sizeof(RGB) + sizeof(std::uint16_t)) +
         (pieces_of(points) * sizeof(std::uint32_t) + sizeof(Bucket)) * cells_for(points);
}

void BucketOrder::sort(std::span<const BucketPoint> points) {
  const std::size_t n = points.size();
  // As many levels of the curve as make cells of about four points on a surface.
  int bits = 0;
  while (bits < LocalKeys::kMostBits && (std::size_t{8} << (2 * bits)) < n) ++bits;
  const LocalKeys keys(bounds_of_bucket(points), bits);
  // The upper digit holds the group in its highest three bits.
  const int key_bits = 3 * bits + 3, low_bits = std::min(key_bits / 2, 3 * bits), high_bits = key_bits - low_bits;
  std::vector<std::uint32_t> low_count(std::size_t{1} << low_bits), high_count(std::size_t{1} << high_bits);
  const std::uint32_t low_mask = (1u << low_bits) - 1;
  entries_.resize(n);
  other_.resize(n);
  order_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const BucketPoint& p = points[i];
    const std::uint32_t group =
        p.bsdf == kLambertianQuery ? direction_of(p.normal) : static_cast<std::uint32_t>(kNotLambertian);
    const std::uint32_t key = group << (3 * bits) | keys.key(p.position);
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
