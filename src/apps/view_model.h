// What the window knows: the state, the newest frame and what is to be said; shared by its parts.
#pragma once
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/view_options.h"
#include "session/display.h"
#include "session/gizmo.h"
#include "session/worker.h"

namespace glowworm {

/// A point of the curves of frame time.
struct FrameTimes {
  float total = 0, photons = 0, map = 0, camera = 0, direct = 0, gather = 0, density = 0;  // milliseconds
  float rays = 0, operations = 0;                                                          // millions a second
};

/// The window's data, apart from GLFW and OpenGL.
struct ViewModel {
  explicit ViewModel(const ViewOptions& options, const Script& script, std::function<void()> wake);

  const ViewOptions& options;
  const Script& script;
  SessionWorker worker;

  std::optional<LoadedScene> scene;  ///< none until the first is loaded
  std::unique_ptr<LightRig> rig;     ///< of that scene
  bool failed = false;               ///< the last thing that the worker said is an error
  ViewState state;
  std::optional<WorkerFrame> shown;
  bool new_frame = false;  ///< since the texture was filled
  std::vector<std::pair<std::string, Camera>> saved_cameras;
  int light = -1;  ///< the selected one, or -1
  ToneCurve tone = ToneCurve::filmic;
  float exposure = 0;  ///< stops
  bool expose = true;  ///< by the next frame of light
  std::string save_path = "view.png";
  std::vector<std::string> messages;  ///< errors, newest last
  std::deque<FrameTimes> times;
  double longest_latency = 0;    ///< seconds, of frames in motion
  bool picture_changed = false;  ///< tone or exposure

  bool help = false;      ///< the panel says what mouse and keys do
  int panel_width = 340;  ///< pixels of the window that the panel takes

  /// Posts the state where it differs from the last posted, or a person is at it.
  void post(bool interacting);
  /// From now on shows_newest() tells of frames that come later, of the state that is posted next.
  void expect_frame() { expected_ = true; }
  bool shows_newest() const { return !expected_; }
  /// Takes what the worker has; true where there is something new to draw.
  bool take();
  void open(const std::string& path);
  /// Chooses the exposure by the frame shown, if it is one of light and `expose` asks for it.
  void expose_now();
  void say(const std::string& message);
  /// Writes the frame shown to a file, or says why not.
  void save(const std::string& path);
  /// The world's up, as the scene's first camera has it.
  Vec3 up() const;

 private:
  void add_times(const ViewFrame& frame);
  std::optional<ViewState> posted_;
  bool interacting_ = false;
  bool expected_ = false;
  std::uint64_t number_ = 0;  // of the state posted last
};

/// Whether two states differ in anything.
bool same_state(const ViewState& a, const ViewState& b);

}  // namespace glowworm
