// Options of `glowworm view`.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/open_scene.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "session/script.h"
#include "session/session.h"
#include "session/worker.h"

namespace glowworm {

struct ViewOptions {
  std::string scene;
  TableOptions table;
  SceneOptions changes;
  std::string script, out, format = "png", simd = "auto", mode = "gather", part = "all";
  std::string tone = "filmic";
  ColorViewOptions color;
  std::optional<float> exposure;  ///< stops; empty: chosen from the first frame of a scene
  std::uint32_t frames = 0;
  double fps = 15;
  bool adapt = false;
  bool no_reuse = false;
};

/// Opens a scene with the scene options. --look-at does not apply to scenes dropped later.
/// @param memory_bytes memory that loading may take
/// @param moments gets those of the scene
std::shared_ptr<const Scene> open_view_scene(const ViewOptions& options, const std::string& path,
                                             std::uint64_t memory_bytes, SceneMoments& moments,
                                             OutputFiles* files = nullptr);

/// The scene options that open_view_scene() opens a scene with, in a form to repeat on another command line.
std::vector<std::string> scene_options(const ViewOptions& options, const std::string& path);

/// The initial state of a session: `state` (Session::initial_state()), changed by the options. Throws Error if an
/// option names something that does not exist.
ViewState first_state(const ViewOptions& options, const Script& script, const Scene& scene, ViewState state);

/// Settings of the session. Frames adapt in a window, and otherwise on request.
SessionSettings session_settings(const ViewOptions& options, bool window);

/// Plays the script without a window and writes each frame to the folder --out. Returns the exit status.
int run_headless_view(const ViewOptions& options, const Script& script);

/// Opens the window. Returns the exit status.
int run_window_view(const ViewOptions& options, const Script& script);

}  // namespace glowworm
