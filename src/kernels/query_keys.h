// Sort keys of query points: the cell of a grid, the axis of the normal, and the position on the surface. A surface
// perpendicular to an axis is close to a plane of the other two axes, so a Hilbert curve through that plane orders its
// points as well as one through space, with a third fewer bits. A few slabs along the axis separate parallel surfaces.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Number of times a key halves a cell along each axis.
inline constexpr int kKeyLevels = 6;
/// Bits of a key, from the lowest: position on the curve, slab, group, cell. At most 2^14 - 1 cells.
inline constexpr int kKeyCurveBits = 2 * kKeyLevels;
inline constexpr int kKeySlabBits = 3;
inline constexpr int kKeyGroupShift = kKeyCurveBits + kKeySlabBits;
inline constexpr int kKeyCellShift = kKeyGroupShift + 3;
/// Groups 0 to 5 are Lambertian points, by the axis closest to their normal (2 axis + 1 if it points in the negative
/// direction); the last group is for all other points.
inline constexpr std::uint32_t kKeyGroups = 7;
inline constexpr std::uint32_t kNotLambertianGroup = 6;
/// The key of points whose position or normal is not finite.
inline constexpr std::uint32_t kNoKey = 0xffffffffu;

/// A grid of equal cubes. Points outside belong to the cells at the border.
struct KeyGrid {
  float origin[3] = {0, 0, 0};  ///< metres
  float cells_per_metre = 0;
  std::uint32_t cells[3] = {1, 1, 1};  ///< number along each axis
};

/// Writes a key for each of n points. Runs on the instruction set of set_simd().
/// @param position, normal  x, y, z of each point
/// @param bsdf  as in QueryPoints::bsdf: all bits set for Lambertian points
void query_keys(const KeyGrid& grid, const float* position, const float* normal, const std::uint32_t* bsdf,
                std::size_t n, std::uint32_t* keys);

}  // namespace glowworm
