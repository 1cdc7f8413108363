#include "gather/direct_light.h"

#include <algorithm>
#include <vector>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {

namespace {
/// Gather points that one piece of parallel work takes.
constexpr std::size_t kPointsPerChunk = 256;
/// A shadow ray ends this short of the light, relative to the distance, so that the light does not shadow itself.
constexpr float kShadowLength = 0.9999f;
}  // namespace

UnoccludedLight sample_direct_light(const Scene& scene, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo,
                                    Lobes lobes, float u_light, Vec2 u, float light_samples, float bsdf_samples) {
  UnoccludedLight out;
  const LightSample light = sample_light(scene, point.position, Vec3{0, 0, 0}, u_light, u);
  if (!(light.pdf > 0) || is_black(light.radiance)) return out;
  const ShadedSurface surface = shaded(point, bsdf);
  const RGB scattered = surface.evaluate(wo, light.direction, lobes);
  if (is_black(scattered)) return out;
  float weight = 1;
  if (!light.delta && bsdf_samples > 0)
    weight = balance_heuristic(light_samples, light.pdf, bsdf_samples, surface.pdf(wo, light.direction, lobes));
  out.radiance = scattered * light.radiance * (weight / light.pdf);
  const Vec3 side = face_forward(point.geometric_normal, light.direction);
  out.shadow_ray = {offset_origin(point.position, side), 0, light.direction, light.distance * kShadowLength};
  return out;
}

std::uint32_t usual_light_samples(std::uint32_t gather_rays) {
  return std::clamp<std::uint32_t>(gather_rays / 8, 2, 16);
}

void add_direct_light(const Tracer& tracer, const GatherPoints& points, std::uint32_t seed, std::uint32_t light_samples,
                      std::uint32_t gather_rays, SlotRadiance& radiance, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::direct);
  if (light_samples == 0) return;
  parallel_for(0, points.size(), kPointsPerChunk, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> rays;
    std::vector<RGB> light;
    std::vector<std::uint32_t> slot;
    for (std::size_t i = first; i < last; ++i) {
      SurfacePoint point;
      point.position = points.position[i];
      point.geometric_normal = points.normal[i];
      point.frame = points.frame[i];
      for (std::uint32_t n = 0; n < light_samples; ++n) {
        Sampler sampler(SamplerKind::sobol, seed, hash_combine(points.sequence[i], 0x6c696768u),
                        points.sample[i] * light_samples + n);
        const Vec2 u = sampler.next2();
        const UnoccludedLight l = sample_direct_light(tracer.scene(), point, points.bsdf[i], points.wo[i], kBroad, u.x,
                                                      {sampler.next1(), u.y}, static_cast<float>(light_samples),
                                                      static_cast<float>(gather_rays));
        if (is_black(l.radiance)) continue;
        rays.push_back(l.shadow_ray);
        light.push_back(points.throughput[i] * l.radiance / static_cast<float>(light_samples));
        slot.push_back(points.slot[i]);
      }
    }
    std::vector<std::uint8_t> hidden(rays.size());
    tracer.occluded(rays, hidden, RayOrder::incoherent);
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (!hidden[i]) radiance.direct[slot[i]] += light[i];
    statistics.add(Counter::occlusion_rays, rays.size());
  });
}

}  // namespace glowworm
