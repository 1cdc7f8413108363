// The vector kernel of the guide's warp: the same bits as scalar code on every instruction set.
#include "kernels/guide_warp.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/random.h"
#include "kernels/guide_warp_reference.h"
#include "kernels/instruction_sets.h"

namespace glowworm {
namespace {

constexpr std::size_t kSide = GuideTable::kSide;

/// A table whose densities differ by up to 1000 between neighbours.
GuideTable table_of(std::uint32_t seed) {
  GuideTable table{};
  for (std::size_t r = 0; r <= kSide; ++r)
    for (std::size_t c = 0; c <= kSide; ++c) {
      const float u = to_unit_float(hash_combine(hash32(seed), static_cast<std::uint32_t>(r * (kSide + 1) + c)));
      table.density[r][c] = 0.01f + 10 * u * u * u;
      if (c > 0) table.columns[r][c] = table.columns[r][c - 1] + (table.density[r][c - 1] + table.density[r][c]) / 2;
    }
  for (std::size_t r = 1; r <= kSide; ++r)
    table.rows[r] = table.rows[r - 1] + (table.columns[r - 1][kSide] + table.columns[r][kSide]) / 2;
  return table;
}

TEST(GuideWarp, IsThatOfPlainLoopsBitForBit) {
  const std::vector<GuideTable> tables = {table_of(1), table_of(2), table_of(3)};
  constexpr float kBelowOne = 0x1.fffffep-1f;
  std::vector<float> x = {0, kBelowOne, 0, kBelowOne, 0.5f, 0.125f}, y = {0, 0, kBelowOne, kBelowOne, 0.5f, 0.875f};
  for (std::uint32_t i = 0; i < 4000; ++i) {
    Sampler sampler(SamplerKind::sobol, 1, 0, i);
    const Vec2 u = sampler.next2();
    x.push_back(u.x);
    y.push_back(u.y);
  }
  std::vector<std::uint32_t> table(x.size());
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = i % 4 < 3 ? static_cast<std::uint32_t>(i % 4) : kNoTable;
  on_every_instruction_set([&] {
    std::vector<float> warped_x = x, warped_y = y, weight(x.size(), 7.0f);
    warp_by_guide(tables.data(), table.data(), x.size(), {warped_x.data(), warped_y.data()}, weight.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      float expected_x = x[i], expected_y = y[i], expected_weight = 7;
      if (table[i] != kNoTable) warp_by_guide_reference(tables[table[i]], expected_x, expected_y, expected_weight);
      ASSERT_EQ(warped_x[i], expected_x) << i;
      ASSERT_EQ(warped_y[i], expected_y) << i;
      ASSERT_EQ(weight[i], expected_weight) << i;
    }
  });
}

}  // namespace
}  // namespace glowworm
