// What the program glowworm-openvdb passes to its parent process, and its encoding in bytes.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "import/voxel_grid.h"

namespace glowworm {

/// The answer to a request for a grid.
struct OpenVdbAnswer {
  std::vector<std::string> names;  ///< of all grids of the file
  bool found = false;              ///< whether the grid is one of them
  VoxelGrid grid;                  ///< empty unless found
};

/// Encodes an answer and passes its bytes to `write`, piece by piece.
void write_openvdb_answer(const OpenVdbAnswer& answer, const std::function<void(const void*, std::size_t)>& write);

/// Decodes an answer. Any bytes give either a valid answer or an Error: a grid that is found has voxels, within 2^24 of
/// its origin, and as many values, and its map is finite. Memory is proportional to the number of bytes.
/// @param file for messages
OpenVdbAnswer read_openvdb_answer(std::string_view bytes, const std::string& file);

}  // namespace glowworm
