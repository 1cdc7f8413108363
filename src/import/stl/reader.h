// Meshes from STL files.
#pragma once
#include <string>
#include <string_view>

#include "core/memory_budget.h"
#include "scene/geometry.h"

namespace glowworm {

/// Reads an STL file (3D Systems, "StereoLithography Interface Specification", 1989), binary or ASCII: a triangle for
/// each facet, with vertices of its own, whose normals are the facet's. Memory stays in proportion to the file's size.
/// @param file for messages
/// @param budget that the mesh is reserved in while it is read
/// Throws Error with file, and line where it is ASCII, and MemoryError.
Geometry parse_stl(std::string_view bytes, const std::string& file, MemoryBudget& budget);

}  // namespace glowworm
