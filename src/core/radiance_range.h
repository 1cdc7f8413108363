// The radiance that pictures can hold.
#pragma once
#include "core/exact_sum.h"

namespace glowworm {

/// Sums of radiance over the samples of a pixel, with a resolution of 5e-20 W sr^-1 m^-2.
using RadianceSum = ExactSum<Int128, 64>;

/// Largest radiance of a sample: 2.7e11 W sr^-1 m^-2.
inline constexpr float kMaxRadiance = RadianceSum::kMaxTerm;
/// Least radiance of the brightest light: 9e-13 W sr^-1 m^-2. The sums hold all 24 bits of it, and 14 bits of a
/// thousandth of it.
inline constexpr float kMinRadiance = 0x1p-40f;

}  // namespace glowworm
