#include "density/blocked_queries.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;
// Target size of a bucket: its records stay in the second-level cache during sorting.
constexpr std::size_t kPointsWanted = 1024;
constexpr std::size_t kMaxCells = 4096;
// Points from which the bounds of the grid are measured.
constexpr std::size_t kSampledForBounds = std::size_t{1} << 16;
// Points in a square of the finest level to which a bucket is sorted.
constexpr std::size_t kPointsOfSquare = 4;
// Rounds of dividing a bucket that is too large; after them it is kept as it is.
constexpr int kMaxRounds = 8;

/// A grid over a box with at most the given number of cells.
KeyGrid grid_over(const Box3& box, std::size_t most_cells) {
  KeyGrid grid;
  if (box.empty()) return grid;
  const Vec3 d = box.diagonal();
  const float longest = std::max(d.x, std::max(d.y, d.z));
  grid.origin = box.min;
  if (!(longest > 0) || !std::isfinite(longest)) return grid;
  // The largest number along the longest side that keeps the number of cells within the limit.
  const auto along = [&](float side, std::uint32_t n) {
    return std::min(n, 1 + static_cast<std::uint32_t>(side / longest * static_cast<float>(n)));
  };
  const auto cells = [&](std::uint32_t n) { return std::size_t{along(d.x, n)} * along(d.y, n) * along(d.z, n); };
  std::uint32_t low = 1, high = static_cast<std::uint32_t>(most_cells);
  while (low < high) {
    const std::uint32_t middle = (low + high + 1) / 2;
    if (cells(middle) <= most_cells)
      low = middle;
    else
      high = middle - 1;
  }
  for (int axis = 0; axis < 3; ++axis) grid.cells[axis] = along(d[axis], low);
  const float scale = static_cast<float>(low) / longest;
  // In a box too small to divide, all points share one cell.
  grid.cells_per_metre = std::isfinite(scale * (1 << kKeyLevels)) ? scale : 0;
  return grid;
}

std::size_t cell_count(const KeyGrid& grid) { return std::size_t{grid.cells[0]} * grid.cells[1] * grid.cells[2]; }

/// Turns counts by (piece, cell) into the places where each piece puts the points of each cell, starting at `first`;
/// makes a bucket for each cell that is not empty.
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

std::size_t cells_for(std::size_t points) { return std::clamp<std::size_t>(points / kPointsWanted, 1, kMaxCells); }

/// The first n elements of an array; allocates a new array if it is smaller.
template <typename T>
std::span<T> grown(LargeArray<T>& array, std::size_t n) {
  if (array.size() < n) {
    array = LargeArray<T>();  // first, so that both are never held
    array = LargeArray<T>(n);
  }
  return array.span().first(n);
}

/// The box around a sample of the points; points outside count to the border cells.
Box3 sampled_bounds(std::span<const Vec3> points) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSampledForBounds);
  Box3 box;
  for (std::size_t i = 0; i < points.size(); i += step)
    if (is_finite(points[i])) box.grow(points[i]);
  return box;
}

/// Moves bit i to bit 2i, for kKeyLevels bits.
std::uint32_t spread_bits(std::uint32_t v) {
  static_assert(kKeyLevels <= 8);
  v = (v | v << 4) & 0x0f0fu;
  v = (v | v << 2) & 0x3333u;
  return (v | v << 1) & 0x5555u;
}

/// The position of square (x, y) on a Hilbert curve through 2^kKeyLevels squares along each axis (Skilling,
/// "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004: the coordinates become the key's bits level
/// by level).
std::uint32_t along_curve(std::uint32_t x, std::uint32_t y) {
  for (std::uint32_t upper = 1u << (kKeyLevels - 1); upper > 1; upper >>= 1) {
    const std::uint32_t lower = upper - 1;
    x ^= x & upper ? lower : 0;
    const std::uint32_t difference = (x ^ y) & lower;
    x ^= y & upper ? lower : difference;
    y ^= y & upper ? 0 : difference;
  }
  y ^= x;
  // Bit i: the parity of the bits of y above it.
  std::uint32_t turned = y >> 1;
  for (int shift = 1; shift < kKeyLevels; shift *= 2) turned ^= turned >> shift;
  return spread_bits(x ^ turned) << 1 | spread_bits(y ^ turned);
}

}  // namespace

