#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/commands.h"
#include "apps/luminaire_info.h"
#include "apps/open_scene.h"
#include "apps/table_options.h"
#include "core/log.h"
#include "core/text.h"
#include "import/ies/luminaire.h"
#include "scene/light_rig.h"
#include "scene/scene.h"
#include "settings/effects.h"
#include "settings/steep_maps.h"

namespace glowworm {

namespace {

struct NamedPower {
  std::string name;
  RGB power;  ///< W
};

/// The lights by the names that --light takes, with their power.
std::vector<NamedPower> light_powers(const std::shared_ptr<const Scene>& scene) {
  const std::vector<std::uint32_t>& triangles = scene->emissive_triangles();
  std::map<std::uint32_t, RGB> of_emission;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    of_emission[scene->geometry().emission[triangles[i]]] += scene->source_powers()[i];
  const auto power = [&](const RigLight& light) {
    if (light.kind == RigLightKind::area) return of_emission[light.index];
    if (light.kind == RigLightKind::environment) return scene->source_powers().back();
    return scene->source_powers()[triangles.size() + light.index];
  };
  const LightRig rig(scene);
  std::vector<NamedPower> lights;
  for (const RigLight& light : rig.lights()) lights.push_back({light.name, power(light)});
  return lights;
}

/// "(x, y, z)".
std::string place_text(Vec3d v) {
  return fmt::format("({}, {}, {})", coordinate_text(v.x), coordinate_text(v.y), coordinate_text(v.z));
}

template <typename... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  write_output(fmt::format(format, std::forward<Values>(values)...));
}

/// A place of the scene's tables as the user's file has it.
Vec3d file_place(const Scene& scene, Vec3 place) { return scene.to_file_axes(scene.outside(place)); }

/// The least and the greatest corner of the scene's box in the coordinates and axes of the user's file.
std::array<Vec3d, 2> file_corners(const Scene& scene) {
  Box3 box;
  for (const Vec3 corner : {scene.bounds().min, scene.bounds().max}) box.grow(scene.to_file_axes(corner));
  return {file_place(scene, scene.from_file_axes(box.min)), file_place(scene, scene.from_file_axes(box.max))};
}

/// What names a medium: "around the scene", or materials.
std::string medium_places(const Scene& scene, std::uint32_t medium) {
  std::vector<std::string> places;
  if (scene.ambient_medium() == medium) places.emplace_back("around the scene");
  for (const Material& m : scene.materials()) {
    if (m.inside == medium) places.push_back(fmt::format("inside of {}", m.name));
    if (m.outside == medium) places.push_back(fmt::format("outside of {}", m.name));
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places.empty() ? "nowhere" : fmt::format("{}", fmt::join(places, ", "));
}

std::string medium_kind(const Medium& m) {
  if (!m.grid) return m.bounds ? "homogeneous, in a box" : "homogeneous";
  const auto& [x, y, z] = m.grid->values().size;
  return fmt::format("grid of {} x {} x {}", x, y, z);
}

/// The largest coefficients of a medium, m^-1.
std::array<RGB, 2> greatest_coefficients(const Medium& m) {
  const MediumGrid::Point factors = m.grid ? m.grid->greatest() : MediumGrid::Point();
  return {m.sigma_a * factors.sigma_a, m.sigma_s * factors.sigma_s};
}

std::vector<std::string> all_notes(const Scene& scene) {
  std::vector<std::string> notes = effect_notes(scene, RenderSettings{});
  for (const std::vector<std::string>& more : {steep_map_notes(scene), scene.notes()})
    notes.insert(notes.end(), more.begin(), more.end());
  return notes;
}

void print_media(const Scene& scene) {
  if (scene.media().empty()) return;
  say("media      {}\n", scene.media().size());
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    const Medium& m = scene.media()[i];
    const auto [a, s] = greatest_coefficients(m);
    say("  {:<32} {}, {}\n", m.name, medium_kind(m), medium_places(scene, static_cast<std::uint32_t>(i)));
    say("    absorbs {:.4g} {:.4g} {:.4g}, scatters {:.4g} {:.4g} {:.4g} m^-1, g {:.3g}, mean free path {:.4g} m\n",
        a.r, a.g, a.b, s.r, s.g, s.b, m.g, 1 / greatest_extinction(m));
  }
}

void print_scene(const std::shared_ptr<const Scene>& shared) {
  const Scene& scene = *shared;
  const Geometry& g = scene.geometry();
  const auto [least, greatest] = file_corners(scene);
  say("scene      {}\n", scene.name());
  say("triangles  {}\n", g.triangle_count());
  if (!g.instances.empty()) say("instances  {}, of {} meshes\n", g.instances.size(), g.meshes.size());
  say("vertices   {}\n", g.positions.size());
  say("bounds     {} to {} m\n", place_text(least), place_text(greatest));
  if (scene.film().width > 0) say("picture    {}x{} pixels\n", scene.film().width, scene.film().height);
  std::map<std::uint32_t, std::size_t> uses;
  g.for_each_material([&](std::uint32_t m, std::size_t triangles) { uses[m] += triangles; });
  say("materials  {}\n", scene.materials().size());
  for (std::size_t i = 0; i < scene.materials().size(); ++i) {
    const Material& m = scene.materials()[i];
    say("  {:<32} {:<20} {} triangles\n", m.name, name(m.kind), uses[static_cast<std::uint32_t>(i)]);
  }
  print_media(scene);
  say("textures   {}\n", scene.textures().size());
  const std::vector<NamedPower> lights = light_powers(shared);
  say("lights     {}, with {} emissive triangles\n", lights.size(), scene.emissive_triangles().size());
  for (const auto& [name, p] : lights)
    say("  {:<32} {:.4g} W (RGB {:.4g} {:.4g} {:.4g})\n", name, luminance(p), p.r, p.g, p.b);
  say("power      {:.4g} W in total (luminance)\n", scene.light_power().total());
  say("cameras    {}\n", scene.cameras().size());
  for (const Camera& c : scene.cameras())
    say("  {:<32} at {}\n", c.name.empty() ? "(unnamed)" : c.name,
        place_text(file_place(scene, c.to_world.translation)));
  for (const std::string& note : all_notes(scene)) say("note: {}\n", note);
}

nlohmann::json numbers(Vec3d v) { return {v.x, v.y, v.z}; }
nlohmann::json numbers(RGB c) { return {c.r, c.g, c.b}; }

void print_json(const std::shared_ptr<const Scene>& shared) {
  const Scene& scene = *shared;
  using nlohmann::json;
  const Geometry& g = scene.geometry();
  json out = {{"name", scene.name()},
              {"triangles", g.triangle_count()},
              {"instances", g.instances.size()},
              {"vertices", g.positions.size()},
              {"bounds_m", {numbers(file_corners(scene)[0]), numbers(file_corners(scene)[1])}},
              {"origin_m", numbers(file_place(scene, {0, 0, 0}))},
              {"picture", {{"width", scene.film().width}, {"height", scene.film().height}}},
              {"textures", scene.textures().size()},
              {"power_w", scene.light_power().total()}};
  std::vector<std::size_t> uses(scene.materials().size());
  g.for_each_material([&](std::uint32_t m, std::size_t triangles) { uses[m] += triangles; });
  for (const char* list : {"objects", "materials", "media", "lights", "cameras", "notes"}) out[list] = json::array();
  for (const ObjectStart& object : g.objects) out["objects"].push_back(object.name);
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const Material& m = scene.materials()[i];
    out["materials"].push_back({{"name", m.name}, {"kind", name(m.kind)}, {"triangles", uses[i]}});
  }
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    const Medium& m = scene.media()[i];
    const auto [a, s] = greatest_coefficients(m);
    out["media"].push_back({{"name", m.name},
                            {"kind", medium_kind(m)},
                            {"places", medium_places(scene, static_cast<std::uint32_t>(i))},
                            {"sigma_a_per_m", numbers(a)},
                            {"sigma_s_per_m", numbers(s)},
                            {"g", m.g}});
  }
  out["emissive_triangles"] = scene.emissive_triangles().size();
  for (const auto& [name, power] : light_powers(shared))
    out["lights"].push_back({{"name", name}, {"power_rgb_w", numbers(power)}});
  for (const Camera& c : scene.cameras())
    out["cameras"].push_back({{"name", c.name}, {"position_m", numbers(file_place(scene, c.to_world.translation))}});
  out["notes"] = all_notes(scene);
  fmt::print("{}\n", out.dump(2, ' ', true, json::error_handler_t::replace));
}

}  // namespace

