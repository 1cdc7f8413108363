#include "kernels/guide_warp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glowworm {

namespace {

constexpr std::size_t kSide = GuideTable::kSide;
constexpr float kBelowOne = 1 - std::numeric_limits<float>::epsilon() / 2;

float mixed(float a, float b, float t) { return a + (b - a) * t; }

/// The cell along a side in which integrals reach `sum`. @param sum_at(i) the integral up to the end of cell i
template <typename SumAt>
std::size_t cell_of(float sum, SumAt&& sum_at) {
  std::size_t cell = 0;
  for (std::size_t i = 0; i < kSide; ++i) cell += sum_at(i) <= sum;
  return std::min(cell, kSide - 1);
}

/// A place in a cell, from 0 to 1, and the density there.
struct Place {
  float at, density;
};

/// Where the integral of a density that goes from `low` to `high` over a cell reaches `sum`.
Place reach(float low, float high, float sum) {
  const float change = high - low, twice = 2 * sum;
  const float root = std::sqrt(std::max(low * low + change * twice, 0.0f));
  const float at = twice / (low + root);
  const float inside = at > 0 ? std::min(at, 1.0f) : 0;  // 0 / 0 where all is dark
  return {inside, low + change * inside};
}

/// The coordinate of a place in a cell.
float along_side(std::size_t cell, float at) {
  return std::min((static_cast<float>(cell) + at) / static_cast<float>(kSide), kBelowOne);
}

}  // namespace

void warp_by_guide(const GuideTable* tables, const std::uint32_t* table, std::size_t count, const DiffuseSquare& square,
                   float* weight) {
  for (std::size_t i = 0; i < count; ++i) {
    if (table[i] == kNoTable) continue;
    const GuideTable& t = tables[table[i]];
    const float row_sum = square.x[i] * t.rows[kSide];
    const std::size_t r = cell_of(row_sum, [&](std::size_t end) { return t.rows[end + 1]; });
    const float s = reach(t.columns[r][kSide], t.columns[r + 1][kSide], row_sum - t.rows[r]).at;
    const auto mixed_at = [&](const float(&values)[kSide + 1][kSide + 1], std::size_t column) {
      return mixed(values[r][column], values[r + 1][column], s);
    };
    const float sum = square.y[i] * mixed_at(t.columns, kSide);
    const std::size_t c = cell_of(sum, [&](std::size_t end) { return mixed_at(t.columns, end + 1); });
    const Place place = reach(mixed_at(t.density, c), mixed_at(t.density, c + 1), sum - mixed_at(t.columns, c));
    square.x[i] = along_side(r, s);
    square.y[i] = along_side(c, place.at);
    weight[i] = 1 / place.density;
  }
}

}  // namespace glowworm
