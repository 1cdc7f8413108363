// Opens scenes named on the command line.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/output_files.h"
#include "apps/table_options.h"
#include "import/import.h"
#include "import/scene_changes.h"
#include "scene/scene.h"

namespace CLI {
class App;
}

namespace glowworm {

/// Options of a scene on the command line.
struct SceneOptions {
  SceneChanges changes;
  std::vector<std::string> given;  ///< the options with their values, in a form to repeat on another command line
};

/// What all commands have that compute light in a scene.
struct LightOptions {
  std::string scene, command_line;
  std::vector<std::string> lights;  ///< values of --light
  ReportOptions report;
  TableOptions table;
  SceneOptions changes;

  /// Memory that the scene may take, and the work beside it; bytes.
  std::uint64_t memory_bytes() const;
  /// Sets the level of the log and the number of threads.
  void apply() const;
};

/// Adds the options of the scene and of the groups Method, Effort and Machine.
void add_method_options(CLI::App& command, Command which, LightOptions& options);

/// Adds the scene as the first argument of a command.
void add_scene_argument(CLI::App& command, std::string& scene);

/// Adds the scene options to a command: --environment, --up, --scale, --fov, --look-at, ...
void add_scene_options(CLI::App& command, SceneOptions& options);

/// Moves the values of --light that add a luminaire to the changes. Throws Error if a file is missing or invalid.
void take_luminaires(std::vector<std::string>& lights, SceneChanges& changes);

/// Loads a scene file or a built-in scene and applies the changes. Throws Error, which names the file, also if the
/// scene as a whole is invalid.
/// @param files the outputs of the command, if it writes any: gets all files of the scene as inputs. Throws
/// CommandLineError if an output would overwrite one of them.
std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options,
                                        const SceneChanges& changes, OutputFiles* files = nullptr);

/// Opens a scene with its changes and lights, without the studio light that a scene without lights has, and prints its
/// notes. Throws CommandLineError for invalid values of --light.
/// @param path options.scene, or the same scene in another state
std::shared_ptr<const Scene> open_measured_scene(LightOptions& options, const std::string& path, OutputFiles& files);

/// Prints the notes of a scene. Problems of its files are warnings.
void tell_notes(const Scene& scene, const std::string& path);

}  // namespace glowworm
