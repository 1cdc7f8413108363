#include "gather/direct_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "kernels/sobol.h"

namespace glowworm {

namespace {
/// Gather points per piece of parallel work.
constexpr std::size_t kPointsPerChunk = 256;
/// Relative error of a shadow ray's length and direction: 16 half units in the last place.
constexpr float kShadowError = 0x1p-20f;

/// The ray from a point to a place on a light, both offset from their surfaces. If rounding leaves nothing between
/// them, the ray meets nothing.
/// @param side the geometric normal on the side of the light
Ray shadow_ray(const SurfacePoint& point, Vec3 side, const LightSample& light) {
  const Vec3 from = offset_origin(point.position, side, point.offset);
  if (!std::isfinite(light.distance)) return {from, 0, light.direction, light.distance};
  const float before_light = light.offset + kShadowError * light.distance;
  const Vec3 way = offset_origin(light.position, light.normal, before_light) - from;
  const float distance = length(way);
  const bool crossed = !(dot(way, side) > 0) || (!light.delta && !(dot(way, light.normal) < 0));
  if (crossed) return {from, 0, light.direction, 0};
  // A point light has no side to offset to.
  return {from, 0, way / distance, light.delta ? distance * (1 - kShadowError) : distance};
}

/// Share of a light sample that the volume between the light and the point leaves.
RGB remaining(const Scene& scene, const LightSample& light, const SurfacePoint& point) {
  if (point.triangle == kNone || !std::isfinite(light.distance)) return RGB(1.0f);
  const std::vector<std::uint32_t>& lamps = scene.emissive_triangles();
  const RGB arrived =
      light.source < lamps.size() ? absorption(scene, lamps[light.source], -light.direction) : RGB(0.0f);
  return transmittance(absorption(scene, point.triangle, light.direction), arrived, light.distance);
}
}  // namespace

UnoccludedLight reflected_light(const Scene& scene, const LightSample& light, const SurfacePoint& point,
                                const Bsdf& bsdf, Vec3 wo, Lobes lobes, LightSampleCounts counts,
                                const GatherDensity* density) {
  UnoccludedLight out;
  if (!(light.pdf > 0) || is_black(light.radiance)) return out;
  const ShadedSurface surface = shaded(point, bsdf);
  const RGB scattered = surface.evaluate(wo, light.direction, lobes);
  if (is_black(scattered)) return out;
  float weight = 1;
  if (!light.delta && counts.directions > 0)
    weight =
        balance_heuristic(counts.light, light.pdf, counts.directions,
                          density ? density->weighing_pdf(light.direction) : surface.pdf(wo, light.direction, lobes));
  out.radiance = scattered * light.radiance * (weight / light.pdf) * remaining(scene, light, point);
  out.source = light.source;
  out.shadow_ray = shadow_ray(point, face_forward(point.geometric_normal, light.direction), light);
  return out;
}

bool takes_light_samples(const Bsdf& bsdf) {
  const bool one_roughness = bsdf.kind == BsdfKind::conductor || bsdf.kind == BsdfKind::dielectric;
  return !(bsdf.kind == BsdfKind::thin_dielectric ||
           (one_roughness && std::max(bsdf.alpha_x, bsdf.alpha_y) < kSmoothAlpha));
}

std::uint32_t default_light_samples(std::uint32_t gather_rays) {
  return std::clamp<std::uint32_t>(gather_rays / 3, 2, 16);
}

void add_direct_light(const Tracer& tracer, const GatherPoints& points, std::uint32_t seed, std::uint32_t light_samples,
                      std::uint32_t gather_rays, const GatherGuide* guide, SlotRadiance& radiance,
                      Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::direct);
  if (light_samples == 0) return;
  const LightSampleCounts counts{static_cast<float>(light_samples), static_cast<float>(gather_rays)};
  const Scene& scene = tracer.scene();
  parallel_for(0, points.size(), kPointsPerChunk, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> rays;
    std::vector<RGB> light;
    std::vector<std::uint32_t> slot, source, index(light_samples);
    std::vector<float> u_light(light_samples), u_x(light_samples), u_y(light_samples), unused(light_samples);
    for (std::size_t i = first; i < last; ++i) {
      SurfacePoint point;
      point.position = points.position[i];
      point.geometric_normal = points.normal[i];
      point.offset = points.offset[i];
      point.frame = points.frame[i];
      std::iota(index.begin(), index.end(), points.sample[i] * light_samples);
      const std::uint32_t sequence = hash_combine(points.sequence[i], kLightStream);
      sobol_pairs(Sampler::pair_key(seed, sequence, 0), index.data(), light_samples, u_light.data(), u_y.data());
      sobol_pairs(Sampler::pair_key(seed, sequence, 1), index.data(), light_samples, u_x.data(), unused.data());
      const GatherDensity density(points, i, guide);
      LightSelector::AtPoint lights(scene.light_selector(), point.position);
      for (std::uint32_t n = 0; n < light_samples; ++n) {
        const LightSample sample = sample_light(scene, point.position, {0, 0, 0}, lights, u_light[n], {u_x[n], u_y[n]});
        const UnoccludedLight l =
            reflected_light(scene, sample, point, points.bsdf[i], points.wo[i], kBroad, counts, &density);
        if (is_black(l.radiance)) continue;
        rays.push_back(l.shadow_ray);
        light.push_back(points.throughput[i] * l.radiance / static_cast<float>(light_samples));
        slot.push_back(points.slot[i]);
        source.push_back(l.source);
      }
    }
    std::vector<RGB> passed(rays.size());
    tracer.transmittance(rays, passed);
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (!is_black(passed[i])) radiance.add(radiance.direct, slot[i], light[i] * passed[i], source[i]);
    statistics.add(Counter::occlusion_rays, rays.size());
  });
}

}  // namespace glowworm
