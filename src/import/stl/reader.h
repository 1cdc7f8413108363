// Meshes from STL files.
#pragma once
#include <string>
#include <string_view>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "scene/geometry.h"

namespace glowworm {

/// Reads an STL file (3D Systems, "StereoLithography Interface Specification", 1989), binary or ASCII. Each facet
/// becomes a triangle with its own vertices and the facet's normal. Memory is proportional to the file's size.
/// @param file for messages
/// @param budget limits the memory of the mesh while reading
/// Throws Error with file, and line if it is ASCII, and MemoryError.
/// @param origin is subtracted from all positions; read_near() finds it
Geometry parse_stl(std::string_view bytes, const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin);

}  // namespace glowworm
