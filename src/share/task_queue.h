// Tasks of a render for several workers.
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "points/gather_points.h"

namespace glowworm {

/// Hands out the tasks of tiles. The samples of a tile are computed one task after another, as the film wants them;
/// tiles are independent. Not thread-safe.
class TaskQueue {
 public:
  /// @param tiles with all their samples
  /// @param step  most samples of a task; the first of a tile have fewer, so that a whole, noisy picture is there soon
  TaskQueue(const std::vector<CameraTask>& tiles, std::uint32_t step);

  /// The next task; nothing while every tile is done or under way.
  std::optional<CameraTask> take();
  /// Leaves the first sample of a task under way, which take() has just given.
  CameraTask shorten(const CameraTask& task);
  /// Ends a task. Returns false if it was ended before, or not handed out.
  bool finish(const CameraTask& task);

  /// Takes a task back whose worker is lost, or late. Tiles that are free now come before it, so that a late worker may
  /// still finish it. The results of both workers are the same.
  void give_back(const CameraTask& task);

  bool done() const { return left_ == 0; }
  /// Camera samples of finished tasks, and of all.
  std::uint64_t slots_done() const { return slots_done_; }
  std::uint64_t slots() const { return slots_; }
  /// Samples that every tile has; 0 without tiles.
  std::uint32_t whole_samples() const;

 private:
  struct Tile {
    CameraTask task;             // the next, or the one under way
    std::uint32_t samples, end;  // finished, and one past the last
    bool under_way = false;
  };
  using Place = std::tuple<int, int, std::uint32_t>;  // upper left corner and squares
  static Place place_of(const CameraTask& task) { return {task.y0, task.x0, task.squares}; }

  Tile* tile_of(const CameraTask& task);

  std::uint32_t step_;
  std::map<Place, Tile> tiles_;
  std::deque<Place> free_;
  std::size_t left_ = 0;  // tiles with samples to do
  std::uint64_t slots_ = 0, slots_done_ = 0;
};

}  // namespace glowworm
