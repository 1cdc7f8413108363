// A session in a thread of its own, so that a window never waits for a frame.
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

/// A scene that was loaded, for whoever lists its cameras and lights.
struct LoadedScene {
  std::string path;
  std::shared_ptr<const Scene> scene;
  std::vector<RigLight> lights;
  ViewState state;  ///< Session::initial_state()
};

/// A frame, and the state it is of.
struct WorkerFrame {
  ViewFrame frame;
  std::uint64_t number = 0;  ///< that post() gave the newest state in it
  double latency = 0;        ///< seconds from that post() to the frame
};

/// Renders the newest state posted, over and over. All functions may be called from one other thread.
class SessionWorker {
 public:
  /// @param load makes a scene of a path; called in the worker's thread, may throw
  /// @param wake called in the worker's thread when there is something to take
  SessionWorker(const SessionSettings& settings, std::function<std::shared_ptr<const Scene>(const std::string&)> load,
                std::function<void()> wake);
  ~SessionWorker();  ///< interrupts and waits
  SessionWorker(const SessionWorker&) = delete;
  SessionWorker& operator=(const SessionWorker&) = delete;

  /// Opens a scene; where that fails, the one before stays. States posted before it is there are dropped.
  void open(const std::string& path);
  /// Shows a state from now on; leaves a frame of a view at rest that is under way. Returns the state's number.
  std::uint64_t post(const ViewState& state, bool interacting);
  /// Renders nothing until it is called with false: nobody sees it.
  void pause(bool paused);

  /// What there is since the last call; nothing where there is nothing new.
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
  const std::function<std::shared_ptr<const Scene>(const std::string&)> load_;
  const std::function<void()> wake_;
  std::unique_ptr<Session> session_;  // the thread's own
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Interrupt interrupt_;
  Interrupt loading_interrupt_;  ///< of the scene that is being loaded: it is wanted no more
  bool ending_ = false, paused_ = false, loading_ = false, failed_ = false, interacting_ = false;
  std::optional<std::string> wanted_scene_;
  std::optional<ViewState> state_;  // newest
  std::uint64_t number_ = 0;
  std::chrono::steady_clock::time_point posted_;
  std::optional<WorkerFrame> frame_;
  std::optional<LoadedScene> scene_;
  std::optional<std::string> error_;
  std::thread thread_;
};

}  // namespace glowworm
