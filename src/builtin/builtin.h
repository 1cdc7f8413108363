// The scenes that come with the program.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// Names without "builtin:", in order.
std::vector<std::string> builtin_scene_names();

/// A built-in scene. Throws Error, listing the names there are, for another name.
SceneDescription builtin_scene(const std::string& name);

}  // namespace glowworm
