// Divides a render into tasks that fit the remaining memory ([HHS05], section 5.1).
#pragma once
#include <cstdint>
#include <vector>

#include "points/gather_points.h"
#include "settings/settings.h"

namespace glowworm {

/// How a render is divided into tasks. The picture does not depend on it: every sample of a pixel has its own random
/// numbers, query points are independent of each other, and the film adds exactly.
struct Schedule {
  std::uint64_t slots_at_once = 1;                     ///< approximate camera samples of a task: pixels times samples
  std::uint32_t samples_at_once = 1;                   ///< most camera samples of a pixel in a pass
  std::size_t queries_at_once = std::size_t{1} << 22;  ///< batch size: final gather rays that are looked up together
  bool by_disk = false;  ///< query points of a task go through a file (density/query_store.h)
};

/// Bytes of the smallest task.
std::uint64_t smallest_room(const RenderSettings& settings);

/// Divides a render so that its tasks stay within `room` bytes. Tiles are as large as possible, because engines are
/// faster on large batches, but a task takes no more than a moment, or a small share of a time limit. Throws Error if
/// the smallest task does not fit.
/// @param settings resolved
Schedule make_schedule(const RenderSettings& settings, std::uint64_t room);

/// Camera samples of a task of a render by several processes, for each thread.
inline constexpr std::uint32_t kSharedSlots = 1u << 15;

/// Most camera samples of a pixel in a task whose film another process sends: with layers of objects or materials, as
/// many as the film has room for their ids.
/// @param settings resolved
std::uint32_t most_shared_samples(const RenderSettings& settings);

/// Division of a render by several processes: tasks of about a second, several for each process. The processes send
/// sums of the samples of a task, so tiles are small and have many samples.
struct SharedTasks {
  Schedule schedule;                  ///< with smaller tiles
  std::uint32_t samples_at_once = 1;  ///< most samples of a task
};
SharedTasks shared_tasks(const Schedule& schedule, const RenderSettings& settings, int processes);

/// Width and height of the tiles of a pass, in pixels; those at the right and bottom may be smaller.
struct TileSize {
  int width, height;
};
TileSize tile_size(const Schedule& schedule, const RenderSettings& settings, std::uint32_t sample_count);

/// Camera samples of the pass after `done` samples of the settings' range: one at first, so that a whole noisy image
/// exists soon, then as many as are done, within the schedule. With Preference::quality all at once, if the number of
/// samples is known; one at a time if noise ends the render, because noise is measured after every pass.
std::uint32_t samples_of_pass(const Schedule& schedule, const RenderSettings& settings, std::uint32_t done);

/// The tasks of a pass over the part of the picture that is rendered, row by row of tiles.
std::vector<CameraTask> tasks_of_pass(const Schedule& schedule, const RenderSettings& settings,
                                      std::uint32_t first_sample, std::uint32_t sample_count);

/// Takes the next tasks off the end of a list: as many as are computed at once, because engines are faster on large
/// batches. Where time is limited, tasks that are predicted to take longer are cut into blocks of pixels or into fewer
/// samples, and the rest stays in the list. So the limit is met even where other programs take most of the machine.
/// @param most_slots   Schedule::slots_at_once
/// @param most_s       wall time of a task, TimeLimit::task_s()
/// @param slot_seconds predicted wall time of a camera sample; 0: not known yet
std::vector<CameraTask> next_tasks(std::vector<CameraTask>& left, std::uint64_t most_slots, double most_s,
                                   double slot_seconds);

}  // namespace glowworm
