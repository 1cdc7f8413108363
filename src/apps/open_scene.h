// From a name on the command line to a scene.
#pragma once
#include <memory>
#include <string>

#include "apps/output_files.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Loads a scene file or a built-in scene. Throws Error that names the file, also for what is wrong with the scene as a
/// whole.
/// @param files what the command writes, where it writes anything: gets all files that the scene consists of as inputs,
/// and throws CommandLineError where it would write over one of them
std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options,
                                        OutputFiles* files = nullptr);

/// Tells the notes of a scene; what is wrong with its files is a warning.
void tell_notes(const Scene& scene, const std::string& path);

}  // namespace glowworm
