#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "kernels/compact_sort.h"

namespace glowworm {

/// compact_sort() in plain C++: the reference for tests of the vector code.
inline void compact_sort_reference(std::span<CompactRow> rows) {
  if (rows.size() <= kCompactWidth) return;
  float low[8], high[8];
  for (int c = 0; c < 8; ++c) {
    low[c] = high[c] = rows[0].coordinate[c];
    for (const CompactRow& row : rows) {
      low[c] = std::min(low[c], row.coordinate[c]);
      high[c] = std::max(high[c], row.coordinate[c]);
    }
  }
  const int axis = compact_axis(low, high);
  const std::size_t half = compact_half(rows.size());
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rows[a].coordinate[axis] < rows[b].coordinate[axis]; });
  // Both parts keep the order of the input.
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half));
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(half), order.end());
  const std::vector<CompactRow> before(rows.begin(), rows.end());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = before[order[i]];
  compact_sort_reference(rows.first(half));
  compact_sort_reference(rows.subspan(half));
}

}  // namespace glowworm
