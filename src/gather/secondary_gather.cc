// The part of GatherPolicy that gathers again where rays are short.
#include <algorithm>

#include "gather/gather_policy.h"

namespace glowworm {

/// Secondary gather: caustics by their map, all other light by one more ray, whose direct light is weighted against
/// that of one light sample. The sample alone would have no bound where a light touches a corner. Roulette ends rays
/// that are short again. Glossy lobes are always gathered: few photons lie in their directions, and estimates on curved
/// parts count photons whose directions lie behind the surface at the end of the ray.
bool GatherPolicy::gather_again(GatherPath& path, Vertex& vertex, Lobes lobes) {
  // Most likely survival of a ray that is short again: white rooms smaller than the photons' radius would never end.
  constexpr float kMostSurvival = 0.9f;
  Sampler sampler = sampler_of(path, kGatherAgainStream + step_);
  const Vec2 u_light = sampler.next2();
  const LightSample sample = sample_light(scene_, vertex, u_light, sampler.next1());
  if (!settings_.photons_alone)
    lights_.add(radiance_.indirect, slot(path), path.throughput, reflected_light(sample, vertex, lobes, lobes));
  if (caustic_queries_) add_query(*caustic_queries_, vertex, path.throughput, slot(path), lobes);
  const float u_lobe = sampler.next1();
  Vec2 u = sampler.next2();
  float factor = guide(vertex, u);
  const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, u, lobes);
  if (path.segment == Segment::secondary) {
    const float survival = std::min(max_component(s.weight * factor), kMostSurvival);
    if (!(sampler.next1() < survival)) return false;
    factor /= survival;
  }
  path.throughput *= factor;
  return leave_for(path, vertex, s, Segment::secondary);
}

/// Warps the random numbers of a ray from a diffuse point where the guide knows more light, and turns the point's frame
/// to the guide's. Returns the factor on the ray's weight.
float GatherPolicy::guide(Vertex& vertex, Vec2& u) const {
  if (!settings_.guide || !is_lambertian(vertex.bsdf)) return 1;
  const Vec3 normal = face_forward(vertex.point.frame.n, vertex.wo);
  const std::uint32_t region = settings_.guide->region(vertex.point.position, normal);
  if (region == kNone) return 1;
  vertex.point.frame = GatherGuide::frame(normal);
  return settings_.guide->warp(region, u);
}

}  // namespace glowworm
