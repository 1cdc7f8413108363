// The part of Job that shares a render with other ranks.
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "control/job.h"
#include "core/parallel.h"
#include "share/task_queue.h"

namespace glowworm {

namespace {

/// A task that a rank has had for so long is given to another one, too, where nothing else is left to do.
constexpr std::chrono::seconds kLostAfter{60};

PixelBounds pixels_of(const CameraTask& task) { return {task.x0, task.y0, task.x1, task.y1}; }

}  // namespace

bool Job::share_pass(std::uint32_t first_sample, std::uint32_t samples, WorkShare share) {
  const SharedTasks shared = shared_tasks(schedule_, settings_, crew_->count());
  std::vector<CameraTask> tiles = tasks_of_pass(shared.schedule, settings_, first_sample, 1);
  for (CameraTask& tile : tiles) tile.sample_count = samples;
  return share_tasks(tiles, shared.samples_at_once, share);
}

bool Job::share_tasks(const std::vector<CameraTask>& tiles, std::uint32_t samples_at_once, WorkShare share) {
  TaskQueue queue(tiles, samples_at_once);
  std::mutex mutex;
  std::atomic<bool> ended = false;
  const auto take = [&]() -> std::optional<CameraTask> {
    const std::lock_guard lock(mutex);
    const TaskQueue::Clock::time_point now = TaskQueue::Clock::now();
    std::optional<CameraTask> task;
    // Films of several samples fit pixels that have none of them. A checkpoint may have some.
    while (!ended && (task = queue.take(now)) && !film_.awaits(*task)) {
      task = queue.shorten(*task);
      if (!film_.has(*task)) break;
      queue.finish(*task);
    }
    return task || ended ? task : queue.take_again(now - kLostAfter, now);
  };
  const auto finish = [&](const CameraTask& task) {
    const std::lock_guard lock(mutex);
    queue.finish(task);
    if (round_.empty()) passes_ = queue.whole_samples();
    work_done_ =
        std::lerp(share.begin, share.end, static_cast<double>(queue.slots_done()) / static_cast<double>(queue.slots()));
  };
  const auto take_film = [&](const CameraTask& task, std::span<const std::byte> bytes) {
    Film film = film_.like(pixels_of(task));
    unpack_film(bytes, task, film);
    put(task, film);
    finish(task);
  };
  const auto give_back = [&](const CameraTask& task) {
    const std::lock_guard lock(mutex);
    queue.give_back(task);
  };
  std::exception_ptr failure;
  std::thread server([&] {
    try {
      crew_->serve({take, take_film, give_back, [&] { return ended.load(); }});
    } catch (...) {
      failure = std::current_exception();
      ended = true;
    }
  });
  const auto is_done = [&] {
    const std::lock_guard lock(mutex);
    return queue.done();
  };
  try {
    const CancellationScope scope(interrupt_);
    while (!ended && !is_done() && !should_stop(task_seconds_)) {
      if (const std::optional<CameraTask> task = take()) {
        put(*task, compute(*task));
        finish(*task);
        continue;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  } catch (...) {
    failure = std::current_exception();
  }
  ended = true;
  server.join();
  if (failure) std::rethrow_exception(failure);
  return is_done();
}

void Job::work_for_rank_0() {
  RankWorker member(ranks_);
  member.introduce(key());
  pass_ = pass_settings();
  const auto work = [&](const CameraTask& task) {
    prepare(task.first_sample);
    const CancellationScope scope(interrupt_);
    const TaskResult result = compute(task);
    Film film = film_.like(pixels_of(task), task.first_sample);
    CameraTask own = task;
    own.first_sample = 0;
    add_samples(film, own, result);
    return film;
  };
  const auto begin = [&] {
    if (!settings_.progressive) prepare(0);
  };
  member.work(begin, work, [&] { return interrupt_.requested(); });
  ending_ = interrupt_.requested() ? Ending::cancelled : Ending::samples_done;
}

}  // namespace glowworm
