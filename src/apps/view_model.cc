#include "apps/view_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "core/log.h"
#include "core/text.h"
#include "session/camera_control.h"

namespace glowworm {

namespace {

constexpr std::size_t kMaxMessages = 8;
constexpr std::size_t kMaxFrameTimes = 120;

FrameTimes times_of(const FrameCost& cost) {
  const auto ms = [&](Phase phase) { return static_cast<float>(1e3 * cost.phase(phase)); };
  FrameTimes t;
  t.total = static_cast<float>(1e3 * cost.seconds);
  t.photons = ms(Phase::trace_photons);
  t.map = ms(Phase::build_photon_map);
  t.camera = ms(Phase::camera_pass);
  t.direct = ms(Phase::direct);
  t.gather = ms(Phase::gather_rays);
  t.density = ms(Phase::reorder) + ms(Phase::density) + ms(Phase::completion);
  const double seconds = std::max(cost.seconds, 1e-9), density = std::max(1e-3 * t.density, 1e-9);
  t.rays = static_cast<float>(1e-6 * static_cast<double>(cost.rays()) / seconds);
  if (cost.count(Counter::shader_operations) > 0)
    t.operations = static_cast<float>(1e-6 * static_cast<double>(cost.count(Counter::shader_operations)) / density);
  return t;
}

/// Whether two states give the same frame.
bool same_state(const ViewState& a, const ViewState& b) {
  return same_view(a.camera, b.camera) && a.lights == b.lights && same_picture(a, b) && a.filter == b.filter &&
         a.reuse == b.reuse && a.seconds == b.seconds;
}

}  // namespace

ViewModel::ViewModel(const ViewOptions& o, const Script& s, std::function<void()> wake)
    : options(o),
      script(s),
      worker(
          session_settings(o, true),
          [&o, bytes = session_settings(o, true).memory_bytes](const std::string& path, SceneMoments& moments) {
            return open_view_scene(o, path, bytes, moments);
          },
          std::move(wake)),
      tone(o.tone == "srgb" ? ToneCurve::srgb : ToneCurve::filmic),
      exposure(o.exposure.value_or(0)),
      expose(!o.exposure) {}

Vec3 ViewModel::up() const { return scene ? nearest_up(scene->scene->cameras().front()) : Vec3{0, 1, 0}; }

void ViewModel::say(const std::string& message) {
  warn(message);
  messages.push_back(message);
  if (messages.size() > kMaxMessages) messages.erase(messages.begin());
}

void ViewModel::open(const std::string& path) { worker.open(path); }

void ViewModel::expose_now() {
  if (!expose || !shown || !shown->frame.is_light) return;
  exposure = automatic_exposure(shown->frame.image.light);
  expose = false;
  picture_changed = true;
}

void ViewModel::post(bool interacting) {
  if (!scene || state.width < 1 || state.height < 1) return;
  if (posted_ && same_state(*posted_, state) && interacting == interacting_) return;
  posted_ = state;
  interacting_ = interacting;
  number_ = worker.post(state, interacting);
  failed = false;
}

bool ViewModel::advance(double seconds) {
  if (!scene || !(scene->length > 0) || !plays) return false;
  state.seconds = std::fmod(state.seconds + seconds, scene->length);
  return true;
}

bool ViewModel::take() {
  bool anything = false;
  if (auto error = worker.take_error()) {
    say(*error);
    failed = true;
    anything = true;
  }
  if (auto loaded = worker.take_scene()) {
    const bool first = !scene;
    scene = std::move(loaded);
    rig = std::make_unique<LightRig>(scene->scene);
    tell_notes(*scene->scene, scene->path);
    if (first) {
      state = first_state(options, script, *scene->scene, scene->state);
    } else {
      // The settings of the view stay.
      state.camera = scene->state.camera;
      state.pivot_distance = scene->state.pivot_distance;
      state.lights = scene->state.lights;
      state.seconds = scene->state.seconds;
    }
    plays = false;
    light = -1;
    saved_cameras.clear();
    if (!first) expose = expose || !options.exposure;
    posted_.reset();
    anything = true;
  }
  if (auto frame = worker.take_frame()) {
    shown = std::move(frame);
    new_frame = true;
    expose_now();
    if (shown->number >= number_) expected_ = false;
    add_times(shown->frame);
    anything = true;
  }
  return anything;
}

void ViewModel::add_times(const ViewFrame& frame) {
  times.push_back(times_of(frame.cost));
  if (times.size() > kMaxFrameTimes) times.pop_front();
  if (frame.moving) longest_latency = std::max(longest_latency, shown->latency);
}

void ViewModel::save(const std::string& path) {
  if (!shown) return say("there is no picture to save yet");
  try {
    const bool light_shown = shown->frame.is_light;
    if (lower_ending(path) == ".png" && light_shown && options.color.view)
      write_png(path, frame_image(shown->frame), *options.color.view, exposure);
    else if (lower_ending(path) == ".png")
      write_png(path, frame_image(shown->frame), light_shown ? tone : ToneCurve::srgb, light_shown ? exposure : 0);
    else
      write_image(path, frame_image(shown->frame));
    inform(fmt::format("wrote {}", path));
  } catch (const std::exception& error) {
    say(error.what());
  }
}

}  // namespace glowworm
