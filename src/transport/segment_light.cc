#include "transport/segment_light.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

/// Places on a line by the angle under which a point beside it sees them.
struct Angles {
  float foot, height, first, last;  // metres along the ray, metres from it, radians

  Angles(const Ray& ray, MediumSpan span, Vec3 lamp) {
    const Vec3 way = lamp - ray.origin;
    foot = dot(way, ray.direction);
    height = length(way - ray.direction * foot);
    first = std::atan2(span.first - foot, height);
    last = std::atan2(span.last - foot, height);
  }
  bool valid() const { return height > 0 && first < last; }
  float place(float u) const { return foot + height * std::tan(std::lerp(first, last, u)); }
  /// Per metre.
  float pdf(float distance) const {
    const float t = distance - foot;
    return height / ((last - first) * (height * height + t * t));
  }
};

/// Whether a source is a lamp at finite distance.
bool is_near(const Scene& scene, std::uint32_t source) {
  const std::size_t triangles = scene.emissive_triangles().size();
  if (source < triangles) return true;
  return source < triangles + scene.lights().size() &&
         scene.lights()[source - triangles].kind != LightKind::directional;
}

}  // namespace

LitSegment::LitSegment(const Medium& medium, const PathState& path, float length, bool always) {
  span_ = span_in(medium, path.ray.origin, path.ray.direction, 0, length);
  if (span_.empty()) return;
  medium_ = &medium;
  always_ = always;
  ray_ = path.ray;
  inside_ = {path.medium.index, true};
  throughput_ = path.throughput;
  const float free = 1 / std::max(greatest_extinction(medium), 1e-30f);
  middle_ = at(span_.first + std::min(0.5f * (span_.last - span_.first), free));
}

RGB LitSegment::density_of_places(float distance) const {
  const RGB sigma_t = medium_->sigma_a + medium_->sigma_s;
  RGB density = sigma_t * transmittance(sigma_t, distance - span_.first);
  if (!always_) return density;
  const RGB stopped = opacity(sigma_t, span_.last - span_.first);
  for (int c = 0; c < 3; ++c) density[c] = stopped[c] > 0 ? density[c] / stopped[c] : 0.0f;
  return density;
}

float LitSegment::transmittance_pdf(float distance) const {
  return mean_over_channels(throughput_, density_of_places(distance));
}

RGB LitSegment::reaching(float distance) const {
  return medium_->sigma_s * transmittance(medium_->sigma_a + medium_->sigma_s, distance - span_.first);
}

MediumVertex LitSegment::vertex_at(float distance) const {
  return {at(distance), -ray_.direction, medium_->g, inside_, ray_.time};
}

SegmentLight LitSegment::sample(const Scene& scene, Vec2 u_lamp, Vec2 u_place) const {
  SegmentLight out;
  LightSelector::AtPoint lamps(scene.light_selector(), middle_);
  const LightSelector::Choice choice = lamps.choose(u_lamp.x);
  if (!(choice.probability > 0) || !is_near(scene, choice.source)) return out;
  const Vec2 on_lamp{u_place.x, u_lamp.y};
  const Vec3 lamp = sample_light_of(scene, choice.source, middle_, on_lamp).position;
  const Angles angles(ray_, span_, lamp);
  if (!angles.valid()) return out;
  out.distance = std::clamp(angles.place(u_place.y), span_.first, span_.last);
  out.by_transmittance = transmittance_pdf(out.distance);
  out.vertex = vertex_at(out.distance);
  out.sample = sample_light_of(scene, choice.source, out.vertex.position, on_lamp);
  out.sample.source = choice.source;
  out.by_place = out.sample.pdf * scene.light_selector().probability(out.vertex.position, choice.source);
  out.sample.pdf *= choice.probability * angles.pdf(out.distance);
  out.weight = reaching(out.distance);
  return out;
}

SegmentLight LitSegment::sample_by_transmittance(const Scene& scene, Vec2 u_lamp, Vec2 u_place) const {
  SegmentLight out;
  if (!medium_) return out;
  if (is_homogeneous(*medium_)) {
    const RGB sigma_t = medium_->sigma_a + medium_->sigma_s;
    const int channel = choose_channel(throughput_, u_place.x);
    const float stopped = opacity(sigma_t, span_.last - span_.first)[channel];
    if (!(stopped > 0)) return out;
    out.distance = std::min(span_.first - std::log1p(-u_place.y * stopped) / sigma_t[channel], span_.last);
    out.weight = reaching(out.distance) / transmittance_pdf(out.distance);
  } else {
    const MediumSample scattering = sample_medium(*medium_, ray_, span_.last, throughput_, u_place);
    if (!scattering.scatters) return out;
    out.distance = scattering.distance;
    out.weight = scattering.weight;
  }
  out.vertex = vertex_at(out.distance);
  out.sample = sample_light(scene, out.vertex.position, u_lamp.x, {u_place.x, u_lamp.y});
  return out;
}

float LitSegment::ratio(const Scene& scene, std::uint32_t source, float distance, Vec3 lamp) const {
  if (!samples() || !is_near(scene, source)) return 0;
  const Angles angles(ray_, span_, lamp);
  const float own = scene.light_selector().probability(at(distance), source), pdf = transmittance_pdf(distance);
  if (!angles.valid() || !(own > 0) || !(pdf > 0)) return 0;
  return scene.light_selector().probability(middle_, source) / own * angles.pdf(distance) / pdf;
}

}  // namespace glowworm
