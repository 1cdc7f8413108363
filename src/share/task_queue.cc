#include "share/task_queue.h"

#include <algorithm>

namespace glowworm {

TaskQueue::TaskQueue(const std::vector<CameraTask>& tiles, std::uint32_t step) : step_(std::max(step, 1u)) {
  for (const CameraTask& task : tiles) {
    if (task.sample_count == 0) continue;
    tiles_[place_of(task)] = {task, task.first_sample, task.first_sample + task.sample_count, false};
    free_.push_back(place_of(task));
    slots_ += task.slot_count();
  }
  left_ = tiles_.size();
}

std::optional<CameraTask> TaskQueue::take() {
  if (free_.empty()) return std::nullopt;
  Tile& tile = tiles_.at(free_.front());
  free_.pop_front();
  tile.task.first_sample = tile.samples;
  tile.task.sample_count = std::min(std::clamp(tile.samples, 1u, step_), tile.end - tile.samples);
  tile.under_way = true;
  return tile.task;
}

CameraTask TaskQueue::shorten(const CameraTask& task) {
  Tile& tile = *tile_of(task);
  tile.task.sample_count = 1;
  return tile.task;
}

/// The tile whose task under way this is; null if there is none.
TaskQueue::Tile* TaskQueue::tile_of(const CameraTask& task) {
  const auto found = tiles_.find(place_of(task));
  return found != tiles_.end() && found->second.under_way && found->second.task == task ? &found->second : nullptr;
}

void TaskQueue::give_back(const CameraTask& task) {
  Tile* const tile = tile_of(task);
  if (!tile) return;
  tile->under_way = false;
  free_.push_back(place_of(task));
}

bool TaskQueue::finish(const CameraTask& task) {
  Tile* const tile = tile_of(task);
  if (!tile) return false;
  tile->under_way = false;
  tile->samples += task.sample_count;
  slots_done_ += task.slot_count();
  if (tile->samples < tile->end)
    free_.push_back(place_of(task));
  else
    --left_;
  return true;
}

std::uint32_t TaskQueue::whole_samples() const {
  std::uint32_t least = UINT32_MAX;
  for (const auto& [place, tile] : tiles_) least = std::min(least, tile.samples);
  return tiles_.empty() ? 0 : least;
}

}  // namespace glowworm
