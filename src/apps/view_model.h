// The state of the window: camera and settings, newest frame and messages. Its parts share it.
#pragma once
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

/// A point of the frame-time curves.
struct FrameTimes {
  float total = 0, photons = 0, map = 0, camera = 0, direct = 0, gather = 0, density = 0;  // milliseconds
  float rays = 0, operations = 0;                                                          // millions per second
};

/// The window's data, independent of GLFW and OpenGL.
struct ViewModel {
  explicit ViewModel(const ViewOptions& options, const Script& script, std::function<void()> wake);

  const ViewOptions& options;
  const Script& script;
  SessionWorker worker;

  std::optional<LoadedScene> scene;  ///< empty until the first scene is loaded
  std::unique_ptr<LightRig> rig;     ///< the lights of that scene
  bool failed = false;               ///< whether the worker's last message is an error
  ViewState state;
  std::optional<WorkerFrame> shown;
  bool new_frame = false;  ///< a frame arrived since the texture was filled
  std::vector<std::pair<std::string, Camera>> saved_cameras;
  int light = -1;  ///< the selected light, or -1
  ToneCurve tone = ToneCurve::filmic;
  float exposure = 0;  ///< stops
  bool expose = true;  ///< choose the exposure from the next frame that shows light
  std::string save_path = "view.png";
  std::vector<std::string> messages;  ///< errors, newest last
  std::deque<FrameTimes> times;
  double longest_latency = 0;    ///< seconds, of frames while the view moves
  bool picture_changed = false;  ///< tone curve or exposure changed

  bool plays = false;       ///< the animation runs
  bool help = false;        ///< the panel shows help on mouse and keys
  bool screenshot = false;  ///< write the window to screenshot.png
  int panel_width = 340;    ///< width of the panel, pixels

  /// Posts the state if it differs from the last one posted, or if the user is interacting.
  void post(bool interacting);
  /// Makes shows_newest() false until a frame of the next posted state arrives.
  void expect_frame() { expected_ = true; }
  bool shows_newest() const { return !expected_; }
  /// Moves the animation on by so many seconds if it plays; from its end on it starts again. Returns whether it plays.
  bool advance(double seconds);
  /// Takes results from the worker. Returns true if there is something new to draw.
  bool take();
  void open(const std::string& path);
  /// Chooses the exposure from the frame shown, if that shows light and `expose` is set.
  void expose_now();
  void say(const std::string& message);
  /// Writes the frame shown to a file, or shows an error message.
  void save(const std::string& path);
  /// The world's up vector, from the scene's first camera.
  Vec3 up() const;

 private:
  void add_times(const ViewFrame& frame);
  std::optional<ViewState> posted_;
  bool interacting_ = false;
  bool expected_ = false;
  std::uint64_t number_ = 0;  // number of the state posted last
};

}  // namespace glowworm
