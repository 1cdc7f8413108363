#include "kernels/guide_warp.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/guide_warp.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using CellTag = hn::CappedTag<float, GuideTable::kSide>;
using PlaceTag = hn::CappedTag<float, 16>;
constexpr std::size_t kCellLanes = hn::MaxLanes(CellTag()), kSide = GuideTable::kSide;
constexpr float kBelowOne = 1 - std::numeric_limits<float>::epsilon() / 2;

/// Points that are warped at a time, one after the other in searches, and in vectors where roots and quotients would
/// wait for each other.
struct Block {
  static constexpr std::size_t kPoints = 64;
  const GuideTable* table[kPoints];
  std::size_t point[kPoints], cell[kPoints];
  /// Densities at both ends of the cell in which an integral reaches `sum`, where it does, and the density there.
  float low[kPoints], high[kPoints], sum[kPoints], place[kPoints], density[kPoints];
  std::size_t size = 0;

  void set(std::size_t i, std::size_t in_cell, float density_low, float density_high, float in_sum) {
    cell[i] = in_cell;
    low[i] = density_low;
    high[i] = density_high;
    sum[i] = in_sum;
  }
};

HWY_INLINE float mixed(float a, float b, float t) { return a + (b - a) * t; }

/// The cell along a side in which integrals reach `sum`. @param sums_at(i) integrals up to the ends of cells from i on
template <typename SumsAt>
HWY_INLINE std::size_t cell_of(float sum, SumsAt&& sums_at) {
  const CellTag f;
  std::size_t cell = 0;
  for (std::size_t i = 0; i < kSide; i += kCellLanes) cell += hn::CountTrue(f, hn::Le(sums_at(i), hn::Set(f, sum)));
  return std::min(cell, kSide - 1);
}

/// Finds where integrals reach their sums within cells.
HWY_INLINE void find_places(Block& block) {
  const PlaceTag f;
  const auto zero = hn::Zero(f), two = hn::Set(f, 2.0f);
  for (std::size_t i = 0; i < block.size; i += hn::Lanes(f)) {
    const auto low = hn::LoadU(f, block.low + i), change = hn::Sub(hn::LoadU(f, block.high + i), low);
    const auto twice = hn::Mul(two, hn::LoadU(f, block.sum + i));
    const auto root = hn::Sqrt(hn::Max(hn::Add(hn::Mul(low, low), hn::Mul(change, twice)), zero));
    const auto place = hn::Min(hn::Max(hn::Div(twice, hn::Add(low, root)), zero), hn::Set(f, 1.0f));
    hn::StoreU(place, f, block.place + i);
    hn::StoreU(hn::Add(low, hn::Mul(change, place)), f, block.density + i);
  }
}

HWY_INLINE void find_row(Block& block, std::size_t i, float x) {
  const CellTag f;
  const GuideTable& table = *block.table[i];
  const float sum = x * table.rows[kSide];
  const std::size_t r = cell_of(sum, [&](std::size_t at) HWY_ATTR { return hn::LoadU(f, table.rows + 1 + at); });
  block.set(i, r, table.columns[r][kSide], table.columns[r + 1][kSide], sum - table.rows[r]);
}

/// Returns the warped x.
HWY_INLINE float find_column(Block& block, std::size_t i, float y) {
  const CellTag f;
  const GuideTable& table = *block.table[i];
  const std::size_t r = block.cell[i];
  const float s = block.place[i];
  const float* low_sums = table.columns[r];
  const float* high_sums = table.columns[r + 1];
  const float sum = y * mixed(low_sums[kSide], high_sums[kSide], s);
  const std::size_t c = cell_of(sum, [&](std::size_t at) HWY_ATTR {
    const auto low = hn::LoadU(f, low_sums + 1 + at), high = hn::LoadU(f, high_sums + 1 + at);
    return hn::Add(low, hn::Mul(hn::Sub(high, low), hn::Set(f, s)));
  });
  block.set(i, c, mixed(table.density[r][c], table.density[r + 1][c], s),
            mixed(table.density[r][c + 1], table.density[r + 1][c + 1], s), sum - mixed(low_sums[c], high_sums[c], s));
  return std::min((static_cast<float>(r) + s) / kSide, kBelowOne);
}

void warp(Block& block, const DiffuseSquare& square, float* weight) {
  for (std::size_t i = 0; i < block.size; ++i) find_row(block, i, square.x[block.point[i]]);
  find_places(block);
  for (std::size_t i = 0; i < block.size; ++i) {
    const std::size_t point = block.point[i];
    square.x[point] = find_column(block, i, square.y[point]);
  }
  find_places(block);
  for (std::size_t i = 0; i < block.size; ++i) {
    const std::size_t point = block.point[i];
    square.y[point] = std::min((static_cast<float>(block.cell[i]) + block.place[i]) / kSide, kBelowOne);
    weight[point] = 1 / block.density[i];
  }
  block.size = 0;
}

void warp_all(const GuideTable* tables, const std::uint32_t* table, std::size_t count, const DiffuseSquare& square,
              float* weight) {
  Block block = {};
  for (std::size_t i = 0; i < count; ++i) {
    if (table[i] == kNoTable) continue;
    block.point[block.size] = i;
    block.table[block.size++] = &tables[table[i]];
    if (block.size == Block::kPoints) warp(block, square, weight);
  }
  warp(block, square, weight);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(warp_all);
}

void warp_by_guide(const GuideTable* tables, const std::uint32_t* table, std::size_t count, const DiffuseSquare& square,
                   float* weight) {
  HWY_DYNAMIC_DISPATCH(warp_all)(tables, table, count, square, weight);
}

}  // namespace glowworm
#endif  // HWY_ONCE
