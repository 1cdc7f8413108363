// Photons and gather rays of a render with a time limit, on a machine that is slower than resolve() reckons with.
#pragma once
#include <vector>

#include "points/gather_points.h"
#include "settings/cost.h"
#include "settings/render_key.h"
#include "settings/settings.h"

namespace glowworm {

/// Numbers that a user left to the program.
struct AutomaticNumbers {
  bool photons = false, gather = false, light_samples = false;
};
AutomaticNumbers automatic_numbers(const RenderSettings& asked);

/// The settings with the automatic numbers of the checkpoint where they depend on the number of samples, or on a limit
/// of time or noise: a render that continues repeats the photons that its samples saw.
/// @param kept the checkpoint's key
RenderSettings with_numbers_of(RenderSettings asked, const RenderKey& kept);

/// Share of the photons, and most of the pixels, that measure the speed; of the rows that show what it takes to finish
/// the picture.
inline constexpr double kPilotShare = 1.0 / 16;

/// Whether a slow machine could miss the time limit by these settings, so that measuring its speed is worth the time.
/// @param settings resolved @param room_s wall seconds left
bool may_need_fitting(const RenderSettings& settings, const AutomaticNumbers& automatic, double room_s);

/// The settings with this share of their photons, at least 1,000.
RenderSettings with_fewer_photons(RenderSettings settings, double share);

/// The settings with fewer automatic photons and gather rays, so that the photons take at most 40% of the time left,
/// and a first image fits into the rest.
/// @param settings resolved @param cost wall seconds, measured; 0 for rays if there are none
/// @param room_s wall seconds left
RenderSettings fitted_settings(const RenderSettings& settings, const AutomaticNumbers& automatic, const Cost& cost,
                               double room_s);

/// Small tasks, evenly spread over the picture, to measure the cost of samples.
std::vector<CameraTask> spread_tasks(const PixelBounds& bounds);

}  // namespace glowworm
