#include "control/scheduler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/memory_budget.h"
#include "density/engine.h"
#include "film/film.h"
#include "maps/memory.h"
#include "settings/cost.h"

namespace glowworm {

namespace {

// Batch size of query points, if the budget allows.
constexpr std::uint64_t kMaxQueries = DensityEngine::kMaxPointsAtOnce;
// Smaller portions are not worth their overhead.
constexpr std::uint64_t kMinQueries = 4096;
constexpr std::uint64_t kMinTimedQueries = std::uint64_t{1} << 17;
// Slots of the first task, before the wall time of a slot is known.
constexpr std::uint64_t kMinTimedSlots = 4096;
// Most query points in a file: a few gigabytes.
constexpr std::uint64_t kMaxOnDisk = std::uint64_t{1} << 25;
// Below this number of query points per photon in a portion, photons that find almost none dominate the cost of a
// reverse engine.
constexpr std::uint64_t kFewQueriesPerPhoton = 2;
// Sides of tiles are multiples of this, the side of the camera pass's blocks of pixels.
constexpr int kMinTile = CameraTask::kBlock;
constexpr std::uint64_t kMinSlots = std::uint64_t{kMinTile} * kMinTile;

std::uint64_t slot_bytes_of(const RenderSettings& settings) {
  const PlaceLayers places = settings.place_layers();
  return bytes_per_slot(settings.light_group_count, places.values.count(), places.of_triangles(),
                        places.surface_samples);
}

std::uint64_t ray_bytes(const RenderSettings& settings) {
  return kBytesPerThread * static_cast<std::uint64_t>(std::max(settings.threads, 1));
}

/// Most query points of a task, because of the time limit.
std::uint64_t most_timed_queries(const RenderSettings& settings) {
  if (settings.time_limit_s <= 0) return kMaxOnDisk;
  // The limit is met to half a task, so slow cores should manage a task in a tenth of it.
  const double seconds = settings.time_limit_s * 0.1;
  const double queries = seconds / kUsualCost.ray_s * std::max(settings.threads, 1);
  return std::clamp(static_cast<std::uint64_t>(std::min<double>(queries, kMaxOnDisk)), kMinTimedQueries, kMaxOnDisk);
}

/// Query points of a portion: those of a sample, and so many that photons which find none do not dominate.
std::uint64_t query_batch_size(const RenderSettings& settings) {
  // With 5 query points a photon, leaves of the blocked engine have their largest size.
  const std::uint64_t per_photon = engine_traits(settings.engine).goes_over_photons ? 5 : kFewQueriesPerPhoton;
  return std::min(
      std::max({settings.bounds.pixel_count() * settings.gather, per_photon * settings.photons, kMinQueries}),
      kMaxQueries);
}

/// The part that is rendered, with its upper left corner where a tile may begin: the camera pass traces whole blocks.
PixelBounds tiled_bounds(const RenderSettings& settings) {
  PixelBounds out = settings.bounds;
  out.x0 = out.x0 / kMinTile * kMinTile;
  out.y0 = out.y0 / kMinTile * kMinTile;
  return out;
}

/// Divides a length into even pieces no longer than `most`.
int even_piece(int length, int most) {
  const int pieces = (length + most - 1) / most;
  const int piece = (length + pieces - 1) / pieces;
  return std::min((piece + kMinTile - 1) / kMinTile * kMinTile, most);
}

/// Cuts a task that has more slots than that: into bands of blocks, blocks of a band, or else fewer samples. Returns
/// the rest, which may be empty.
CameraTask cut(CameraTask& task, double slots, bool into_blocks) {
  CameraTask rest = task;
  // Whole blocks along a side of which one pixel has so many slots, up to a multiple of their side.
  const auto blocks_end = [&](int begin, double each) {
    const int blocks = std::max(static_cast<int>(std::min(slots / each, 1e6)) / kMinTile, 1);
    return (begin / kMinTile + blocks) * kMinTile;
  };
  const double row = static_cast<double>(task.x1 - task.x0) * task.sample_count;
  const double column = static_cast<double>(task.y1 - task.y0) * task.sample_count;
  if (const int y = blocks_end(task.y0, row); into_blocks && y < task.y1) {
    rest.y0 = task.y1 = y;
    return rest;
  }
  if (const int x = blocks_end(task.x0, column); into_blocks && x < task.x1) {
    rest.x0 = task.x1 = x;
    return rest;
  }
  const auto samples = static_cast<std::uint32_t>(slots / static_cast<double>(task.pixel_count()));
  task.sample_count = std::clamp(samples, 1u, task.sample_count);
  rest.first_sample += task.sample_count;
  rest.sample_count -= task.sample_count;
  return rest;
}

}  // namespace

std::uint64_t smallest_room(const RenderSettings& settings) {
  return ray_bytes(settings) + kMinQueries * kBytesPerQuery + kMinSlots * slot_bytes_of(settings);
}

Schedule make_schedule(const RenderSettings& settings, std::uint64_t room) {
  Schedule schedule;
  const std::uint64_t slot_bytes = slot_bytes_of(settings), smallest = smallest_room(settings);
  if (room < smallest)
    throw MemoryError(
        fmt::format("after image and photons {:.1f} MB of the memory budget are left; tracing takes {:.1f} MB",
                    static_cast<double>(room) / 1e6, static_cast<double>(smallest) / 1e6),
        "Give a larger --memory, a smaller image, fewer --photons or fewer --threads.");
  const std::uint64_t left = room - ray_bytes(settings);
  const bool gathers = settings.integrator == Integrator::gather;
  const std::uint64_t per_slot = gathers ? std::max<std::uint64_t>(settings.gather, 1) : 1;
  // A part stays free for the overhead of allocators.
  const std::uint64_t for_queries = (left - kMinSlots * slot_bytes) / 8 * 7;
  schedule.queries_at_once = static_cast<std::size_t>(
      std::clamp(for_queries / (kBytesPerQuery + slot_bytes / per_slot), kMinQueries, kMaxQueries));
  // With a reverse engine, every portion visits all photons. Lookups in spatial order from a file visit only near ones.
  schedule.by_disk =
      gathers && (settings.disk == DiskUse::always ||
                  (settings.disk == DiskUse::automatic && engine_traits(settings.engine).goes_over_photons &&
                   schedule.queries_at_once < std::min(kFewQueriesPerPhoton * settings.photons, kMaxQueries)));
  // Points that are read from the file, and their answers, need memory, too.
  if (schedule.by_disk)
    schedule.queries_at_once =
        static_cast<std::size_t>(std::clamp(left / 2 / kBytesPerQuery, kMinQueries, kMaxQueries));
  else if (gathers)
    schedule.queries_at_once = std::min<std::size_t>(schedule.queries_at_once, query_batch_size(settings));
  const std::uint64_t task_queries =
      std::min<std::uint64_t>(schedule.by_disk ? kMaxOnDisk : schedule.queries_at_once, most_timed_queries(settings));
  // A task matches a portion of its query points, so that the picture grows in even steps.
  const std::uint64_t for_slots = schedule.by_disk ? left / 3 : left - schedule.queries_at_once * kBytesPerQuery;
  schedule.slots_at_once =
      std::max<std::uint64_t>(std::min(for_slots / slot_bytes, task_queries / per_slot), kMinSlots);
  // Small pictures have few query points per sample. For engines whose photons search, later passes take several
  // samples at once, and so do paths from points, which may be few. Progressive renders do not, because each sample has
  // its own photons.
  const bool by_points = settings.integrator == Integrator::path && settings.of_points;
  if (!(gathers || by_points) || settings.progressive) return schedule;
  const std::uint64_t pixels = settings.bounds.pixel_count();
  std::uint64_t samples = 1;
  if (settings.preference == Preference::quality) samples = schedule.slots_at_once / kMinSlots;
  // At least 32 passes of paths from points, so that progress moves.
  else if (by_points)
    samples = std::min<std::uint64_t>(schedule.slots_at_once / pixels, settings.sample_range().count() / 32);
  else if (settings.preference == Preference::automatic && engine_traits(settings.engine).goes_over_photons)
    samples = schedule.slots_at_once / pixels;
  schedule.samples_at_once = static_cast<std::uint32_t>(std::max<std::uint64_t>(samples, 1));
  return schedule;
}

std::uint32_t most_shared_samples(const RenderSettings& settings) {
  const PlaceLayers places = settings.place_layers();
  return places.objects || places.materials ? std::uint32_t{kMaxIdsOfPixel} : Film::kMaxSamples;
}

SharedTasks shared_tasks(const Schedule& schedule, const RenderSettings& settings, int processes) {
  // Smaller tiles make engines slow while tasks have few samples.
  constexpr std::uint64_t kTilesEach = 8, kSmallTile = 1u << 12;
  SharedTasks out{schedule, 1};
  const std::uint64_t most = std::min(settings.progressive ? 1u : std::max(settings.sample_range().count() / 4, 1u),
                                      most_shared_samples(settings));
  // All ranks have a task under way when a time limit ends the render.
  const std::uint64_t useful =
      settings.time_limit_s > 0 ? std::max(schedule.slots_at_once / 8, kMinTimedSlots) : schedule.slots_at_once;
  const std::uint64_t threads = static_cast<std::uint64_t>(std::max(settings.threads, 1));
  const std::uint64_t wanted = std::min(useful, kSharedSlots * threads);
  const std::uint64_t even = settings.bounds.pixel_count() / (kTilesEach * static_cast<std::uint64_t>(processes));
  out.schedule.slots_at_once = std::max(std::min({wanted, even, std::max(wanted / most, kSmallTile)}), kMinSlots);
  out.samples_at_once =
      static_cast<std::uint32_t>(std::clamp<std::uint64_t>(wanted / out.schedule.slots_at_once, 1, most));
  return out;
}

TileSize tile_size(const Schedule& schedule, const RenderSettings& settings, std::uint32_t sample_count) {
  const std::uint64_t slots = std::max(schedule.slots_at_once / sample_count, kMinSlots);
  const PixelBounds part = tiled_bounds(settings);
  const auto width = static_cast<std::uint64_t>(part.width());
  // Tiles span the whole width if they are at least 64 pixels high.
  const bool bands = slots / width >= 64;
  const int side = static_cast<int>(std::sqrt(static_cast<double>(slots)));
  const int most_height = bands ? static_cast<int>(std::min<std::uint64_t>(slots / width, 1u << 20)) : side;
  return {bands ? part.width() : even_piece(part.width(), side / kMinTile * kMinTile),
          even_piece(part.height(), most_height / kMinTile * kMinTile)};
}

std::uint32_t samples_of_pass(const Schedule& schedule, const RenderSettings& settings, std::uint32_t done) {
  // The samples after which noise is measured, which determine the image's, must not depend on memory.
  const std::uint32_t left = settings.sample_range().count() - done;
  if (settings.noise_target > 0) return std::min(1u, left);
  const bool open_ended = settings.time_limit_s > 0;
  const bool all = settings.preference == Preference::quality && !open_ended && done > 0;
  const std::uint32_t wanted = all ? schedule.samples_at_once : std::clamp(done, 1u, schedule.samples_at_once);
  return std::min(wanted, left);
}

std::vector<CameraTask> tasks_of_pass(const Schedule& schedule, const RenderSettings& settings,
                                      std::uint32_t first_sample, std::uint32_t sample_count) {
  const TileSize tile = tile_size(schedule, settings, sample_count);
  const PixelBounds part = tiled_bounds(settings), &all = settings.bounds;
  std::vector<CameraTask> tasks;
  for (int y = part.y0; y < part.y1; y += tile.height)
    for (int x = part.x0; x < part.x1; x += tile.width)
      tasks.push_back({std::max(x, all.x0), std::max(y, all.y0), std::min(x + tile.width, all.x1),
                       std::min(y + tile.height, all.y1), first_sample, sample_count});
  return tasks;
}

std::vector<CameraTask> next_tasks(std::vector<CameraTask>& left, std::uint64_t most_slots, double most_s,
                                   double slot_seconds) {
  const bool limited = std::isfinite(most_s);
  auto slots = static_cast<double>(most_slots);
  // Without a prediction as few slots as make a task worth while.
  if (limited) slots = std::min(slots, slot_seconds > 0 ? most_s / slot_seconds : static_cast<double>(kMinTimedSlots));
  std::vector<CameraTask> out;
  std::size_t total = 0;
  while (!left.empty() && (out.empty() || static_cast<double>(total + left.back().slot_count()) <= slots)) {
    CameraTask task = left.back();
    left.pop_back();
    while (static_cast<double>(task.slot_count()) > slots) {
      const CameraTask rest = cut(task, slots, limited);
      if (rest.slot_count() == 0) break;
      left.push_back(rest);
    }
    total += task.slot_count();
    out.push_back(task);
  }
  return out;
}

}  // namespace glowworm