std::uint32_t query_key(const KeyGrid& grid, Vec3 position, Vec3 normal, bool lambertian) {
  if (!is_finite(position) || !is_finite(normal)) return kNoKey;
  constexpr std::uint32_t kFine = 1u << kKeyLevels;
  std::uint32_t cell = 0, stride = 1, fine[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float place = (position[axis] - grid.origin[axis]) * (grid.cells_per_metre * static_cast<float>(kFine));
    const float last = static_cast<float>(grid.cells[axis] * kFine - 1);
    const auto whole = static_cast<std::uint32_t>(std::min(std::max(place, 0.0f), last));
    cell += whole / kFine * stride;
    fine[axis] = whole % kFine;
    stride *= grid.cells[axis];
  }
  const Vec3 size{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  const int axis = size.z > std::max(size.x, size.y) ? 2 : size.y > size.x ? 1 : 0;
  const std::uint32_t group =
      lambertian ? 2 * static_cast<std::uint32_t>(axis) + std::signbit(normal[axis]) : kNotLambertianGroup;
  const std::uint32_t slab = fine[axis] >> (kKeyLevels - kKeySlabBits);
  const std::uint32_t curve = along_curve(fine[axis == 0], fine[axis == 2 ? 1 : 2]);
  return cell << kKeyCellShift | group << kKeyGroupShift | slab << kKeyCurveBits | curve;
}

QueryBuckets::QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last, QueryMemory& memory)
    : memory_(memory), first_(first), last_(last) {
  const std::size_t n = last - first;
  const KeyGrid grid = grid_over(sampled_bounds(std::span(points.position).subspan(first, n)), cells_for(n));
  cells_ = cell_count(grid);
  const std::span<std::uint32_t> keys = grown(memory_.keys, n);
  const std::span<std::uint32_t> all_places = grown(memory_.places, pieces_of(n) * cells_);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = &all_places[begin / kPiece * cells_];
    std::fill_n(count, cells_, 0u);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t q = first + i;
      keys[i] = query_key(grid, points.position[q], points.normal[q], points.bsdf[q] == kLambertianQuery);
      if (keys[i] != kNoKey) ++count[keys[i] >> kKeyCellShift];
    }
  });
  const std::vector<Bucket> buckets = places_from_counts(all_places, cells_, 0);
  taken_ = buckets.empty() ? 0 : buckets.back().last;
  const std::span<BucketPoint> moved = grown(memory_.points, taken_);
  grown(memory_.answers, taken_);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* places = &all_places[begin / kPiece * cells_];
    for (std::size_t i = begin; i < end; ++i) {
      if (keys[i] == kNoKey) continue;
      const std::size_t q = first + i;
      moved[places[keys[i] >> kKeyCellShift]++] = {points.position[q], points.normal[q], points.bsdf[q], keys[i]};
    }
  });
  buckets_.reserve(buckets.size());
  for (const Bucket& bucket : buckets) divide(bucket, kMaxRounds);
}

void QueryBuckets::add_answers(const QueryPoints& points, std::span<RGB> radiance) {
  const LargeArray<std::uint32_t>& keys = memory_.keys;
  parallel_for(0, last_ - first_, kPiece, [&](std::size_t begin, std::size_t end) {
    // Each place is one past the last point put there; reading backwards visits the points in order.
    std::uint32_t* places = &memory_.places[begin / kPiece * cells_];
    for (std::size_t i = end; i-- > begin;) {
      if (keys[i] == kNoKey) continue;
      const RGB answer = memory_.answers[--places[keys[i] >> kKeyCellShift]];
      const std::size_t q = first_ + i;
      const bool lambertian = (keys[i] >> kKeyGroupShift & 7) != kNotLambertianGroup;
      radiance[q] += lambertian ? points.reflectance[q] * answer : answer;
    }
  });
}

