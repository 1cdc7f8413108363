// From the memory that is left to the tasks of a render ([HHS05], section 5.1).
#pragma once
#include <cstdint>
#include <vector>

#include "points/gather_points.h"
#include "render/settings.h"

namespace glowworm {

/// How a render is cut into tasks. It does not show in the picture: every sample of a pixel has random numbers of its
/// own, what engines say of a query point depends on no other, and the film adds exactly.
struct Schedule {
  std::uint64_t slots_at_once = 1;                     ///< camera samples of a task, about: pixels times samples
  std::uint32_t samples_at_once = 1;                   ///< camera samples of a pixel that a pass takes at most
  std::size_t queries_at_once = std::size_t{1} << 22;  ///< final gather rays that are looked up at once
  bool by_disk = false;  ///< query points of a task go through a file (density/query_store.h)
};

/// Bytes that a camera sample costs while its task runs: its gather point, twice while they are joined, and its light.
inline constexpr std::uint64_t kBytesPerSlot = 3 * GatherPoints::kBytesEach + 4 * sizeof(RGB) + 28;
/// Bytes that a query point costs between its ray and completion: itself, its radiance, and an engine's order of it.
inline constexpr std::uint64_t kBytesPerQuery = 192;
/// Bytes that a photon costs while photons are traced and sorted.
inline constexpr std::uint64_t kBytesPerPhoton = 200;
/// Bytes that a thread needs for the rays that it traces.
inline constexpr std::uint64_t kBytesPerThread = std::uint64_t{8} << 20;

/// Cuts a render up so that its tasks stay within `room` bytes. Tiles are as large as fits, since engines work best on
/// many query points at once, but not so large that a task takes more than a moment, or than a small share of the time
/// where that is limited. Throws Error where not even the smallest task fits.
/// @param settings resolved
Schedule make_schedule(const RenderSettings& settings, std::uint64_t room);

/// Width and height of the tiles of a pass, in pixels, but for those at the right and the bottom.
struct TileSize {
  int width, height;
};
TileSize tile_size(const Schedule& schedule, const RenderSettings& settings, std::uint32_t sample_count);

/// Camera samples that the pass behind `done` samples takes: one at first, so that a whole noisy image is there soon,
/// then as many as there are already, up to what the schedule allows. With Preference::quality all at once, where the
/// number of samples is known; one each where the image's noise ends the render, which is looked at after every pass.
std::uint32_t samples_of_pass(const Schedule& schedule, const RenderSettings& settings, std::uint32_t done);

/// The tasks of a pass over the whole picture, row by row of tiles.
std::vector<CameraTask> tasks_of_pass(const Schedule& schedule, const RenderSettings& settings,
                                      std::uint32_t first_sample, std::uint32_t sample_count);

}  // namespace glowworm
