#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands.h"
#include "apps/open_scene.h"
#include "apps/table_options.h"
#include "apps/view_options.h"
#include "core/error.h"
#include "kernels/simd.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

int run_view(ViewOptions& o) {
  set_thread_count(o.table.settings);
  read_command_line([&] { set_simd(o.simd); });
  o.color.load();
  const Script script = o.script.empty() ? Script() : read_script(o.script);
  if (!o.out.empty()) return run_headless_view(o, script);
  return run_window_view(o, script);
}

void add_start_options(CLI::App& c, ViewOptions& o) {
  add_choice(c, "--mode", o.mode, view_mode_names(), "What the pixels show")->group("View");
  add_choice(c, "--part", o.part, light_part_names(), "Which light is shown")->group("View");
  c.add_flag("--no-reuse", o.no_reuse, "Do not reuse earlier frames")->group("View");
  add_tone_options(c, "View", "Tone curve", o.tone, o.color);
  add_exposure_option(c, "View", o.exposure);
}

void add_session_options(CLI::App& c, ViewOptions& o) {
  add_text(c, "Session", "--script", o.script, "FILE.json", "Play this JSON file; docs/guide.md has its keys");
  add_text(c, "Session", "--out", o.out, "FOLDER", "Write every frame to this folder instead of opening a window");
  add_number(c, "Session", "--frames", o.frames, 1, 1'000'000'000, "N [the script's]",
             "Stop after this number of frames");
  add_choice(c, "--format", o.format, {"png", "exr"}, "Format of the frames in --out")->group("Session");
  add_number(c, "Session", "--fps", o.fps, 0.1, 1000, "N [15]", "Frames a second to hold while the view moves");
  c.add_flag("--adapt", o.adapt, "Also with --out: hold --fps with fewer pixels, rays and photons while the view moves")
      ->group("Session");
  add_simd_option(c, "Session", o.simd);
}

constexpr const char* kViewFooter = R"(
In the window: drag to orbit, with Shift or the middle button to pan, with the right button
to look around, wheel to move nearer, W A S D Q E to fly, double-click to focus, space to play
the scene's animation, F1 for help, F12 for a screenshot; a scene file dropped on it is opened.

Examples:
  glowworm view builtin:atrium
  glowworm view room.glb --mode photons
  glowworm view builtin:cornell --frames 60 --script moves.json --out frames/)";

}  // namespace

std::shared_ptr<const Scene> open_view_scene(const ViewOptions& o, const std::string& path, std::uint64_t memory_bytes,
                                             SceneMoments& moments, OutputFiles* files) {
  SceneChanges changes = o.changes.changes;
  if (path != o.scene) {
    changes.look_at.reset();
    changes.moment = {};
  }
  ImportOptions options;
  options.budget = loading_budget(memory_bytes);
  if (has_moments(path)) {
    options.textures = texture_library(options.budget);
    options.gltf = gltf_reader();
    options.motion = std::make_shared<SceneMotion>();
    options.motion->is_still = true;
    options.motion->frames = 1;
    options.motion->shutter = Shutter();
  }
  const std::shared_ptr<const Scene> scene = open_scene(path, options, changes, files);
  moments = {};
  if (!options.motion || !(options.motion->length > 0)) return scene;
  const double length = options.motion->length;
  options.motion.reset();
  moments = {[path, changes, options](double seconds) {
               SceneChanges other = changes;
               other.moment.seconds = seconds;
               return open_scene(path, options, other);
             },
             changes.moment.seconds, length};
  return scene;
}

std::vector<std::string> scene_options(const ViewOptions& o, const std::string& path) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i + 1 < o.changes.given.size(); i += 2)
    if (path == o.scene || o.changes.given[i] != "--look-at")
      words.insert(words.end(), {o.changes.given[i], o.changes.given[i + 1]});
  return words;
}

ViewState first_state(const ViewOptions& o, const Script& script, const Scene& scene, ViewState state) {
  const RenderSettings& s = o.table.settings;
  read_command_line([&] { state.camera = scene.camera(s.camera); });
  set_mode(state, o.mode);
  set_part(state, o.part);
  state.kernel = s.kernel;
  state.engine = s.engine;
  if (s.gather > 0) state.gather = s.gather;
  if (s.photons > 0) state.photons = s.photons;
  if (s.nearest > 0) state.nearest = s.nearest;
  state.filter = s.filter == Filtering::automatic;
  state.reuse = !o.no_reuse;
  if (script.width > 0) {
    state.width = script.width;
    state.height = script.height;
  }
  if (s.width > 0) {
    state.width = s.width;
    state.height = s.height;
  }
  return state;
}

SessionSettings session_settings(const ViewOptions& o, bool window) {
  SessionSettings settings;
  settings.adapt = window || o.adapt;
  settings.frames_per_second = o.fps;
  settings.seed = o.table.settings.seed;
  settings.memory_bytes = o.table.settings.memory_bytes;
  return settings;
}

void add_view_command(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* c = program.add_subcommand("view", "Opens a window on a scene: move the camera and the lights.");
  add_scene_argument(*c, options->scene);
  for (const char* group : {"Picture", "Method", "Effort", "Machine"})
    add_table_options(*c, group, Command::view, options->table);
  add_scene_options(*c, options->changes);
  add_start_options(*c, *options);
  add_session_options(*c, *options);
  c->footer(kViewFooter);
  c->callback([options, &exit_status] { exit_status = run_view(*options); });
}

}  // namespace glowworm
