#include "gather/direct_light.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "kernels/sobol.h"

namespace glowworm {

std::uint32_t default_light_samples(std::uint32_t gather_rays) {
  return std::clamp<std::uint32_t>(2 * gather_rays / 3, 2, 32);
}

void add_direct_light(const Tracer& tracer, const GatherPoints& points, const DirectLightSettings& settings,
                      SlotRadiance& radiance, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::direct);
  const std::uint32_t light_samples = settings.light_samples, seed = settings.seed;
  if (light_samples == 0) return;
  const auto lights_each = static_cast<float>(light_samples), rays_each = static_cast<float>(settings.gather_rays);
  const Scene& scene = tracer.scene();
  parallel_for(0, points.size(), even_grain(points.size()), [&](std::size_t first, std::size_t last) {
    LightAdder adder(tracer, radiance);
    std::vector<std::uint32_t> index(light_samples);
    std::vector<float> u_light(light_samples), u_x(light_samples), u_y(light_samples), unused(light_samples);
    for (std::size_t i = first; i < last; ++i) {
      const Vertex vertex = vertex_of(points, i);
      std::iota(index.begin(), index.end(), points.sample[i] * light_samples);
      const std::uint32_t sequence = hash_combine(points.sequence[i], kLightStream);
      sobol_pairs(Sampler::pair_key(seed, sequence, 0), index.data(), light_samples, u_light.data(), u_y.data());
      sobol_pairs(Sampler::pair_key(seed, sequence, 1), index.data(), light_samples, u_x.data(), unused.data());
      const GatherDensity density(points, i, settings.guide);
      LightSelector::AtPoint lights(scene.light_selector(), vertex.point.position);
      for (std::uint32_t n = 0; n < light_samples; ++n) {
        const LightSample sample = sample_light(scene, vertex.point.position, lights, u_light[n], {u_x[n], u_y[n]});
        if (sample.delta && !settings.delta_lights) continue;
        if (sample.is_directional() && !settings.directional) continue;
        UnoccludedLight light = reflected_light(sample, vertex, kBroad, lights_each, rays_each,
                                                [&](Vec3 w) { return density.weighing_pdf(w); });
        light.radiance = points.throughput[i] * light.radiance / lights_each;
        adder.wait(points.slot[i], light);
      }
    }
    adder.add_waiting(radiance.direct);
    statistics.add(Counter::occlusion_rays, adder.shadow_rays);
  });
}

}  // namespace glowworm
