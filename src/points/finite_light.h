// Removes light that is not finite before it reaches the film.
#pragma once
#include <cstddef>

#include "core/radiance_range.h"
#include "points/gather_points.h"

namespace glowworm {

/// Sets samples to black if a number in their light is NaN, infinite or beyond kMaxRadiance; returns how many. They
/// occur where a light is so near to a surface, or so bright, that floats overflow.
std::size_t drop_infinite_samples(SlotRadiance& radiance);

}  // namespace glowworm
