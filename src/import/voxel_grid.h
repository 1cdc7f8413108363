// Grids of files: dense boxes of voxels.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/memory_budget.h"
#include "core/transform_double.h"
#include "scene/medium.h"

namespace glowworm {

/// A dense box of a sparse grid, with a border of background around its active values.
struct VoxelGrid {
  std::array<int, 3> first{}, size{};  ///< in the grid's index space
  std::vector<float> values;           ///< x fastest, then y
  TransformDouble to_world;            ///< from index space

  /// Interpolates linearly between values; 0 outside. @param at in index space
  float at(Vec3d at) const;
};

/// Reads a grid of floats of an OpenVDB file (.vdb), or else of a NanoVDB file. Throws Error, with the names of the
/// file's grids, if it has none of this name, and for other types of values, level sets, and damaged files; MemoryError
/// if the box exceeds the budget.
VoxelGrid read_voxel_grid(const std::string& path, const std::string& grid, MemoryBudget& budget);
/// Whether a file has a grid of this name.
bool has_voxel_grid(const std::string& path, const std::string& grid, MemoryBudget& budget);

/// Gives a medium the box of a grid's cells as its bounds: its own coordinates count voxels.
/// @param to_scene from index space; it can be inverted
void place_medium(const VoxelGrid& grid, const TransformDouble& to_scene, Medium& medium);

}  // namespace glowworm
