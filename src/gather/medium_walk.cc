#include "gather/medium_walk.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

/// Parts of equal opacity into which a gather ray's way through a homogeneous medium is divided: one of them is looked
/// up. The rays of a point together see all parts, and a lookup costs as the length of its segment.
constexpr float kParts = 8;

/// Whether lamps are at finite distance, so that places by their angle are sampled, too.
bool has_near_lamps(const Scene& scene) {
  return !scene.emissive_triangles().empty() ||
         std::any_of(scene.lights().begin(), scene.lights().end(),
                     [](const Light& light) { return light.kind != LightKind::directional; });
}

}  // namespace

MediumWalk::MediumWalk(const Tracer& tracer, SlotRadiance& radiance, LightAdder& lights, VolumeSegments& segments,
                       bool photons_alone)
    : tracer_(tracer),
      radiance_(radiance),
      lights_(lights),
      segments_(segments),
      photons_alone_(photons_alone),
      has_near_lamps_(has_near_lamps(tracer.scene())) {}

bool MediumWalk::cross(PathState& path, Hit& hit, RayOrder order, const Target& target, Sampler& sampler) {
  return travel(tracer_, path, hit, order, [&](const Medium* medium, float length) {
    if (!medium) return true;
    if (target.part) add_light(*medium, path, length, target, sampler);
    for_even_pieces(*medium, path.ray, length, [&](float first, float last, const MediumPoint& here) {
      path.throughput *= transmittance(here.sigma_a + here.sigma_s, last - first);
    });
    return !is_black(path.throughput);
  });
}

void MediumWalk::add_light(const Medium& medium, const PathState& path, float length, const Target& target,
                           Sampler& sampler) {
  RGB passed(1.0f), emitted(0.0f);
  bool scatters = false;
  for_even_pieces(medium, path.ray, length, [&](float first, float last, const MediumPoint& here) {
    const RGB sigma_t = here.sigma_a + here.sigma_s, stopped = opacity(sigma_t, last - first);
    for (int c = 0; c < 3; ++c)
      if (here.emission[c] > 0) emitted[c] += passed[c] * here.emission[c] * stopped[c] / sigma_t[c];
    scatters |= !is_black(here.sigma_s);
    passed *= transmittance(sigma_t, last - first);
  });
  if (!is_black(emitted) && !photons_alone_)
    radiance_.add(*target.part, target.slot, path.throughput * emitted,
                  tracer_.scene().source_of_medium(path.medium.index));
  if (!scatters) return;
  RGB throughput = path.throughput;
  const float stopped = max_component(RGB(1.0f) - passed);
  if (target.by_opacity) {
    if (!(sampler.next1() < stopped)) return;
    throughput *= 1 / stopped;
  }
  const Vec2 random = sampler.next2();
  const float parts = target.by_opacity ? kParts : std::clamp(std::floor(kThinOpacity / stopped), 1.0f, kParts);
  if (parts > 1 && is_homogeneous(medium))
    add_part(medium, path, length, throughput, target, parts, random);
  else
    add_segments(medium, path, length, throughput, target, random.y);
  if (photons_alone_) return;
  // In other media, only samples that scatter cost anything, so their number falls with the opacity already.
  const float share = is_homogeneous(medium) ? std::min(stopped / kThinOpacity, 1.0f) : 1.0f;
  // A camera ray samples lamps at 16 places on each piece of its way, since a shaft of light covers a part of them; on
  // pieces thinner than kThinOpacity at fewer, and it looks up a part of the piece.
  const float places = std::ceil(16 * share);
  sample_lamps(LitSegment(medium, path, length, true), throughput, target, target.by_opacity ? 1 : places, sampler);
}

void MediumWalk::sample_lamps(const LitSegment& segment, RGB throughput, const Target& target, float places,
                              Sampler& sampler) {
  const Scene& scene = tracer_.scene();
  const bool by_angle_too = segment.samples() && has_near_lamps_;
  const float count = by_angle_too ? std::ceil(places / 2) : places;
  const Vec2 start = sampler.next2();
  for (float i = 0; i < count; ++i) {
    const Vec2 u_lamp = sampler.next2(), u_other_lamp = sampler.next2(), u = sampler.next2();
    const SegmentLight by_place = segment.sample_by_transmittance(scene, u_lamp, {u.x, (i + start.x) / count});
    if (by_place.sample.pdf > 0) {
      const LightSample& light = by_place.sample;
      const float ratio = segment.ratio(scene, light.source, by_place.distance, light.position);
      add(by_place, 1 / ((1 + ratio) * count), throughput, target);
    }
    if (!by_angle_too) continue;
    const SegmentLight by_angle = segment.sample(scene, u_other_lamp, {u.y, (i + start.y) / count});
    if (by_angle.sample.pdf > 0)
      add(by_angle, balance_heuristic(1, by_angle.sample.pdf, 1, by_angle.by_place * by_angle.by_transmittance) / count,
          throughput, target);
  }
}

void MediumWalk::add_segments(const Medium& medium, const PathState& path, float length, RGB throughput,
                              const Target& target, float random) {
  for_even_pieces(medium, path.ray, length, [&](float first, float last, const MediumPoint& here) {
    const RGB sigma_t = here.sigma_a + here.sigma_s;
    segments_.push_back(path.ray.origin + path.ray.direction * first, path.ray.direction, last - first,
                        {sigma_t, here.sigma_s, medium.g, path.medium.index, random}, throughput, target.slot);
    throughput *= transmittance(sigma_t, last - first);
  });
}

void MediumWalk::add_part(const Medium& medium, const PathState& path, float length, RGB throughput,
                          const Target& target, float parts, Vec2 random) {
  const MediumSpan span = span_in(medium, path.ray.origin, path.ray.direction, 0, length);
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  const float most = max_component(sigma_t), stopped = max_component(opacity(sigma_t, span.last - span.first));
  const float part = std::floor(random.x * parts);
  const auto end_of = [&](float before) {
    return std::min(-std::log1p(-stopped * before / parts) / most, span.last - span.first);
  };
  const float first = end_of(part), last = part + 1 < parts ? end_of(part + 1) : span.last - span.first;
  segments_.push_back(path.ray.origin + path.ray.direction * (span.first + first), path.ray.direction, last - first,
                      {sigma_t, medium.sigma_s, medium.g, path.medium.index, random.y},
                      throughput * transmittance(sigma_t, first) * parts, target.slot);
}

void MediumWalk::add(const SegmentLight& light, float weight, RGB throughput, const Target& target) {
  lights_.add(*target.part, target.slot, throughput * light.weight,
              scattered_light(light.sample, light.vertex, weight));
}

}  // namespace glowworm
