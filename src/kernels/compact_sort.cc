#include "kernels/compact_sort.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/compact_sort.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
constexpr std::size_t kLanes = hn::MaxLanes(F());
constexpr std::size_t kCoordinates = 8;
// Bisections of an interval of numbers before bisection by the count of floats in it.
constexpr int kEvenSteps = 16;

/// Smallest and largest of each coordinate.
HWY_INLINE void bounds(const CompactRow* rows, std::size_t count, float* low, float* high) {
  const F f;
  for (std::size_t part = 0; part < kCoordinates; part += kLanes) {
    auto least = hn::Load(f, rows[0].coordinate + part), most = least;
    for (std::size_t i = 1; i < count; ++i) {
      const auto row = hn::Load(f, rows[i].coordinate + part);
      least = hn::Min(least, row);
      most = hn::Max(most, row);
    }
    hn::Store(least, f, low + part);
    hn::Store(most, f, high + part);
  }
}

/// Numbers of the column below `bound`. @param count a multiple of kLanes
HWY_INLINE std::size_t count_below(const float* column, std::size_t count, float bound) {
  const F f;
  const I whole;
  const auto bounds = hn::Set(f, bound);
  auto counts = hn::Zero(whole);
  for (std::size_t i = 0; i < count; i += kLanes)
    counts = hn::Sub(counts, hn::VecFromMask(whole, hn::RebindMask(whole, hn::Lt(hn::Load(f, column + i), bounds))));
  return static_cast<std::size_t>(hn::GetLane(hn::SumOfLanes(whole, counts)));
}

/// Cut of a column: numbers below `bound` and the first `ties` of those equal to it are on the left.
struct Cut {
  float bound;
  std::size_t ties;
};

/// Integers in the order of floats: neighbouring floats differ by one.
HWY_INLINE std::int64_t rank(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  return bits ^ ((bits >> 31) & 0x7fffffff);
}
HWY_INLINE float of_rank(std::int64_t rank) {
  const auto bits = static_cast<std::int32_t>(rank);
  return std::bit_cast<float>(bits ^ ((bits >> 31) & 0x7fffffff));
}

/// The cut with `half` numbers on the left, by bisection: moves no number and branches on none.
/// @param low, high smallest and largest of the column; @param padded the column, followed by infinities
HWY_INLINE Cut find_cut(const float* column, std::size_t padded, std::size_t half, float low, float high) {
  std::size_t below_low = 0;
  std::int64_t first = rank(low), last = rank(high) + 1;  // at most half are below the first, and more below the last
  for (int step = 0; last - first > 1; ++step) {
    const float from = of_rank(first), to = of_rank(last);
    float middle = 0.5f * from + 0.5f * to;
    if (step >= kEvenSteps || !(middle > from && middle < to)) middle = of_rank((first + last) >> 1);
    const std::size_t below = count_below(column, padded, middle);
    if (below == half) return {middle, 0};
    if (below < half) {
      first = rank(middle);
      below_low = below;
    } else {
      last = rank(middle);
    }
  }
  return {of_rank(first), half - below_low};
}

HWY_INLINE void copy(const CompactRow& from, CompactRow& to) {
  const F f;
  for (std::size_t part = 0; part < kCoordinates; part += kLanes)
    hn::Store(hn::Load(f, from.coordinate + part), f, to.coordinate + part);
}

/// Writes the rows on the left of the cut to the front of `to`, the others behind them.
HWY_INLINE void divide(const CompactRow* HWY_RESTRICT rows, CompactRow* HWY_RESTRICT to,
                       const float* HWY_RESTRICT column, std::size_t count, std::size_t half, Cut cut) {
  std::size_t left = 0, right = half;
  const float bound = cut.bound;
  // No branch depends on a number.
  if (cut.ties == 0) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t is_left = column[i] < bound;
      copy(rows[i], to[right ^ ((left ^ right) & (std::size_t{0} - is_left))]);
      left += is_left;
      right += 1 - is_left;
    }
    return;
  }
  std::size_t ties = cut.ties;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t is_tie = static_cast<std::size_t>(column[i] == bound) & static_cast<std::size_t>(ties > 0);
    const std::size_t is_left = static_cast<std::size_t>(column[i] < bound) | is_tie;
    ties -= is_tie;
    copy(rows[i], to[right ^ ((left ^ right) & (std::size_t{0} - is_left))]);
    left += is_left;
    right += 1 - is_left;
  }
}

/// @param rows, other change roles at every level; @param swapped the result belongs in `other`
void sort_rows(CompactRow* rows, CompactRow* other, float* column, std::size_t count, bool swapped) {
  if (count <= kCompactWidth) {
    if (swapped)
      for (std::size_t i = 0; i < count; ++i) copy(rows[i], other[i]);
    return;
  }
  alignas(64) float low[kCoordinates], high[kCoordinates];
  bounds(rows, count, low, high);
  const int axis = compact_axis(low, high);
  for (std::size_t i = 0; i < count; ++i) column[i] = rows[i].coordinate[axis];
  const std::size_t padded = (count + kLanes - 1) / kLanes * kLanes;
  for (std::size_t i = count; i < padded; ++i) column[i] = std::numeric_limits<float>::infinity();
  const std::size_t half = compact_half(count);
  const Cut cut = find_cut(column, padded, half, low[axis], high[axis]);
  divide(rows, other, column, count, half, cut);
  sort_rows(other, rows, column, half, !swapped);
  sort_rows(other + half, rows + half, column, count - half, !swapped);
}

void sort_all(CompactRow* rows, CompactRow* scratch, float* column, std::size_t count) {
  sort_rows(rows, scratch, column, count, false);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(sort_all);
}

void compact_sort(std::span<CompactRow> rows, std::span<CompactRow> scratch, std::span<float> column) {
  HWY_DYNAMIC_DISPATCH(sort_all)(rows.data(), scratch.data(), column.data(), rows.size());
}

}  // namespace glowworm
#endif  // HWY_ONCE
