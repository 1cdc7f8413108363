// Where rays begin that leave a surface.
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/vec.h"

namespace glowworm {

/// Coordinates nearer to zero than this are moved by kOffsetFixed times the normal's, others by kOffsetPlaces of their
/// last places: those scale with the rounding error of a coordinate, and near zero would be too little.
inline constexpr float kOffsetNearZero = 1.0f / 32, kOffsetFixed = 1.0f / 65536, kOffsetPlaces = 256;

/// An origin for rays that leave a surface at p on the side of n: far enough that they don't hit it again, by steps in
/// the last bits of p (Waechter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", 2019).
inline Vec3 offset_origin(Vec3 p, Vec3 n) {
  const auto moved = [](float at, float along) {
    if (std::abs(at) < kOffsetNearZero) return at + kOffsetFixed * along;
    const auto steps = static_cast<std::int32_t>(kOffsetPlaces * along);
    return std::bit_cast<float>(std::bit_cast<std::int32_t>(at) + (at < 0 ? -steps : steps));
  };
  return {moved(p.x, n.x), moved(p.y, n.y), moved(p.z, n.z)};
}

}  // namespace glowworm
