// Direct light: next-event estimation, combined with the gather rays that hit lights by multiple importance sampling.
#pragma once
#include <cstdint>
#include <limits>

#include "core/statistics.h"
#include "gather/gather_rays.h"
#include "points/gather_points.h"
#include "scene/light_sampling.h"
#include "trace/tracer.h"

namespace glowworm {

/// Weight of a sample from a strategy that takes `count` samples of density `pdf`, beside a second strategy: the
/// balance heuristic (Veach 1997, equation 9.8).
inline float balance_heuristic(float count, float pdf, float other_count, float other_pdf) {
  const float own = count * pdf, other = other_count * other_pdf;
  return own + other > 0 ? own / (own + other) : 0;
}

/// Reflected light of one light sample, before the test of what is in its way (Tracer::transmittance()).
struct UnoccludedLight {
  RGB radiance{0.0f};  ///< f_r cos L / pdf; black if no test is needed
  Ray shadow_ray;
  std::uint32_t source = kNone;  ///< light source, counted as in Scene::light_power()
};

/// Numbers of samples of a point that bring the same light: of lights, and of directions (0: none).
struct LightSampleCounts {
  float light = 1, directions = 0;
};

/// What a point reflects of a light sample for it: f_r of the given lobes, times cosine, times light, divided by pdf,
/// weighted against samples of directions, and weakened by an absorbing volume that the point knows of.
/// @param density of the gather rays of the point; null: directions are samples of the BSDF
UnoccludedLight reflected_light(const Scene& scene, const LightSample& light, const SurfacePoint& point,
                                const Bsdf& bsdf, Vec3 wo, Lobes lobes, LightSampleCounts counts = {},
                                const GatherDensity* density = nullptr);

/// Whether light samples may reach some of the viewer. None do from a perfectly smooth surface, so that choosing a
/// light for it is wasted. Mixtures of smooth lobes with others count as reached.
bool takes_light_samples(const Bsdf& bsdf);

/// The default number of light samples of a gather point for a number of gather rays.
std::uint32_t default_light_samples(std::uint32_t gather_rays);

/// Adds to radiance.direct the light that reaches the gather points directly from the lights, with `light_samples`
/// light samples each. `gather_rays` is the number of rays that the final gather sends for the same light, by `guide`
/// (null: none). Runs on all threads (Phase::direct; counts occlusion_rays).
void add_direct_light(const Tracer& tracer, const GatherPoints& points, std::uint32_t seed, std::uint32_t light_samples,
                      std::uint32_t gather_rays, const GatherGuide* guide, SlotRadiance& radiance,
                      Statistics& statistics);

}  // namespace glowworm