void add_info_command(CLI::App& program, const std::string& command_line) {
  auto luminaire = std::make_shared<LuminaireInfoOptions>();
  luminaire->command_line = command_line;
  auto path = std::make_shared<std::string>();
  auto as_json = std::make_shared<bool>(false);
  auto changes = std::make_shared<SceneOptions>();
  CLI::App* c = program.add_subcommand(
      "info", "Prints the contents of a scene and its unsupported features, or the key figures of a luminaire.");
  add_scene_argument(*c, *path);
  c->add_flag("--json", *as_json, "Print a JSON object");
  add_text(*c, "Luminaires", "--lamps", luminaire->lamps, "NAME|NUMBER [1]", "The set of lamps of a .ldt file");
  add_text(*c, "Luminaires", "-o,--output", luminaire->output, "FILE.png", "Draw the polar curve");
  add_scene_options(*c, *changes);
  c->footer(R"(
Lengths are metres, power is W. Lines that begin with 'note:' name features of the
file that are not supported or had to be guessed.

A luminaire is a photometric file, .ies or .ldt: its flux, peak, symmetry and opening.

Examples:
  glowworm info builtin:atrium
  glowworm info lamp.ies -o curve.png)");
  c->callback([path, as_json, changes, luminaire] {
    if (is_photometric_file(*path)) {
      luminaire->path = *path;
      luminaire->as_json = *as_json;
      print_luminaire(*luminaire);
      return;
    }
    if (!luminaire->lamps.empty() || !luminaire->output.empty())
      throw CommandLineError("--lamps and -o are for photometric files (.ies, .ldt)", "Leave them out.");
    ImportOptions options;
    options.lazy_textures = true;
    const auto scene = open_scene(*path, options, changes->changes);
    *as_json ? print_json(scene) : print_scene(scene);
  });
}

}  // namespace glowworm
