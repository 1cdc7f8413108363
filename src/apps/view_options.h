// What `glowworm view` was asked for.
#pragma once
#include <optional>
#include <string>

#include "apps/open_scene.h"
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
  std::optional<float> exposure;  ///< stops; none: chosen by the first frame of a scene
  std::uint32_t frames = 0;
  double fps = 15;
  bool adapt = false;
  bool filter = false, no_reuse = false;
};

/// Opens a scene as the options of scenes say; one that is dropped later keeps its own camera. @param memory_bytes that
/// it may take
std::shared_ptr<const Scene> open_view_scene(const ViewOptions& options, const std::string& path,
                                             std::uint64_t memory_bytes, OutputFiles* files = nullptr);

/// The state that a session begins with: `state` (Session::initial_state()), changed as the options say. Throws Error
/// for what there is not.
ViewState first_state(const ViewOptions& options, const Script& script, const Scene& scene, ViewState state);

/// Frames to play: as asked for, else as the script says, else as long as something happens in it.
std::uint32_t script_length(const Script& script, std::uint32_t asked);

/// Settings of the session; frames adapt in a window, and elsewhere where asked to.
SessionSettings session_settings(const ViewOptions& options, bool window);

/// Plays the script without a window and writes each frame into the folder --out. Returns the exit status.
int run_headless_view(const ViewOptions& options, const Script& script);

/// Opens the window. Returns the exit status.
int run_window_view(const ViewOptions& options, const Script& script);

}  // namespace glowworm
