// Imports scene formats by Assimp, in a separate process.
#pragma once
#include <string>
#include <string_view>

#include "core/child_process.h"
#include "core/coordinate_origin.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a file by the program glowworm-assimp. Throws Error with the file, its format and the cause if that program
/// crashes, reaches a limit or returns invalid data; Cancelled as check_cancelled() does; otherwise as load_scene().
/// @param limits zeros stand for defaults (limits_for())
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_assimp(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin,
                             const ChildLimits& limits = {});

/// Builds the scene from the program's output. Throws Error if that is invalid, and MemoryError.
SceneDescription build_assimp_scene(std::string_view bytes, const std::string& path, const ImportOptions& options,
                                    CoordinateOrigin& origin);

/// Whether files with this extension (".fbx"; lower case, with the dot) are read by Assimp: formats that it reads well.
bool assimp_reads(const std::string& extension);

}  // namespace glowworm
