// A session in its own thread, so that a window never waits for a frame.
#pragma once
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/interrupt.h"
#include "session/session.h"

namespace glowworm {

/// A loaded scene, for lists of cameras and lights.
struct LoadedScene {
  std::string path;
  std::shared_ptr<const Scene> scene;
  std::vector<RigLight> lights;
  double length = 0;  ///< of its animation, s; 0: there is none
  ViewState state;    ///< Session::initial_state()
};

/// A frame and its state.
struct WorkerFrame {
  ViewFrame frame;
  std::uint64_t number = 0;  ///< number of its newest state, from post()
  double latency = 0;        ///< seconds from that post() to the frame
};

/// Renders the newest posted state, again and again. One other thread may call all functions.
class SessionWorker {
 public:
  /// Loads a scene by path, and sets its moments.
  using Load = std::function<std::shared_ptr<const Scene>(const std::string& path, SceneMoments& moments)>;
  /// @param load called in the worker's thread, may throw
  /// @param wake called in the worker's thread when a result is ready
  SessionWorker(const SessionSettings& settings, Load load, std::function<void()> wake);
  ~SessionWorker();  ///< interrupts and waits
  SessionWorker(const SessionWorker&) = delete;
  SessionWorker& operator=(const SessionWorker&) = delete;

  /// Opens a scene; if that fails, the old one stays. States posted before take_scene() has returned it are dropped.
  void open(const std::string& path);
  /// Shows a state from now on; abandons the frame of a view at rest under way. Returns the state's number.
  std::uint64_t post(const ViewState& state, bool interacting);
  /// Pauses rendering until it is called with false, for hidden windows.
  void pause(bool paused);

  /// Results since the last call; nothing if there are none.
  std::optional<WorkerFrame> take_frame();
  std::optional<LoadedScene> take_scene();
  std::optional<std::string> take_error();
  bool loading() const;

 private:
  void run();
  void load_scene(const std::string& path);
  void render();
  bool has_work() const;

  const SessionSettings settings_;
  const Load load_;
  const std::function<void()> wake_;
  std::unique_ptr<Session> session_;  // the thread's own
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Interrupt interrupt_;
  Interrupt loading_interrupt_;  ///< of the scene being loaded, when it is no longer needed
  bool ending_ = false, paused_ = false, loading_ = false, interacting_ = false;
  std::optional<std::string> wanted_scene_;
  std::optional<ViewState> state_;  // newest
  // Numbers of states, from 1 on: the newest, the one last rendered, and the one that failed last.
  std::uint64_t number_ = 0, rendered_ = 0, failed_ = 0;
  std::chrono::steady_clock::time_point posted_;
  std::optional<WorkerFrame> frame_;
  std::optional<LoadedScene> scene_;
  std::optional<std::string> error_;
  std::thread thread_;
};

}  // namespace glowworm
