#include "apps/open_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <utility>

#include "apps/table_options.h"
#include "builtin/builtin.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/text.h"
#include "import/ies/luminaire.h"
#include "import/sky_text.h"

namespace glowworm {

namespace {

/// Parses a number between two bounds. Throws Error that names the option.
float parse_number(const char* name, const std::string& text, float least, float most) {
  const std::vector<float> value = numbers_of<float>(text);
  if (value.size() != 1 || value[0] < least || value[0] > most)
    throw Error(fmt::format("{} '{}' is not a number from {:g} to {:g}", name, text, least, most));
  return value[0];
}

}  // namespace

void add_scene_argument(CLI::App& command, std::string& scene) {
  command
      .add_option("scene", scene,
                  fmt::format("A scene file (.pbrt .gltf .glb .obj .ply .fbx ...), or one of builtin:{}",
                              fmt::join(builtin_scene_names(), ", builtin:")))
      ->required()
      ->option_text("SCENE");
}

void add_scene_options(CLI::App& command, SceneOptions& o) {
  const auto add = [&](const char* name, const char* values, const char* meaning,
                       const std::function<void(const std::string&)>& read) {
    command
        .add_option_function<std::string>(
            name,
            [&o, name, read](const std::string& text) {
              read_command_line([&] { read(text); });
              o.given.insert(o.given.end(), {name, text});
            },
            meaning)
        ->take_last()
        ->option_text(values)
        ->group("Scene");
  };
  SceneChanges& c = o.changes;
  add("--environment", "FILE|R,G,B",
      "Replace the scene's environment light: a lat-long image (.exr, .hdr), a square "
      "equal-area image, or a radiance (W sr^-1 m^-2)",
      [&c](const std::string& text) { parse_environment(text, c); });
  add("--sky", "cie:TYPE,...|perez:...|epw:FILE,...",
      "A sky in place of the environment: cie:TYPE[,ALTITUDE,AZIMUTH[,LUX[,GROUND]]] is a CIE general sky (1-15) or "
      "overcast (16); perez:DIRECT,DIFFUSE,MONTH,DAY,HOUR,LATITUDE,LONGITUDE,ZONE[,GROUND] has W m^-2; "
      "epw:FILE,MONTH,DAY,HOUR[,GROUND] an hour (1-24) of a weather file; -z is north",
      [&c](const std::string& text) {
        check_sky(text);
        c.sky = text;
      });
  add("--environment-turn", "DEGREES [0]", "Rotate the environment to the left",
      [&c](const std::string& text) { c.environment_turn = parse_number("--environment-turn", text, -3600, 3600); });
  add("--environment-scale", "F [1]", "Multiply the environment's radiance",
      [&c](const std::string& text) { c.environment_scale = parse_number("--environment-scale", text, 0, 1e9f); });
  add("--up", "y|z [y]", "Axis of the file that points up; places and directions of other options have it, too",
      [&c](const std::string& text) {
        if (text != "y" && text != "z") throw Error(fmt::format("--up '{}' is neither y nor z", text));
        c.z_up = text == "z";
      });
  add("--scale", "M [1]", "Metres per unit of the file; lights keep their power",
      [&c](const std::string& text) { c.metres_per_unit = parse_number("--scale", text, 1e-9f, 1e9f); });
  add("--fov", "DEGREES", "Angle of view along the picture's shorter side",
      [&c](const std::string& text) { c.field_of_view = parse_number("--fov", text, 0.01f, 175); });
  add("--look-at", "X,Y,Z,X,Y,Z", "Place the scene's first camera: eye and target (m)",
      [&c](const std::string& text) { c.look_at = parse_look_at(text); });
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
  const auto load = [&] { description = load_scene(path, options); };
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
