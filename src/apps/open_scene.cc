#include "apps/open_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "builtin/builtin.h"
#include "core/input_file.h"
#include "core/log.h"
#include "import/ies/luminaire.h"
#include "scene/light_rig.h"
#include "session/command_text.h"
#include "settings/settings.h"

namespace glowworm {

std::uint64_t LightOptions::memory_bytes() const {
  return table.settings.memory_bytes > 0 ? table.settings.memory_bytes : default_memory_bytes();
}

void LightOptions::apply() const {
  report.apply();
  set_thread_count(table.settings);
}

void add_method_options(CLI::App& command, Command which, LightOptions& options) {
  add_scene_options(command, options.changes);
  for (const char* group : {"Method", "Effort", "Machine"}) add_table_options(command, group, which, options.table);
}

void add_scene_argument(CLI::App& command, std::string& scene) {
  command
      .add_option("scene", scene,
                  fmt::format("A scene file (.pbrt .gltf .glb .obj .ply .rad .fbx ...), or one of builtin:{}",
                              fmt::join(builtin_scene_names(), ", builtin:")))
      ->required()
      ->option_text("SCENE");
}

void add_scene_options(CLI::App& command, SceneOptions& o) {
  for (const SceneOption& option : scene_options()) {
    CLI::Option* added = command.add_option_function<std::vector<std::string>>(
        option.name,
        [&o, &option](const std::vector<std::string>& texts) {
          for (const std::string& text : texts) {
            read_command_line([&] { option.read(o.changes, text); });
            o.given.insert(o.given.end(), {option.name, text});
          }
        },
        option.meaning);
    added->allow_extra_args(false)->option_text(option.values)->group("Scene");
    if (!option.repeats) added->take_last();
  }
}

void take_luminaires(std::vector<std::string>& lights, SceneChanges& changes) {
  const auto edits = std::stable_partition(lights.begin(), lights.end(), is_luminaire_text);
  changes.luminaires.assign(lights.begin(), edits);
  lights.erase(lights.begin(), edits);
  for (const std::string& text : changes.luminaires) luminaire_of_text(text);
}

std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options,
                                        const SceneChanges& changes, OutputFiles* files) {
  if (!changes.sky.empty() && (!changes.environment_file.empty() || changes.uniform_radiance))
    warn("--environment has no effect with --sky");
  const InputRecord record;
  SceneDescription description;
  ImportOptions at_moment = options;
  at_moment.moment = changes.moment;
  const auto load = [&] { description = load_scene(path, at_moment); };
  is_builtin(path) ? read_command_line(load) : load();
  change_scene(description, changes, options.budget);
  if (files)
    for (const std::string& name : record.names()) files->add_input("the scene's file", name);
  try {
    return std::make_shared<const Scene>(std::move(description));
  } catch (const Error& error) {
    throw Error(FilePlace{path}, error.what());
  }
}

std::shared_ptr<const Scene> open_measured_scene(LightOptions& o, const std::string& path, OutputFiles& files) {
  read_command_line([&] {
    take_luminaires(o.lights, o.changes.changes);
    for (const std::string& light : o.lights) parse_light_edit(light);
  });
  ImportOptions options;
  options.budget = loading_budget(o.memory_bytes());
  o.changes.changes.studio_light = false;
  std::shared_ptr<const Scene> scene = open_scene(path, options, o.changes.changes, &files);
  std::string camera;
  read_command_line([&] { scene = scene_of_view(scene, o.lights, "", camera); });
  tell_notes(*scene, path);
  return scene;
}

void tell_notes(const Scene& scene, const std::string& path) {
  for (const std::string& note : scene.notes()) {
    const bool is_wrong = note.starts_with("texture '") && (note.find("' is magenta: ") != std::string::npos ||
                                                            note.find("' is left out: ") != std::string::npos);
    // Notes of formats with lines name the file themselves.
    const std::string told = note.find(path) == std::string::npos ? fmt::format("{}: {}", path, note) : note;
    is_wrong ? warn(told) : inform("note: " + told);
  }
}

}  // namespace glowworm