void QueryBuckets::divide(Bucket bucket, int rounds_left) {
  const std::size_t n = bucket.last - bucket.first;
  if (n <= kMaxPoints) {
    buckets_.push_back(bucket);
    return;
  }
  if (origin_.size() == 0) {
    origin_ = LargeArray<std::uint32_t>(taken_);
    std::iota(origin_.data(), origin_.data() + origin_.size(), 0u);
  }
  const std::vector<BucketPoint> copy(&memory_.points[bucket.first], &memory_.points[bucket.first] + n);
  const std::vector<std::uint32_t> origins(&origin_[bucket.first], &origin_[bucket.first] + n);
  std::vector<std::uint32_t> keys(n);
  Box3 box;
  for (const BucketPoint& point : copy) box.grow(point.position);
  const KeyGrid grid = grid_over(box, cells_for(n));
  const std::size_t cells = cell_count(grid);
  if (rounds_left == 0 || cells == 1) {
    for (std::uint32_t first = bucket.first; first < bucket.last; first += kMaxPoints)
      buckets_.push_back({first, std::min(bucket.last, first + static_cast<std::uint32_t>(kMaxPoints))});
    return;
  }
  std::vector<std::uint32_t> places(pieces_of(n) * cells);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* count = &places[begin / kPiece * cells];
    for (std::size_t i = begin; i < end; ++i) {
      keys[i] = query_key(grid, copy[i].position, copy[i].normal, copy[i].bsdf == kLambertianQuery);
      ++count[keys[i] >> kKeyCellShift];
    }
  });
  const std::vector<Bucket> parts = places_from_counts(places, cells, bucket.first);
  parallel_for(0, n, kPiece, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* place = &places[begin / kPiece * cells];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t to = place[keys[i] >> kKeyCellShift]++;
      memory_.points[to] = copy[i];
      memory_.points[to].key = keys[i];
      origin_[to] = origins[i];
    }
  });
  for (const Bucket& part : parts) divide(part, rounds_left - 1);
}

void BucketOrder::sort(std::span<const BucketPoint> points) {
  const std::size_t n = points.size();
  constexpr std::uint32_t kSheets = 1u << (kKeyCellShift - kKeyCurveBits), kSheetMask = kSheets - 1;
  keys_.resize(n);
  order_.resize(n);
  // A sheet is a group and a slab. A cell holds few sheets, and only these take part.
  std::array<std::uint32_t, kSheets> sheet_points{}, sheet_place{};
  for (std::size_t i = 0; i < n; ++i) {
    keys_[i] = points[i].key;
    ++sheet_points[keys_[i] >> kKeyCurveBits & kSheetMask];
  }
  std::uint32_t sheets = 0, before = 0;
  for (std::uint32_t s = 0; s < kSheets; ++s) {
    if (s % (1u << kKeySlabBits) == 0) first_[s >> kKeySlabBits] = before;
    before += sheet_points[s];
    sheet_place[s] = sheets;
    sheets += sheet_points[s] > 0;
  }
  // As many levels of the curve as give squares of a few points on a sheet.
  int levels = 0;
  while (levels < kKeyLevels && (std::size_t{kPointsOfSquare} << (2 * levels)) * sheets < n) ++levels;
  const int shift = kKeyCurveBits - 2 * levels;
  const std::uint32_t curve_mask = (1u << kKeyCurveBits) - 1;
  places_.assign(std::size_t{sheets} << (2 * levels), 0);
  for (std::uint32_t& key : keys_) {
    key = sheet_place[key >> kKeyCurveBits & kSheetMask] << (2 * levels) | (key & curve_mask) >> shift;
    ++places_[key];
  }
  std::exclusive_scan(places_.begin(), places_.end(), places_.begin(), 0u);
  for (std::size_t i = 0; i < n; ++i) order_[places_[keys_[i]]++] = static_cast<std::uint32_t>(i);
}

}  // namespace glowworm
