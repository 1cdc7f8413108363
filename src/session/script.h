// Scripts: user actions in a session, frame by frame, from a JSON file. docs/guide.md lists the keys.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/vec.h"
#include "scene/light_rig.h"
#include "session/view_frame.h"
#include "session/view_state.h"

namespace glowworm {

/// Changes of one light during a move.
struct ScriptLight {
  std::string name;
  std::optional<bool> on;
  std::optional<float> scale;               ///< from the first frame on
  Vec3 move{0, 0, 0}, turn{0, 0, 0};        ///< in all, spread evenly: metres, degrees about the file's axes
  std::optional<float> azimuth, elevation;  ///< degrees at the last frame, approached evenly
};

/// An action of the window; sessions without a window ignore it.
struct WindowAction {
  std::string command;  ///< "minimise", "restore", "close", "lose-context", "resize"
  int width = 0, height = 0;
};

/// One entry of a script, for frames [from, to).
struct ScriptMove {
  std::uint32_t from = 0, to = 1;
  Vec2 orbit, look;           ///< degrees to the right and up, in all, spread evenly over the frames
  Vec3 fly{0, 0, 0};          ///< metres to the right, up, ahead, in all
  double seconds = 0;         ///< of the scene's animation, in all
  std::optional<Vec2> focus;  ///< point of the picture to look at and orbit, as shares of its sides
  std::optional<std::string> camera, mode, part, engine, kernel;
  std::optional<std::uint32_t> gather, nearest;
  std::optional<std::uint64_t> photons;
  std::optional<bool> filter, reuse, secondary_gather;
  std::optional<ScriptLight> light;
  std::optional<std::string> screenshot;  ///< picture to write at the first frame, in the output folder
  std::optional<std::string> drop;        ///< scene to load at the first frame
  std::optional<WindowAction> window;
};

struct Script {
  std::uint32_t frames = 0;       ///< from the file; 0 if absent
  double frames_per_second = 30;  ///< of the session's clock
  int width = 0, height = 0;      ///< 0 if absent
  std::vector<ScriptMove> moves;
};

/// Reads a script. Throws Error with file, line or entry, and the valid keys, if it is not valid.
Script read_script(const std::string& path);
/// The same from text; `name` is named in errors.
Script parse_script(const std::string& text, const std::string& name);

/// Applies a script's actions for a frame to the state. @param shown the previous frame, for focusing; may be null.
/// @param part of the frame, in [0, 1]: below 1, what moves evenly goes as far, and all else comes with the whole frame
/// Throws Error for an unknown camera, light, mode, engine or kernel.
void play(const Script& script, std::uint32_t frame, const Scene& scene, const LightRig& rig, const ViewFrame* shown,
          ViewState& state, float part = 1);

/// Number of frames of a script: as it says, or until nothing more happens in it.
std::uint32_t script_length(const Script& script);

/// Turns the camera to the surface under a point of a frame, which becomes the pivot; does nothing if there is none.
/// @param share of the frame's sides, from the upper left corner
void focus_on(const ViewFrame& frame, Vec2 share, ViewState& state);

/// Sets the mode, part or kernel by name; throws Error, which lists the names, for an unknown name.
void set_mode(ViewState& state, const std::string& name);
void set_part(ViewState& state, const std::string& name);
void set_kernel(ViewState& state, const std::string& name);

}  // namespace glowworm
