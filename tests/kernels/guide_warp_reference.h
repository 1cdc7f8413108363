#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/guide_warp.h"

namespace glowworm {

namespace guide_warp {

inline float mixed(float a, float b, float t) { return a + (b - a) * t; }

/// Where the integral of a density that goes from a to b over [0, 1] reaches `sum`.
inline float reaches(float a, float b, float sum) {
  const float root = std::sqrt(std::max(a * a + (b - a) * (2 * sum), 0.0f));
  return std::clamp(2 * sum / (a + root), 0.0f, 1.0f);
}

}  // namespace guide_warp

/// warp_by_guide() for one point as plain loops, bit for bit.
inline void warp_by_guide_reference(const GuideTable& table, float& x, float& y, float& weight) {
  using namespace guide_warp;
  constexpr std::size_t kSide = GuideTable::kSide;
  constexpr float kBelowOne = 1 - std::numeric_limits<float>::epsilon() / 2;
  std::size_t r = 0, c = 0;
  const float row_sum = x * table.rows[kSide];
  while (r + 1 < kSide && row_sum >= table.rows[r + 1]) ++r;
  const float s = reaches(table.columns[r][kSide], table.columns[r + 1][kSide], row_sum - table.rows[r]);
  const auto along = [s, r](const float(&of)[kSide + 1][kSide + 1], std::size_t i) {
    return mixed(of[r][i], of[r + 1][i], s);
  };
  const float column_sum = y * along(table.columns, kSide);
  while (c + 1 < kSide && column_sum >= along(table.columns, c + 1)) ++c;
  const float low = along(table.density, c), high = along(table.density, c + 1);
  const float t = reaches(low, high, column_sum - along(table.columns, c));
  x = std::min((static_cast<float>(r) + s) / kSide, kBelowOne);
  y = std::min((static_cast<float>(c) + t) / kSide, kBelowOne);
  weight = 1 / mixed(low, high, t);
}

}  // namespace glowworm
