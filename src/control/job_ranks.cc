// The part of Job that shares a render with other ranks.
#include <mutex>
#include <optional>
#include <vector>

#include "control/job.h"
#include "core/archive.h"
#include "core/parallel.h"
#include "film/part.h"
#include "share/task_queue.h"

namespace glowworm {

template <>
inline constexpr bool kPlain<CameraTask> = sizeof(CameraTask) == 28;

namespace {

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
  const auto take = [&]() -> std::optional<CameraTask> {
    const std::scoped_lock lock(mutex, film_mutex_);
    std::optional<CameraTask> task;
    // Films of several samples fit pixels that have none of them. A checkpoint may have some.
    while ((task = queue.take()) && !film_.awaits(*task)) {
      task = queue.shorten(*task);
      if (!film_.has(*task)) break;
      queue.finish(*task);
    }
    return task;
  };
  const auto finish = [&](const CameraTask& task) {
    const std::lock_guard lock(mutex);
    queue.finish(task);
    if (round_.empty()) passes_ = queue.whole_samples();
    work_done_ =
        std::lerp(share.begin, share.end, static_cast<double>(queue.slots_done()) / static_cast<double>(queue.slots()));
  };
  const auto hand_out = [&]() -> std::optional<TaskBytes> {
    const std::optional<CameraTask> task = take();
    return task ? std::optional(archived(*task)) : std::nullopt;
  };
  const auto take_film = [&](const TaskBytes& bytes, std::span<const std::byte> sums) {
    const auto task = unarchived<CameraTask>(bytes);
    Film film = film_.like(pixels_of(task));
    unpack_film(sums, task, film);
    put(task, film);
    finish(task);
  };
  const auto give_back = [&](const TaskBytes& task) {
    const std::lock_guard lock(mutex);
    queue.give_back(unarchived<CameraTask>(task));
  };
  const auto is_done = [&] {
    const std::lock_guard lock(mutex);
    return queue.done();
  };
  const CancellationScope scope(interrupt_);
  crew_->share({hand_out, take_film, give_back, [&] { return ending_ != Ending::running || is_done(); }}, [&] {
    if (should_stop(task_seconds_)) return true;
    const std::optional<CameraTask> task = take();
    if (!task) return false;
    put(*task, compute(*task));
    finish(*task);
    return true;
  });
  return is_done();
}

void Job::work_for_rank_0() {
  RankWorker member(ranks_);
  member.introduce(key());
  pass_ = pass_settings();
  const auto work = [&](const TaskBytes& bytes) {
    const auto task = unarchived<CameraTask>(bytes);
    prepare(task.first_sample);
    const CancellationScope scope(interrupt_);
    const TaskResult result = compute(task);
    Film film = film_.like(pixels_of(task), task.first_sample);
    CameraTask own = task;
    own.first_sample = 0;
    add_samples(film, own, result);
    return packed_film(film);
  };
  const auto begin = [&] {
    if (!settings_.progressive) prepare(0);
  };
  member.work(
      begin, work, [&] { return interrupt_.requested(); }, 2);
  ending_ = interrupt_.requested() ? Ending::cancelled : Ending::samples_done;
}

}  // namespace glowworm
