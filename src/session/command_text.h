// A view as a command line.
#pragma once
#include <string>

#include "scene/light_rig.h"
#include "scene/scene.h"
#include "session/view_state.h"

namespace glowworm {

/// The command that renders a state at full quality: `glowworm render SCENE` with the view, edited lights and method.
/// Quoted for a POSIX shell. @param path the scene, as it was opened
/// @param scene_options further words of the command, which the scene was opened with
std::string render_command_text(const std::string& path, const Scene& scene, const std::vector<RigLight>& lights,
                                const ViewState& state, const std::vector<std::string>& scene_options = {});

/// A camera's position as text for --view: eye, target and up, nine numbers with commas, in the coordinates and axes of
/// the user's file.
std::string view_text(const Camera& camera, const Scene& scene);
/// Throws Error with an example if a --view text is not valid.
void check_view(const std::string& text);
/// A camera of the same kind, lens and field of view at the position of a --view text, named after it. Throws Error as
/// check_view() does.
Camera camera_of_view(const Camera& camera, const std::string& text, const Scene& scene);

/// The scene with the lights edited as texts say (parse_light_edit()) and, where `view` is not empty, one more camera
/// of that view, whose name is set in `camera`. The edits become part of the scene's name.
/// @param camera name of the camera that the view takes its lens from; empty is the first
/// @param named lights of another moment of the scene, which the texts name; edits of those that are black here have no
/// effect. Null: the lights of this one
std::shared_ptr<const Scene> scene_of_view(std::shared_ptr<const Scene> scene, const std::vector<std::string>& lights,
                                           const std::string& view, std::string& camera,
                                           const LightRig* named = nullptr);

}  // namespace glowworm
