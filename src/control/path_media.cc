// The part of PathPolicy that takes paths through media.
#include <limits>

#include "control/path_policy.h"
#include "gather/medium_walk.h"

namespace glowworm {

/// Takes the path through media to the next surface, or to where it scatters on the way.
PathPolicy::End PathPolicy::cross(Hit& hit) {
  bool scatters = false;
  const bool arrives = travel(tracer_, state_, hit, order(), [&](const Medium* medium, float length) {
    if (!medium) return true;
    const LitSegment segment(*medium, state_, length);
    add_segment_light(segment);
    add_lookup(*medium, length);
    const MediumSample sample = sample_medium(*medium, state_.ray, length, state_.throughput, sampler_.next2());
    if (!is_black(sample.emitted))
      radiance_.add(history_.with_medium().part(radiance_), slot_, state_.throughput * sample.emitted,
                    scene_.source_of_medium(state_.medium.index));
    state_.throughput *= sample.weight;
    if (sample.scatters && bounce_ == 0) see_behind(hit);
    if (sample.scatters) scatters = scatter_in(*medium, segment, sample.distance);
    return !sample.scatters;
  });
  met_at_ = state_.ray.origin + state_.ray.direction * hit.distance;
  return arrives ? End::surface : scatters ? End::scattering : End::nothing;
}

/// Records the surface straight behind the place where a camera ray scatters. @param hit of the path's ray
void PathPolicy::see_behind(Hit hit) {
  PathState path = state_;
  travel(tracer_, path, hit, order(), [](const Medium*, float) { return true; });
  first_hit_.see(slot_, hit, length(path.ray.origin - start_at_) + length_to(hit));
  if (hit.triangle == kNone) return;
  Vertex vertex = vertex_at(scene_, path.ray, hit);
  vertex.media = media_at(scene_, path.medium, hit.triangle, vertex.wo);
  resolve_material(scene_, vertex, path.throughput, [&] { return sampler_.next1(); });
  first_hit_.see(slot_, vertex);
}

/// Scatters the path in a medium; false if it ends.
bool PathPolicy::scatter_in(const Medium& medium, const LitSegment& segment, float distance) {
  if (is_black(state_.throughput) || bounce_ >= settings_.max_bounces) return false;
  const Ray& ray = state_.ray;
  const MediumVertex vertex{
      ray.origin + ray.direction * distance, -ray.direction, medium.g, {state_.medium.index, true}, ray.time};
  history_ = history_.with_medium();
  segment_ = segment;
  on_segment_ = distance;
  const Vec2 pair = sampler_.next2();
  const LightSample light = sample_light(scene_, vertex.position, pair.x, {sampler_.next1(), pair.y});
  if (light.pdf > 0) {
    const float others = (light.delta ? 0.0f : vertex.phase(light.direction)) +
                         light.pdf * segment.ratio(scene_, light.source, distance, light.position);
    lights_.add(history_.part(radiance_), slot_, state_.throughput,
                scattered_light(light, vertex, balance_heuristic(1, light.pdf, 1, others)));
  }
  const Vec3 direction = vertex.sample(sampler_.next2());
  state_.pdf = vertex.phase(direction);
  state_.scattered_at = vertex.position;
  state_.medium = vertex.medium;
  state_.ray = {vertex.position, 0, direction, std::numeric_limits<float>::infinity(), vertex.time};
  return survives();
}

/// Light of lamps that the medium scatters along a piece of the path, sampled by their place.
void PathPolicy::add_segment_light(const LitSegment& segment) {
  if (!segment.samples() || bounce_ >= settings_.max_bounces) return;
  const Vec2 u = sampler_.next2();
  const SegmentLight light = segment.sample(scene_, u, sampler_.next2());
  if (!(light.sample.pdf > 0)) return;
  const float others = light.by_place + (light.sample.delta ? 0.0f : light.vertex.phase(light.sample.direction));
  const float weight = balance_heuristic(1, light.sample.pdf, 1, others * light.by_transmittance);
  lights_.add(history_.with_medium().part(radiance_), slot_, state_.throughput * light.weight,
              scattered_light(light.sample, light.vertex, weight));
}

/// Looks up the light that photons bring to a piece of the path's way.
void PathPolicy::add_lookup(const Medium& medium, float length) {
  // The photons have met a surface at least, and scatter here once more.
  if (!lookups_ || bounce_ + 1 >= settings_.max_bounces) return;
  std::vector<RGB>& part = history_.with_medium().part(radiance_);
  VolumeSegments& segments = &part == &radiance_.medium ? lookups_->in_media : lookups_->indirect_in_media;
  MediumWalk(tracer_, radiance_, lights_, segments, true)
      .add_light(medium, state_, length, {&part, slot_, true}, sampler_);
}

}  // namespace glowworm
