// The warp of the guide of gather rays (gather/gather_guide.h), for one stratum of many gather points.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/diffuse_rays.h"

namespace glowworm {

/// In place of the index of a table: the point is not warped.
inline constexpr std::uint32_t kNoTable = 0xffffffff;

/// A density over the unit square, bilinear between the corners of the cells of a grid.
struct GuideTable {
  static constexpr std::size_t kSide = 8;  ///< cells along a side
  float density[kSide + 1][kSide + 1];     ///< at the corners, row by row; the mean over the square is 1
  float columns[kSide + 1][kSide + 1];     ///< integral along a row of corners up to each corner, in cells
  float rows[kSide + 1];                   ///< integral of columns[][kSide] up to each row, in cells
};

/// Warps points of the square so that they have the density of a table, and sets their weights to 1 over it. Points
/// without a table, and their weights, stay as they are. Arrays of `count` elements, index i one point.
/// @param table indices into `tables`, or kNoTable
void warp_by_guide(const GuideTable* tables, const std::uint32_t* table, std::size_t count, const DiffuseSquare& square,
                   float* weight);

}  // namespace glowworm
