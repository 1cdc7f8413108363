// OBJ with its MTL, and the formats that only Assimp reads.
#pragma once
#include <string>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a file through Assimp. OBJ files are looked through first, for errors with their line. Throws Error as
/// load_scene() does.
SceneDescription load_assimp(const std::string& path, const ImportOptions& options);

/// Whether Assimp has a reader for files of that extension (".obj"; lower case, with the dot).
bool assimp_reads(const std::string& extension);

}  // namespace glowworm
