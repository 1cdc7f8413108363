// Removes light that is not finite before it reaches the film.
#pragma once
#include <cstddef>

#include "points/gather_points.h"

namespace glowworm {

/// Radiance beyond this counts as infinite: sums of 2^24 samples stay finite. W sr^-1 m^-2.
inline constexpr float kMaxRadiance = 1e30f;

/// Sets samples to black if a number in their light is NaN, infinite or beyond kMaxRadiance; returns how many. They
/// occur where a light is so near to a surface, or so bright, that floats overflow.
std::size_t drop_infinite_samples(SlotRadiance& radiance);

}  // namespace glowworm
