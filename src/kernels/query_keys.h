// Sort keys of query points: which cell of a grid they lie in, which way they face, and where on their surface they
// lie. A surface that faces along an axis is a sheet over the plane of the other two, so a Hilbert curve through that
// plane orders it as well as one through space would, with a third fewer bits; sheets that lie one behind the other are
// told apart by a few slabs along the axis.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Halvings of a cell along each axis that a key tells apart.
inline constexpr int kKeyLevels = 6;
/// Bits of a key, from the lowest: place on the curve, slab, group, cell. No more than 2^14 - 1 cells.
inline constexpr int kKeyCurveBits = 2 * kKeyLevels;
inline constexpr int kKeySlabBits = 3;
inline constexpr int kKeyGroupShift = kKeyCurveBits + kKeySlabBits;
inline constexpr int kKeyCellShift = kKeyGroupShift + 3;
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
