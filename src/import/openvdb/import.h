// Imports grids of OpenVDB files (.vdb), in a separate process.
#pragma once
#include <string>

#include "core/child_process.h"
#include "import/voxel_grid.h"

namespace glowworm {

/// Reads a grid as read_voxel_grid(), by the program glowworm-openvdb: of floats, halves or doubles. Throws Error with
/// the file and the cause, too, if that program crashes, reaches a limit or returns invalid data; Cancelled as
/// check_cancelled() does.
/// @param limits zeros stand for defaults (limits_for()) @param program path; empty: beside this program
VoxelGrid read_openvdb(const std::string& path, const std::string& grid, MemoryBudget& budget,
                       const ChildLimits& limits = {}, const std::string& program = {});
/// Whether a file has a grid of this name.
bool has_openvdb_grid(const std::string& path, const std::string& grid, MemoryBudget& budget);

}  // namespace glowworm
