#include "control/path_policy.h"

#include <limits>

#include "transport/step.h"

namespace glowworm {

PathPolicy::PathPolicy(const Tracer& tracer, const RenderSettings& settings, Sampler sampler, std::uint32_t slot,
                       SlotRadiance& radiance, FirstHit& first_hit, LightAdder& lights, PathLookups* lookups)
    : tracer_(tracer),
      scene_(tracer.scene()),
      settings_(settings),
      sampler_(sampler),
      slot_(slot),
      radiance_(radiance),
      first_hit_(first_hit),
      lights_(lights),
      lookups_(lookups) {}

void PathPolicy::trace_from(const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
  mark_point(grid, cell, first_hit_, slot_);
  const Vertex vertex = white_vertex(tracer_, grid, cell, sample);
  state_.throughput = RGB(kPi);
  start_ = kPi;
  add_sampled_light(vertex);
  if (lookups_ && !grid.on_surfaces)
    lookups_->air.push_back(air_point(scene_, grid, cell, slot_));
  else
    add_lookup(vertex);
  if (go_on(vertex)) follow(1);
}

void PathPolicy::trace_from(const CameraRay& camera, PathMedium medium) {
  state_.ray = {camera.origin, 0, camera.direction, std::numeric_limits<float>::infinity()};
  state_.medium = medium;
  start_at_ = camera.origin;
  follow(0);
}

/// @param first_bounce number of surfaces before
void PathPolicy::follow(int first_bounce) {
  bounce_ = first_bounce;
  for (bool goes_on = true; goes_on; ++bounce_) {
    Hit hit = tracer_.intersect(state_.ray, order());
    const End end = scene_.crosses_media() ? cross(hit) : End::surface;
    if (bounce_ == 0 && !history_.in_medium)
      first_hit_.see(slot_, hit, length(state_.ray.origin - start_at_) + length_to(hit));
    goes_on = end == End::scattering;
    if (end == End::surface)
      goes_on = meet(
          scene_, state_, hit, true,
          [&](RGB light, std::uint32_t source, const auto& density) { add_light(light, source, density); },
          [&] { return sampler_.next1(); }, [&](const Vertex& vertex) { return scatter(vertex); });
  }
}

template <typename Density>
void PathPolicy::add_light(RGB light, std::uint32_t source, const Density& density) {
  float weight = weight_of_met_light(state_, density);
  if (segment_.samples() && state_.pdf > 0) {
    const float by_segment = segment_.ratio(scene_, source, on_segment_, met_at_);
    weight = balance_heuristic(1, state_.pdf, 1, density(state_.scattered_at) * (1 + by_segment));
  }
  radiance_.add(history_.part(radiance_), slot_, state_.throughput * light * weight, source);
}

bool PathPolicy::scatter(const Vertex& vertex) {
  if (bounce_ == 0) first_hit_.see(slot_, vertex);
  if (bounce_ >= settings_.max_bounces) return false;
  add_sampled_light(vertex);
  add_lookup(vertex);
  return go_on(vertex);
}

/// Next-event estimation, separately for each kind of lobe, whose light belongs to different layers.
void PathPolicy::add_sampled_light(const Vertex& vertex) {
  const Vec2 pair = sampler_.next2();
  const float u = sampler_.next1();
  if (!takes_light_samples(vertex.bsdf)) return;
  const LightSample sample = sample_light(scene_, vertex, pair, u);
  for (const Lobes which : {kBroad, kSpecular})
    if (vertex.has(which))
      lights_.add(history_.with_bounce(which, false).part(radiance_), slot_, state_.throughput,
                  reflected_light(sample, vertex, which, kAllLobes));
}

void PathPolicy::add_lookup(const Vertex& vertex) {
  // Light that photons bring has met one surface at least before the one that is looked up.
  if (!lookups_ || !vertex.has(kBroad) || bounce_ + 1 >= settings_.max_bounces) return;
  add_query(history_.gathered ? lookups_->indirect : lookups_->caustic, vertex, state_.throughput, slot_);
}

/// Continues in a direction sampled from the BSDF; false if the path ends.
bool PathPolicy::go_on(const Vertex& vertex) {
  const float u_lobe = sampler_.next1();
  const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler_.next2(), kAllLobes);
  if (!leave(state_, vertex, s, s.weight) || !survives()) return false;
  if (s.is_null) return true;  // shadow rays pass through panes, too
  history_ = history_.with_bounce(s.lobe, s.delta);
  segment_ = {};
  return true;
}

bool PathPolicy::survives() {
  const float weight = max_component(state_.throughput) / start_;
  return survive(state_, weight, kLeastOfPaths, bounce_ + 1, [&] { return sampler_.next1(); }) > 0;
}

}  // namespace glowworm
