// The last barrier before the film: light that is no number.
#pragma once
#include <cstddef>

#include "points/gather_points.h"

namespace glowworm {

/// Radiance beyond this counts as infinite: sums of 2^24 samples stay finite. W sr^-1 m^-2.
inline constexpr float kLargestRadiance = 1e30f;

/// Sets samples to black in whose light a number is NaN, infinite or beyond kLargestRadiance; returns how many. They
/// come of lights so near to a surface, or so bright, that floats do not hold what arrives.
std::size_t drop_infinite_samples(SlotRadiance& radiance);

}  // namespace glowworm
