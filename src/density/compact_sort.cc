#include "density/compact_sort.h"

#include <algorithm>

namespace glowworm {

namespace {

/// The coordinate whose spread extends a block of these rows most.
int widest_axis(std::span<const CompactRow> rows) {
  float low[8], high[8];
  std::copy_n(rows[0].coordinate, 8, low);
  std::copy_n(rows[0].coordinate, 8, high);
  for (const CompactRow& row : rows)
    for (int c = 0; c < 8; ++c) {
      low[c] = std::min(low[c], row.coordinate[c]);
      high[c] = std::max(high[c], row.coordinate[c]);
    }
  const auto widest = [&](int first) {
    int axis = first;
    for (int i = first + 1; i < first + 3; ++i)
      if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    return axis;
  };
  constexpr int kRadius = CompactRow::kRadius;
  const int position = widest(0), normal = widest(3);
  const float by_position = high[position] - low[position];
  const float by_normal = (high[normal] - low[normal]) * (0.5f * kCompactNormalWeight * (low[kRadius] + high[kRadius]));
  const float by_radius = (high[kRadius] - low[kRadius]) * kCompactRadiusWeight;
  return by_position >= by_normal && by_position >= by_radius ? position : by_normal >= by_radius ? normal : kRadius;
}

}  // namespace

void compact_sort(std::span<CompactRow> rows, std::span<CompactRow> scratch, std::span<float> column) {
  const std::size_t count = rows.size();
  if (count <= kCompactWidth) return;
  const int axis = widest_axis(rows);
  for (std::size_t i = 0; i < count; ++i) column[i] = rows[i].coordinate[axis];
  // The largest power of two of blocks below the number of all.
  const std::size_t half = kCompactWidth * std::bit_floor((count - 1) / kCompactWidth);
  std::nth_element(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(half),
                   column.begin() + static_cast<std::ptrdiff_t>(count));
  const float bound = column[half];
  // Of the rows at the bound, the first fill the first part.
  std::size_t ties = half;
  for (std::size_t i = 0; i < half; ++i) ties -= column[i] < bound;
  std::size_t left = 0, right = half;
  for (const CompactRow& row : rows) {
    const std::size_t is_tie = static_cast<std::size_t>(row.coordinate[axis] == bound) & (ties > 0);
    const std::size_t is_left = static_cast<std::size_t>(row.coordinate[axis] < bound) | is_tie;
    ties -= is_tie;
    scratch[is_left ? left : right] = row;
    left += is_left;
    right += 1 - is_left;
  }
  std::copy_n(scratch.begin(), count, rows.begin());
  compact_sort(rows.first(half), scratch, column);
  compact_sort(rows.subspan(half), scratch, column);
}

}  // namespace glowworm
