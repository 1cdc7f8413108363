// Direct light: next-event estimation, combined with the gather rays that hit lights by multiple importance sampling.
#pragma once
#include <cstdint>

#include "core/statistics.h"
#include "gather/gather_rays.h"
#include "points/gather_points.h"
#include "trace/tracer.h"
#include "transport/light_connection.h"

namespace glowworm {

/// The default number of light samples of a gather point for a number of gather rays.
std::uint32_t default_light_samples(std::uint32_t gather_rays);

struct DirectLightSettings {
  std::uint32_t seed = 0;
  std::uint32_t light_samples = 0;     ///< of each gather point
  std::uint32_t gather_rays = 0;       ///< that the final gather sends for the same light
  const GatherGuide* guide = nullptr;  ///< of these rays; null: none
  bool delta_lights = true;            ///< whether lights without size count
  bool directional = true;             ///< whether directional lights count; the camera pass may have found them
};

/// Adds to radiance.direct the light that reaches the gather points directly from the lights. Runs on all threads
/// (Phase::direct; counts occlusion_rays).
void add_direct_light(const Tracer& tracer, const GatherPoints& points, const DirectLightSettings& settings,
                      SlotRadiance& radiance, Statistics& statistics);

}  // namespace glowworm
