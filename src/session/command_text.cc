#include "session/command_text.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "core/text.h"
#include "session/camera_control.h"
#include "settings/options.h"

namespace glowworm {

namespace {

/// The scene's camera with the same lens, whose name the command uses.
const Camera& like_camera(const Scene& scene, const Camera& camera) {
  for (const Camera& c : scene.cameras())
    if (c.name == camera.name) return c;
  return scene.cameras().front();
}

/// The edit with its vectors turned.
template <typename Turn>
LightEdit turned(LightEdit edit, const Turn& turn) {
  const Vec3 zero{0, 0, 0};  // + 0 writes 0 in place of -0
  edit.move = turn(edit.move) + zero;
  edit.turn = turn(edit.turn) + zero;
  return edit;
}

LightEdit from_file_axes(const LightEdit& edit, const Scene& scene) {
  return turned(edit, [&](Vec3 v) { return scene.from_file_axes(v); });
}

LightEdit to_file_axes(const LightEdit& edit, const Scene& scene) {
  return turned(edit, [&](Vec3 v) { return scene.to_file_axes(v); });
}

/// A camera at the position of a --view text, whose axes have z up or y up.
Camera placed_by_view(const Camera& camera, const std::string& text, Vec3 origin, bool z_up) {
  const std::vector<double> v = numbers_of<double>(text);
  if (v.size() != 9)
    throw Error(fmt::format("--view '{}' is not a view", text),
                "Give nine numbers: eye, target and up, for example 0,1,5,0,1,0,0,1,0.");
  const Vec3 from = z_up ? z_up_from_y_up(origin) : origin;
  const auto triple = [&](std::size_t first, Vec3 zero) {
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis)
      out[axis] = static_cast<float>(v[first + static_cast<std::size_t>(axis)] - zero[axis]);
    return z_up ? y_up_from_z_up(out) : out;
  };
  return placed(camera, triple(0, from), triple(3, from), triple(6, {0, 0, 0}));
}

}  // namespace

std::string view_text(const Camera& camera, const Scene& scene) {
  const Transform& m = camera.to_world;
  const Vec3 eye = scene.to_file_axes(m.translation), target = scene.to_file_axes(m.translation + forward(camera));
  const Vec3 origin = scene.to_file_axes(scene.origin()), up = scene.to_file_axes(normalize(m.y));
  std::string text;
  // Far from the origin, float would round the direction from eye to target.
  for (const Vec3 place : {eye, target})
    for (int axis = 0; axis < 3; ++axis)
      text +=
          origin[axis] == 0 ? fmt::format("{},", place[axis]) : fmt::format("{},", double{place[axis]} + origin[axis]);
  return text + fmt::format("{},{},{}", up.x, up.y, up.z);
}

void check_view(const std::string& text) { placed_by_view(Camera(), text, {0, 0, 0}, false); }

Camera camera_of_view(const Camera& camera, const std::string& text, const Scene& scene) {
  Camera out = placed_by_view(camera, text, scene.origin(), scene.z_up());
  out.name = "view " + text;
  return out;
}

std::shared_ptr<const Scene> scene_of_view(std::shared_ptr<const Scene> scene, const std::vector<std::string>& lights,
                                           const std::string& view, std::string& camera, const LightRig* named) {
  if (lights.empty() && view.empty()) return scene;
  const LightRig rig(scene);
  const LightRig& names = named ? *named : rig;
  std::vector<LightEdit> edits(names.lights().size());
  std::string name = scene->name();
  for (const std::string& text : lights) {
    const auto [light, edit] = parse_light_edit(text);
    edits[names.find(light)] = from_file_axes(edit, *scene);
    name += " " + text;
  }
  const std::shared_ptr<const Scene> lit = rig.edited(rig.edits_of(names, edits));
  if (!named && !(lit->light_power().total() > 0))
    throw Error("--light leaves the scene without any light", "Leave one of the lights on.");
  SceneEdit edit{lit->emissions(), lit->lights(), lit->environment(), lit->shared_geometry(), {}, name};
  if (!view.empty()) {
    edit.more_cameras.push_back(camera_of_view(scene->camera(camera), view, *scene));
    camera = edit.more_cameras.back().name;
  }
  return std::make_shared<const Scene>(*scene, std::move(edit));
}

std::string render_command_text(const std::string& path, const Scene& scene, const std::vector<RigLight>& lights,
                                const ViewState& state, const std::vector<std::string>& scene_options) {
  std::string text = fmt::format("glowworm render {}", shell_word(path));
  for (const std::string& word : scene_options) text += " " + shell_word(word);
  RenderSettings defaults = render_settings(ViewState());
  defaults.width = defaults.height = 0;
  const RenderSettings wanted = render_settings(state);
  for (const Option& option : render_options())
    if (const std::string value = option.print(wanted); value != option.print(defaults))
      text += " " + command_line_text(option, value);
  const Camera& base = like_camera(scene, state.camera);
  if (&base != &scene.cameras().front()) text += fmt::format(" --camera {}", shell_word(base.name));
  if (!same_view(base, state.camera)) text += fmt::format(" --view {}", view_text(state.camera, scene));
  for (std::size_t i = 0; i < lights.size() && i < state.lights.size(); ++i)
    if (!(state.lights[i] == LightEdit()))
      text +=
          fmt::format(" --light {}", shell_word(light_edit_text(lights[i].name, to_file_axes(state.lights[i], scene))));
  return text + " --samples 64 --gather 64 -o view.exr -o view.png";
}

}  // namespace glowworm
