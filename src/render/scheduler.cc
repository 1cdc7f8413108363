#include "render/scheduler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "density/engine.h"

namespace glowworm {

namespace {

// Query points looked up at once, where the budget allows.
constexpr std::uint64_t kMostQueries = DensityEngine::kMostPointsAtOnce;
// Below this a portion is hardly worth the work around it.
constexpr std::uint64_t kFewestQueries = 4096;
// A task of a render with a limit of time looks no more points up than slow cores do in this share of it, since the
// limit is met to half a task; but no fewer than are worth a task.
constexpr double kTaskShareOfTime = 0.1;
constexpr std::uint64_t kFewestTimedQueries = std::uint64_t{1} << 17;
// Query points that a file takes at once: a few gigabytes.
constexpr std::uint64_t kMostOnDisk = std::uint64_t{1} << 25;
// Below so many query points a photon in a portion, photons that find hardly any dominate a reverse engine's work.
constexpr std::uint64_t kFewQueriesPerPhoton = 2;
// From so many on it makes leaves as large as it ever does.
constexpr std::uint64_t kGoodQueriesPerPhoton = 5;
// What portions cost beside rays (atrium, two threads): memory that is written for the first time 190 ns for each query
// point of a portion, once, since the system clears it; lookups 31 ns + 25 ns / Q^0.6 for each of the render's points,
// with Q million of them at once.
constexpr double kFirstTouch = 190e-9, kLookupShare = 25e-9, kLookupPower = 0.6;
// Sides of tiles are multiples of this, the side of the blocks in which the camera pass takes pixels.
constexpr int kSmallestTile = 16;
constexpr std::uint64_t kSmallestSlots = std::uint64_t{kSmallestTile} * kSmallestTile;
// Tiles go over the whole width where they are no lower than this.
constexpr int kLowestBand = 64;

/// Query points of a task at most, for the sake of a limit of time.
std::uint64_t most_timed_queries(const RenderSettings& settings) {
  if (settings.time_limit_s <= 0) return kMostOnDisk;
  const double seconds = settings.time_limit_s * kTaskShareOfTime;
  const double queries = seconds * kQueriesPerSecond * std::max(settings.threads, 1);
  return std::clamp(static_cast<std::uint64_t>(std::min<double>(queries, kMostOnDisk)), kFewestTimedQueries,
                    kMostOnDisk);
}

/// Query points of a portion with which all portions of the render together cost the least, where photons leave it.
std::uint64_t query_batch_size(const RenderSettings& settings) {
  // Not of the samples asked for: a render that goes on from a checkpoint with more of them keeps its portions.
  const double queries = static_cast<double>(settings.width) * settings.height * settings.gather * kDefaultSamples;
  // Where the derivative of kFirstTouch Q + queries kLookupShare (Q / 1e6)^-kLookupPower is zero.
  const double millions = std::pow(queries * kLookupShare * kLookupPower / (kFirstTouch * 1e6), 1 / (1 + kLookupPower));
  const std::uint64_t per_photon =
      engine_traits(settings.engine).goes_over_photons ? kGoodQueriesPerPhoton : kFewQueriesPerPhoton;
  const std::uint64_t fewest = std::min(std::max(per_photon * settings.photons, kFewestQueries), kMostQueries);
  return std::clamp(static_cast<std::uint64_t>(std::min<double>(millions * 1e6, kMostQueries)), fewest, kMostQueries);
}

/// Cuts a length into pieces as even as may be, no longer than `most`.
int even_piece(int length, int most) {
  const int pieces = (length + most - 1) / most;
  const int piece = (length + pieces - 1) / pieces;
  return std::min((piece + kSmallestTile - 1) / kSmallestTile * kSmallestTile, most);
}

}  // namespace

Schedule make_schedule(const RenderSettings& settings, std::uint64_t room) {
  Schedule schedule;
  const std::uint64_t rays = kBytesPerThread * static_cast<std::uint64_t>(std::max(settings.threads, 1));
  const std::uint64_t smallest = rays + kFewestQueries * kBytesPerQuery + kSmallestSlots * kBytesPerSlot;
  if (room < smallest)
    throw Error(fmt::format("after image and photons {:.1f} MB of the memory budget are left; tracing takes {:.1f} MB",
                            static_cast<double>(room) / 1e6, static_cast<double>(smallest) / 1e6),
                "Give a larger --memory, a smaller image, fewer --photons or fewer --threads.");
  const std::uint64_t left = room - rays;
  const bool gathers = settings.integrator == Integrator::gather;
  const std::uint64_t per_slot = gathers ? std::max<std::uint64_t>(settings.gather, 1) : 1;
  // A part is left free for what allocators hold beside.
  const std::uint64_t for_queries = (left - kSmallestSlots * kBytesPerSlot) / 8 * 7;
  schedule.queries_at_once = static_cast<std::size_t>(
      std::clamp(for_queries / (kBytesPerQuery + kBytesPerSlot / per_slot), kFewestQueries, kMostQueries));
  // Every portion costs a reverse engine a look at all photons; what comes back from a file by place, at those near.
  schedule.by_disk =
      gathers && (settings.disk == DiskUse::always ||
                  (settings.disk == DiskUse::automatic && engine_traits(settings.engine).goes_over_photons &&
                   schedule.queries_at_once < std::min(kFewQueriesPerPhoton * settings.photons, kMostQueries)));
  // The cache of the file takes its share, too.
  if (schedule.by_disk)
    schedule.queries_at_once =
        static_cast<std::size_t>(std::clamp(left / 2 / kBytesPerQuery, kFewestQueries, kMostQueries));
  else if (gathers)
    schedule.queries_at_once = std::min<std::size_t>(schedule.queries_at_once, query_batch_size(settings));
  const std::uint64_t task_queries =
      std::min<std::uint64_t>(schedule.by_disk ? kMostOnDisk : schedule.queries_at_once, most_timed_queries(settings));
  // A task as large as a portion of its query points, so that a picture comes in even steps.
  const std::uint64_t for_slots = schedule.by_disk ? left / 3 : left - schedule.queries_at_once * kBytesPerQuery;
  schedule.slots_at_once =
      std::max<std::uint64_t>(std::min(for_slots / kBytesPerSlot, task_queries / per_slot), kSmallestSlots);
  // Small pictures give few query points a sample. Where photons look for query points, later passes take several
  // samples at once, but for progressive renders, whose photons are those of one sample.
  if (!gathers || settings.progressive) return schedule;
  const std::uint64_t pixels = static_cast<std::uint64_t>(settings.width) * static_cast<std::uint64_t>(settings.height);
  std::uint64_t samples = 1;
  if (settings.preference == Preference::quality)
    samples = schedule.slots_at_once / kSmallestSlots;
  else if (settings.preference == Preference::automatic && engine_traits(settings.engine).goes_over_photons)
    samples = schedule.slots_at_once / pixels;
  schedule.samples_at_once = static_cast<std::uint32_t>(std::max<std::uint64_t>(samples, 1));
  return schedule;
}

TileSize tile_size(const Schedule& schedule, const RenderSettings& settings, std::uint32_t sample_count) {
  const std::uint64_t slots = std::max(schedule.slots_at_once / sample_count, kSmallestSlots);
  const auto width = static_cast<std::uint64_t>(settings.width);
  const bool bands = slots / width >= kLowestBand;
  const int side = static_cast<int>(std::sqrt(static_cast<double>(slots)));
  const int most_height = bands ? static_cast<int>(std::min<std::uint64_t>(slots / width, 1u << 20)) : side;
  return {bands ? settings.width : even_piece(settings.width, side / kSmallestTile * kSmallestTile),
          even_piece(settings.height, most_height / kSmallestTile * kSmallestTile)};
}

std::uint32_t samples_of_pass(const Schedule& schedule, const RenderSettings& settings, std::uint32_t done) {
  // The samples after which noise is looked at, and so those of the image, may not depend on memory.
  if (settings.noise_target > 0) return std::min(1u, settings.samples - done);
  const bool open_ended = settings.time_limit_s > 0;
  const bool all = settings.preference == Preference::quality && !open_ended && done > 0;
  const std::uint32_t wanted = all ? schedule.samples_at_once : std::clamp(done, 1u, schedule.samples_at_once);
  return std::min(wanted, settings.samples - done);
}

std::vector<CameraTask> tasks_of_pass(const Schedule& schedule, const RenderSettings& settings,
                                      std::uint32_t first_sample, std::uint32_t sample_count) {
  const TileSize tile = tile_size(schedule, settings, sample_count);
  std::vector<CameraTask> tasks;
  for (int y = 0; y < settings.height; y += tile.height)
    for (int x = 0; x < settings.width; x += tile.width)
      tasks.push_back({x, y, std::min(x + tile.width, settings.width), std::min(y + tile.height, settings.height),
                       first_sample, sample_count});
  return tasks;
}

}  // namespace glowworm
