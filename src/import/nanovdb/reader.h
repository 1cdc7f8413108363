// Reads grids of NanoVDB files (.nvdb).
#pragma once
#include <string>

#include "import/voxel_grid.h"

namespace glowworm {

/// Reads a grid as read_voxel_grid(): of format version 32 (Museth, "NanoVDB", SIGGRAPH 2021 talks), uncompressed or
/// compressed by zlib.
VoxelGrid read_nanovdb(const std::string& path, const std::string& grid, MemoryBudget& budget);
/// Whether a file has a grid of this name.
bool has_nanovdb_grid(const std::string& path, const std::string& grid, MemoryBudget& budget);

}  // namespace glowworm
