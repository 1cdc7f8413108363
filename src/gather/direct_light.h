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

/// Adds to radiance.direct the light that reaches the gather points directly from the lights, with `light_samples`
/// light samples each. `gather_rays` is the number of rays that the final gather sends for the same light, by `guide`
/// (null: none). Runs on all threads (Phase::direct; counts occlusion_rays).
void add_direct_light(const Tracer& tracer, const GatherPoints& points, std::uint32_t seed, std::uint32_t light_samples,
                      std::uint32_t gather_rays, const GatherGuide* guide, SlotRadiance& radiance,
                      Statistics& statistics);

}  // namespace glowworm
