#include "gather/gather_policy.h"

#include <algorithm>

namespace glowworm {

namespace {

/// Least radius of the spot that rays of a narrow lobe may meet, in radii of photons. An estimate has the noise of
/// some fifty photons, which rays average if they spread over several discs.
constexpr float kSpotRadii = 3;

/// Whether light that a ray meets is direct light of the gather point, which light samples bring, too.
bool is_direct(Segment s) { return s == Segment::first || s == Segment::through_panes; }
bool is_second(Segment s) { return s == Segment::secondary || s == Segment::secondary_chain; }

}  // namespace

GatherPolicy::GatherPolicy(const Tracer& tracer, const GatherPoints& points, const FinalGatherSettings& settings,
                           const GatherRayMaker& maker, SlotRadiance& radiance, LightAdder& lights,
                           QueryPoints& queries, QueryPoints* caustic_queries)
    : scene_(tracer.scene()),
      points_(points),
      settings_(settings),
      maker_(maker),
      radiance_(radiance),
      lights_(lights),
      queries_(queries),
      caustic_queries_(caustic_queries) {}

bool GatherPolicy::advance(GatherPath& path, const Hit& hit, std::uint32_t step) {
  step_ = step;
  if (path.segment == Segment::to_patch && !meets_patch(path, hit)) return false;
  if (hit.triangle != kNone) {
    if (settings_.looks_at_patches() && path.segment == Segment::first)
      path.throughput *= patch_weight(scene_, *settings_.bright, path, hit, settings_.rays, settings_.patch_samples);
    if (ends_on_diffuse(path, hit)) return false;
  }
  return meet(
      scene_, path, hit, counts_light(path),
      [&](RGB light, std::uint32_t source, const auto& density) { add_light(path, light, source, density); },
      [&] { return number(path, kWavelengthStream + path.bounces); },
      [&](Vertex& vertex) { return scatter(path, vertex, hit.distance); });
}

bool GatherPolicy::meets_patch(const GatherPath& path, const Hit& hit) const {
  return hit.triangle != kNone && settings_.bright->find(hit.triangle, hit.barycentric) == path.patch;
}

Sampler GatherPolicy::sampler_of(const GatherPath& path, std::uint32_t stream) const {
  const std::uint32_t p = path.point;
  return {SamplerKind::sobol, settings_.seed, hash_combine(hash_combine(points_.sequence[p], stream), path.stratum),
          points_.sample[p]};
}

float GatherPolicy::number(const GatherPath& path, std::uint32_t what) const {
  return gather_ray_number(points_, path.point, path.stratum, settings_.seed, what);
}

/// If a ray ends on a surface that only reflects diffusely, as most do, makes it a query point and returns true.
bool GatherPolicy::ends_on_diffuse(const GatherPath& path, const Hit& hit) {
  DiffusePoint point;
  if (!diffuse_vertex(scene_, hit, point) || is_short(path, hit.distance, point.position)) return false;
  add_query(queries_, point, -path.ray.direction, path.throughput, slot(path));
  return true;
}

/// Whether the photons' radius at `position`, where a ray ends, is large beside the ray's length, or beside the spot
/// that rays of its lobe meet there. Then it gathers again: the estimates of a point's rays would all be blurred, or be
/// of the same few photons.
bool GatherPolicy::is_short(const GatherPath& path, float distance, Vec3 position) const {
  const bool first = path.segment == Segment::first;
  const bool is_counted =
      first || path.segment == Segment::to_patch || (settings_.gathers_on && path.segment == Segment::secondary);
  if (!settings_.radii || !is_counted) return false;
  const float narrowness = first ? std::max(kPi * path.pdf - 1, 0.0f) : 0.0f;
  const float length_squared = distance * distance / (1 + kSpotRadii * kSpotRadii * narrowness);
  const auto reaches = [&](float radius) { return length_squared < radius * radius; };
  return reaches(settings_.radii->max_radius()) && reaches(settings_.radii->radius(position));
}

/// Whether the light that a ray meets is added.
bool GatherPolicy::counts_light(const GatherPath& path) const {
  if (is_direct(path.segment)) return settings_.light_samples > 0;
  if (path.segment == Segment::chain) return settings_.adds_caustics;
  if (path.segment == Segment::to_patch || settings_.photons_alone) return false;
  return path.segment == Segment::secondary || !caustic_queries_;
}

/// Adds that light. A ray straight from the gather point, or from a secondary gather, is a sample of direct light
/// there, and is weighted against the light samples.
template <typename Density>
void GatherPolicy::add_light(const GatherPath& path, RGB emitted, std::uint32_t source, const Density& density) {
  float weight = 1;
  if (is_direct(path.segment))
    weight = balance_heuristic(static_cast<float>(settings_.rays),
                               maker_.density(path.point).weighing_pdf(path.ray.direction),
                               static_cast<float>(settings_.light_samples), density(points_.position[path.point]));
  else if (path.segment == Segment::secondary)
    weight = weight_of_met_light(path, density);
  std::vector<RGB>& part = is_direct(path.segment)   ? radiance_.direct
                           : is_second(path.segment) ? radiance_.indirect
                                                     : radiance_.caustic;
  radiance_.add(part, slot(path), path.throughput * emitted * weight, source);
}

/// Chooses diffuse, glossy or specular lobes.
bool GatherPolicy::scatter(GatherPath& path, Vertex& vertex, float distance) {
  if (is_lambertian(vertex.bsdf)) return arrive(path, vertex, distance);
  // A secondary ray exists only for some numbers of the rays before it, so it needs another one.
  const std::uint32_t first_choice = kSplitStream + path.bounces;
  const float before = max_component(path.throughput),
              u = number(path, is_second(path.segment) ? hash_combine(first_choice, step_) : first_choice);
  const LobeChoice choice = vertex.surface().choose_lobes(vertex.wo, u);
  if (!(choice.probability > 0)) return false;
  path.throughput *= 1 / choice.probability;
  if (choice.lobes == kDiffuse) return arrive(path, vertex, distance);
  return choice.lobes == kGlossy ? gather_again(path, vertex, kGlossy) : follow(path, vertex, before);
}

/// Ends on a diffuse lobe, as query points, unless the ray is short.
bool GatherPolicy::arrive(GatherPath& path, Vertex& vertex, float distance) {
  if (is_short(path, distance, vertex.point.position)) return gather_again(path, vertex, kDiffuse);
  add_query(queries_, vertex, path.throughput, slot(path), kDiffuse);
  return false;
}

/// Sends a ray on from a vertex. Returns whether it has anywhere to go.
bool GatherPolicy::leave_for(GatherPath& path, const Vertex& vertex, const ScatteredRay& s, Segment next) {
  if (!s.is_null)
    path.segment = next;
  else if (path.segment == Segment::to_patch || path.segment == Segment::first)
    path.segment = Segment::through_panes;
  return leave(path, vertex, s, s.weight);
}

/// Continues through the specular lobes. @param before largest component of the throughput that arrived
bool GatherPolicy::follow(GatherPath& path, const Vertex& vertex, float before) {
  Sampler sampler = sampler_of(path, kSpecularStream + ++path.bounces);
  const float u_lobe = sampler.next1();
  const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler.next2(), kSpecular);
  if (!leave_for(path, vertex, s, is_second(path.segment) ? Segment::secondary_chain : Segment::chain)) return false;
  path.chain *= max_component(path.throughput) / before;
  const float probability =
      survive(path, path.chain, kLeastOfChains, static_cast<int>(path.bounces), [&] { return sampler.next1(); });
  if (probability > 0) path.chain /= probability;
  return probability > 0;
}

}  // namespace glowworm
