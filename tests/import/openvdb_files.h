// OpenVDB files, as other programs write them.
#pragma once
#include <string>

namespace glowworm {

/// Grids that a file may have.
enum class VdbGrid { floats, halves, doubles, vectors, level_set, empty, frustum, hot };

/// Writes a file with a grid of that kind, and another, "temperature", of 1000 at its voxel (2, 0, -1). Unless the kind
/// says otherwise, the grid is a fog volume of the values 1, 2 and 3 at (0, 0, 0), (1, 0, 0) and (9, -1, 2); its voxels
/// are half a metre wide, and the middle of voxel (0, 0, 0) is at (10, 20, 30). A hot grid is 1 in the voxels from 0 to
/// 7 of each axis, where the temperature is 4000; both have its map.
void write_vdb(const std::string& path, const std::string& name, VdbGrid kind);

}  // namespace glowworm
