// Where the samples of a cell of a point grid lie.
#pragma once
#include <cstdint>

#include "gather/point_pass.h"

namespace glowworm {

/// The place of a sample of a cell, the same for every seed. In grids with surface numbers, the samples of a cell amid
/// others of its surface are spread over half of the way to these, so that the edges of shadows have no steps. A cell
/// at a rim, at a bend or beside one without a point keeps its point: half a cell away may be within a wall.
Vec3 place_in_cell(const PointGrid& grid, std::size_t cell, std::uint32_t sample);

}  // namespace glowworm
