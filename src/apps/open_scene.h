// From a name on the command line to a scene.
#pragma once
#include <memory>
#include <string>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Loads a scene file or a built-in scene. Throws Error that names the file, also for what is wrong with the scene as a
/// whole.
std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options);

}  // namespace glowworm
