// Sort keys of query points: which cell of a grid they lie in, which way they face, and where on a Hilbert curve
// through the cell they lie.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Halvings of a cell along each axis that a key tells apart.
inline constexpr int kKeyLevels = 5;
/// Bits of a key: cell, then group, then place on the curve. No more than 2^14 - 1 cells.
inline constexpr int kKeyCurveBits = 3 * kKeyLevels;
inline constexpr int kKeyCellShift = kKeyCurveBits + 3;
/// Groups 0 to 5 are Lambertian points by the axis their normal is nearest to (2 axis + 1 where it points down the
/// axis); the last is for all others.
inline constexpr std::uint32_t kKeyGroups = 7;
inline constexpr std::uint32_t kNotLambertianGroup = 6;
/// The key of points whose position or normal is not finite.
inline constexpr std::uint32_t kNoKey = 0xffffffffu;

/// Cubes of equal size. Points outside count to the cells at the border.
struct KeyGrid {
  float origin[3] = {0, 0, 0};  ///< metres
  float cells_per_metre = 0;
  std::uint32_t cells[3] = {1, 1, 1};  ///< along each axis
};

/// Writes a key for each of n points (runs on the instruction set of set_simd()).
/// @param position, normal  x, y, z of each point
/// @param bsdf  as QueryPoints::bsdf: all bits set for Lambertian points
void query_keys(const KeyGrid& grid, const float* position, const float* normal, const std::uint32_t* bsdf,
                std::size_t n, std::uint32_t* keys);

}  // namespace glowworm
