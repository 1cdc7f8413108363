#include "session/script.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/frame.h"
#include "kernels/kernel_shape.h"
#include "session/camera_control.h"
#include "settings/options.h"

namespace glowworm {

namespace {

constexpr float kDegree = kPi / 180;

void play_settings(const ScriptMove& move, const Scene& scene, ViewState& state) {
  if (move.camera) state.camera = scene.camera(*move.camera);
  if (move.mode) set_mode(state, *move.mode);
  if (move.part) set_part(state, *move.part);
  if (move.kernel) set_kernel(state, *move.kernel);
  if (move.engine) {
    engine_traits(*move.engine);  // throws if there is no such engine
    state.engine = *move.engine;
  }
  state.gather = move.gather.value_or(state.gather);
  state.nearest = move.nearest.value_or(state.nearest);
  state.photons = move.photons.value_or(state.photons);
  state.filter = move.filter.value_or(state.filter);
  state.reuse = move.reuse.value_or(state.reuse);
  state.secondary_gather = move.secondary_gather.value_or(state.secondary_gather);
}

void play_sun(const ScriptLight& wanted, float step, const RigLight& light, Vec3 up, LightEdit& edit) {
  SunAngles angles = sun_angles(rotate(light.direction, edit.turn), up);
  if (wanted.azimuth) angles.azimuth += step * (*wanted.azimuth * kDegree - angles.azimuth);
  if (wanted.elevation) angles.elevation += step * (*wanted.elevation * kDegree - angles.elevation);
  edit.turn = rotation_between(light.direction, sun_direction(angles, up));
}

/// @param share of the whole move in a frame, @param step of the remaining move
void play_light(const ScriptLight& wanted, bool first, float share, float step, const Scene& scene, const LightRig& rig,
                ViewState& state) {
  const std::size_t i = rig.find(wanted.name);
  state.lights.resize(rig.lights().size());
  LightEdit& edit = state.lights[i];
  if (first) {
    edit.on = wanted.on.value_or(edit.on);
    edit.scale = wanted.scale.value_or(edit.scale);
  }
  edit.move += scene.from_file_axes(wanted.move) * share;
  edit.turn += scene.from_file_axes(wanted.turn) * (share * kDegree);
  const RigLight& light = rig.lights()[i];
  if ((wanted.azimuth || wanted.elevation) && length_squared(light.direction) > 0)
    play_sun(wanted, step, light, nearest_up(state.camera), edit);
}

}  // namespace

void set_mode(ViewState& state, const std::string& name) {
  state.mode = static_cast<ViewMode>(name_index("mode", name, view_mode_names()));
}

void set_part(ViewState& state, const std::string& name) {
  state.part = static_cast<LightPart>(name_index("part", name, light_part_names()));
}

void set_kernel(ViewState& state, const std::string& name) {
  state.kernel = static_cast<KernelShape>(name_index("kernel", name, kernel_names()));
}

void focus_on(const ViewFrame& frame, Vec2 share, ViewState& state) {
  const ViewImage& image = frame.image;
  if (image.empty()) return;
  const Vec2 film{share.x * static_cast<float>(image.width), share.y * static_cast<float>(image.height)};
  const int x = std::clamp(static_cast<int>(film.x), 0, image.width - 1);
  const int y = std::clamp(static_cast<int>(film.y), 0, image.height - 1);
  const float depth =
      image.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)];
  if (!std::isfinite(depth)) return;
  const Vec3 point = unproject(image.camera, film, image.width, image.height, depth);
  state.camera = look_towards(state.camera, point, nearest_up(state.camera));
  state.pivot_distance = length(point - state.camera.to_world.translation);
}

std::uint32_t script_length(const Script& script) {
  if (script.frames > 0) return script.frames;
  std::uint32_t last = 1;
  for (const ScriptMove& move : script.moves) last = std::max(last, move.to);
  return last;
}

void play(const Script& script, std::uint32_t frame, const Scene& scene, const LightRig& rig, const ViewFrame* shown,
          ViewState& state, float part) {
  for (const ScriptMove& move : script.moves) {
    if (frame < move.from || frame >= move.to) continue;
    const bool starts = frame == move.from, first = starts && part == 1;
    // A cut to another camera shows nothing between.
    if (starts && part < 1 && (move.camera || move.focus)) continue;
    const float share = part / static_cast<float>(move.to - move.from),
                step = part / static_cast<float>(move.to - frame);
    if (first) play_settings(move, scene, state);
    if (first && move.focus && shown) focus_on(*shown, *move.focus, state);
    const Vec3 up = nearest_up(state.camera);
    const Vec2 orbited = move.orbit * (share * kDegree), looked = move.look * (share * kDegree);
    if (orbited.x != 0 || orbited.y != 0)
      state.camera = orbit(state.camera, state.pivot_distance, up, orbited.x, orbited.y);
    if (looked.x != 0 || looked.y != 0) state.camera = look(state.camera, up, -looked.x, looked.y);
    state.seconds += move.seconds * double{share};
    if (length_squared(move.fly) > 0) state.camera = fly(state.camera, move.fly * share);
    if (move.light) play_light(*move.light, first, share, step, scene, rig, state);
  }
}

}  // namespace glowworm
