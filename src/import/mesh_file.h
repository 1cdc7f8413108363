// Loads files with a mesh and no materials as scenes.
#pragma once
#include <string>

#include "core/coordinate_origin.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a PLY file (import/ply/reader.h) as a scene. The surface is grey, or has the texture that the file names.
/// Throws Error as load_scene() does.
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_ply(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

/// Reads an STL file (import/stl/reader.h) as a scene with grey, flat facets. Throws Error as load_scene() does.
/// @param origin as for load_ply()
SceneDescription load_stl(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

}  // namespace glowworm
