#include "session/worker.h"

#include <exception>
#include <new>
#include <utility>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"

namespace glowworm {

using Clock = std::chrono::steady_clock;

SessionWorker::SessionWorker(const SessionSettings& settings, Load load, std::function<void()> wake)
    : settings_(settings), load_(std::move(load)), wake_(std::move(wake)), thread_([this] { run(); }) {}

SessionWorker::~SessionWorker() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    interrupt_.request();
    loading_interrupt_.request();
  }
  changed_.notify_all();
  thread_.join();
}

void SessionWorker::open(const std::string& path) {
  const std::lock_guard lock(mutex_);
  wanted_scene_ = path;
  loading_ = true;
  interrupt_.request();
  loading_interrupt_.request();
  changed_.notify_all();
}

std::uint64_t SessionWorker::post(const ViewState& state, bool interacting) {
  const std::lock_guard lock(mutex_);
  ++number_;
  if (scene_) return number_;  // The caller does not know the new scene yet.
  state_ = state;
  interacting_ = interacting;
  posted_ = Clock::now();
  interrupt_.request();
  changed_.notify_all();
  return number_;
}

void SessionWorker::pause(bool paused) {
  const std::lock_guard lock(mutex_);
  if (paused_ == paused) return;
  paused_ = paused;
  if (paused) interrupt_.request();
  changed_.notify_all();
}

std::optional<WorkerFrame> SessionWorker::take_frame() {
  const std::lock_guard lock(mutex_);
  return std::exchange(frame_, std::nullopt);
}

std::optional<LoadedScene> SessionWorker::take_scene() {
  const std::lock_guard lock(mutex_);
  return std::exchange(scene_, std::nullopt);
}

std::optional<std::string> SessionWorker::take_error() {
  const std::lock_guard lock(mutex_);
  return std::exchange(error_, std::nullopt);
}

bool SessionWorker::loading() const {
  const std::lock_guard lock(mutex_);
  return loading_;
}

bool SessionWorker::has_work() const {
  return ending_ || wanted_scene_ || (session_ && state_ && !paused_ && failed_ != number_);
}

void SessionWorker::run() {
  while (true) {
    std::optional<std::string> path;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return has_work(); });
      if (ending_) return;
      path = std::exchange(wanted_scene_, std::nullopt);
      loading_interrupt_.clear();
    }
    std::string failure;
    try {
      if (path)
        load_scene(*path);
      else
        render();
    } catch (const Cancelled&) {
    } catch (const std::bad_alloc&) {
      failure = "out of memory";
    } catch (const std::exception& error) {
      failure = error.what();
    }
    {
      const std::lock_guard lock(mutex_);
      if (path) loading_ = wanted_scene_.has_value();
      // The same state would fail again.
      if (!failure.empty() && !path) failed_ = rendered_;
      if (!failure.empty()) error_ = failure;
    }
    wake_();
  }
}

void SessionWorker::load_scene(const std::string& path) {
  const CancellationScope scope(loading_interrupt_);
  SceneMoments moments;
  const std::shared_ptr<const Scene> scene = load_(path, moments);
  auto session = std::make_unique<Session>(scene, settings_, moments);
  LoadedScene loaded{path, scene, session->rig().lights(), moments.length, session->initial_state()};
  // Frees the memory of the old scene before the next one is loaded.
  session_.reset();
  return_free_memory();
  session_ = std::move(session);
  const std::lock_guard lock(mutex_);
  state_.reset();
  frame_.reset();
  scene_ = std::move(loaded);
}

void SessionWorker::render() {
  ViewState state;
  WorkerFrame out;
  bool interacting;
  Clock::time_point posted;
  {
    const std::lock_guard lock(mutex_);
    if (!state_ || paused_) return;
    state = *state_;
    interacting = interacting_;
    out.number = rendered_ = number_;
    posted = posted_;
    interrupt_.clear();
  }
  const double now = std::chrono::duration<double>(Clock::now() - start_).count();
  out.frame = session_->next_frame(state, now, interacting, interrupt_);
  out.latency = std::chrono::duration<double>(Clock::now() - posted).count();
  const std::lock_guard lock(mutex_);
  // If another scene was requested meanwhile, this picture is obsolete.
  if (!wanted_scene_) frame_ = std::move(out);
}

}  // namespace glowworm
