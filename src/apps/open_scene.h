// From a name on the command line to a scene.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/output_files.h"
#include "import/import.h"
#include "import/scene_changes.h"
#include "scene/scene.h"

namespace CLI {
class App;
}

namespace glowworm {

/// What a command line asks of the scene beside its name.
struct SceneOptions {
  SceneChanges changes;
  std::vector<std::string> given;  ///< the options and their values, as another command line has them
};

/// Adds the options of scenes to a command: --environment, --up, --scale, --fov, --look-at, ...
void add_scene_options(CLI::App& command, SceneOptions& options);

/// Loads a scene file or a built-in scene and makes the changes. Throws Error that names the file, also for what is
/// wrong with the scene as a whole.
/// @param files what the command writes, where it writes anything: gets all files that the scene consists of as inputs,
/// and throws CommandLineError where it would write over one of them
std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options,
                                        const SceneChanges& changes, OutputFiles* files = nullptr);

/// Tells the notes of a scene; what is wrong with its files is a warning.
void tell_notes(const Scene& scene, const std::string& path);

}  // namespace glowworm
