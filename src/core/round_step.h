// Steps of scales: 1, 2 or 5 times a power of ten.
#pragma once
#include <cmath>

namespace glowworm {

/// The greatest such step that is `most` (above 0) or less, but for rounding.
inline double round_step_below(double most) {
  constexpr double kRounding = 1e-9;
  const double enough = most * (1 + kRounding), power = std::pow(10.0, std::floor(std::log10(enough)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= enough) return factor * power;
  return power;
}

/// The least such step that is `least` (above 0) or more, but for rounding: steps 1, 2, 5 follow tenths of 10, 5, 2.
inline double round_step_above(double least) { return 1 / round_step_below(1 / least); }

}  // namespace glowworm
