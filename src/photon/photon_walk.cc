#include "photon/photon_walk.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "bsdf/phase.h"
#include "photon/beams.h"
#include "photon/outside.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// PhotonWalk::images_ of a pass.
std::vector<ImagedLight> images_of_lights(const Scene& scene, const PhotonPassSettings& pass) {
  if (!pass.discs || pass.choice == PhotonChoice::all || !pass.images || pass.images->empty()) return {};
  std::vector<ImagedLight> out(scene.light_power().size());
  for (std::size_t i = 0; i < scene.lights().size(); ++i)
    out[scene.emissive_triangles().size() + i] = pass.images->of(scene.lights()[i]);
  return out;
}

}  // namespace

Box3 looked_at_box(const Scene& scene, const PhotonImportance* importance) {
  Box3 box = scene.bounds();
  if (box.empty()) return box;
  if (importance && !importance->box.empty()) box.grow(importance->box);
  for (const Light& light : scene.lights())
    if (light.kind != LightKind::directional) box.grow(light.position);
  return box;
}

PhotonWalk::PhotonWalk(const Tracer& tracer, const PhotonPassSettings& pass)
    : tracer_(tracer),
      scene_(tracer.scene()),
      pass_(pass),
      looked_at_(looked_at_box(scene_, pass.importance)),
      images_(images_of_lights(scene_, pass)),
      crosses_media_(scene_.crosses_media()),
      names_media_(std::any_of(scene_.materials().begin(), scene_.materials().end(),
                               [](const Material& m) { return m.inside != kUnnamed || m.outside != kUnnamed; })) {}

void PhotonWalk::cross(LightPath& path, Hit& hit, int bounce, PhotonChunk& chunk) const {
  if (!crosses_media_) {
    keep_part(path, hit, {}, true, chunk);
    return keep_segment(path, {0, length_to(hit)}, path.throughput, {}, chunk);
  }
  Sampler sampler(SamplerKind::sobol, pass_.seed,
                  hash_combine(hash_combine(kMediumStream, pass_.pass), static_cast<std::uint32_t>(bounce)),
                  path.number);
  for (;;) {
    MediumSample sample;
    float before = 0;  // largest flux before the piece
    const bool arrives = travel(tracer_, path, hit, RayOrder::incoherent, [&](const Medium* medium, float length) {
      before = max_component(path.throughput);
      sample = cross_piece(medium, path, length, sampler, chunk);
      return !sample.scatters;
    });
    keep_part(path, hit, sample, arrives, chunk);
    if (arrives || !scatter(path, sample.distance, before, bounce, sampler, chunk)) break;
    hit = tracer_.intersect(path.ray);
  }
  if (is_black(path.throughput)) hit.triangle = kNone;
  const PlaceOnPath place{static_cast<std::uint32_t>(bounce), path.in_chunk};
  chunk.in_media_place.resize(chunk.in_media.size(), place);
  chunk.beam_place.resize(chunk.beams.size(), place);
}

/// Keeps a straight part of a path, to its hit, or to where a medium scatters it before. Then, too, the path may depend
/// on the surface that its ray would meet: that may name the medium.
void PhotonWalk::keep_part(const LightPath& path, const Hit& hit, const MediumSample& sample, bool arrives,
                           PhotonChunk& chunk) const {
  if (!pass_.kept) return;
  const auto place = [&](float distance) { return path.ray.origin + path.ray.direction * distance; };
  if (arrives || names_media_) {
    const bool escapes = hit.triangle == kNone;
    chunk.parts.push_back({escapes ? path.ray.direction : place(hit.distance),
                           path.in_chunk | (escapes ? PathPart::kEscapes : 0) | (arrives ? 0 : PathPart::kAside)});
  }
  if (!arrives) chunk.parts.push_back({place(sample.distance), path.in_chunk});
}

/// Whether a path brings the light of an image.
bool PhotonWalk::is_from_image(const LightPath& path) const {
  if (images_.empty() || (path.bounces & kNotSmooth)) return false;
  const ImagedLight& light = images_[path.light];
  return light.has(light.is_far() ? -path.ray.direction : path.image);
}

/// Keeps a straight piece of a path if it crosses discs of the pass.
/// @param piece metres along the path's ray @param flux at its start
void PhotonWalk::keep_segment(const LightPath& path, MediumSpan piece, RGB flux, RGB absorption,
                              PhotonChunk& chunk) const {
  if (piece.empty() || !pass_.discs || !leaves(pass_.choice, path.bounces) || is_from_image(path)) return;
  const Vec3 origin = path.ray.origin + path.ray.direction * piece.first;
  const float length = piece.last - piece.first;
  bool crosses = false;
  pass_.discs->for_crossed(origin, path.ray.direction, length, [&](const DiscCrossing&) {
    crosses = true;
    return false;
  });
  if (!crosses) return;
  chunk.segments.push_back({origin, length, path.ray.direction, path.light, flux, absorption});
  chunk.segment_path.push_back(path.in_chunk);
}

/// Keeps the way of a path through a medium that weakens it, and does not end it by chance, as segments.
/// @param weight factor on its throughput, to the end
void PhotonWalk::keep_weakened(const Medium& medium, const LightPath& path, float length, RGB weight,
                               PhotonChunk& chunk) const {
  const RGB before = path.throughput;
  const MediumSpan inside = span_in(medium, path.ray.origin, path.ray.direction, 0, length);
  if (inside.empty()) return keep_segment(path, {0, length}, before, {}, chunk);
  keep_segment(path, {0, inside.first}, before, {}, chunk);
  keep_segment(path, inside, before, medium.sigma_a, chunk);
  keep_segment(path, {inside.last, length}, before * weight, {}, chunk);
}

/// Whether a path stores photons in media now. For the path tracer it stores only light that no path of the path tracer
/// finds: of lamps without size, by mirrors or glass.
bool PhotonWalk::is_wanted_in_media(const LightPath& path) const {
  if (pass_.choice == PhotonChoice::all) return !is_straight_from_lamp(path.bounces);
  return pass_.choice == PhotonChoice::unseen_by_paths && !pass_.discs && leaves(pass_.choice, path.bounces);
}

/// Takes a path along a piece of its way, and keeps it as beams and a photon. @param medium null: vacuum
MediumSample PhotonWalk::cross_piece(const Medium* medium, LightPath& path, float length, Sampler& sampler,
                                     PhotonChunk& chunk) const {
  if (!medium) {
    keep_segment(path, {0, length}, path.throughput, {}, chunk);
    return {};
  }
  const RGB before = path.throughput;
  const MediumSample sample = sample_medium(*medium, path.ray, length, before, sampler.next2());
  const float flown = sample.scatters ? sample.distance : length;
  if (is_homogeneous(*medium) && is_black(medium->sigma_s))
    keep_weakened(*medium, path, length, sample.weight, chunk);
  else
    keep_segment(path, {0, flown}, before, {}, chunk);
  const RGB after = before * sample.weight;
  if (is_wanted_in_media(path) && !is_black(medium->sigma_s))
    store(*medium, path, flown, sample.scatters ? after : RGB(0.0f), sampler.next1(), chunk);
  // What scatters has arrived, with all of its flux.
  add(chunk.balance.arrived, sample.scatters ? before : before - after);
  path.throughput = after;
  return sample;
}

/// Keeps a piece of the way of a path as beams, and its end as a photon; far from the scene with a probability only.
/// @param scattered flux at the end; black: it does not scatter there
void PhotonWalk::store(const Medium& medium, const LightPath& path, float length, RGB scattered, float u,
                       PhotonChunk& chunk) const {
  const Ray& ray = path.ray;
  const MediumSpan span = span_in(medium, ray.origin, ray.direction, 0, length);
  const Vec3 to_middle = looked_at_.center() - ray.origin;
  const float nearest = std::clamp(dot(to_middle, ray.direction), span.first, std::max(span.first, span.last));
  const float of_beam = share_kept(path, medium, ray.origin + ray.direction * nearest);
  if (u < of_beam) add_beams(medium, path, span, path.throughput / of_beam, path.light, u / of_beam, chunk.beams);
  if (is_black(scattered)) return;
  const Vec3 end = ray.origin + ray.direction * length;
  const float of_photon = share_kept(path, medium, end);
  if (u < of_photon) chunk.in_media.push_back(end, ray.direction, scattered / of_photon, path.medium.index, path.light);
}

/// The share of photons of a path that are kept at a place in a medium: such that all matter as much.
float PhotonWalk::share_kept(const LightPath& path, const Medium& medium, Vec3 position) const {
  if (medium.bounds) return 1;
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  const float looks = share_that_looks(looked_at_, position, std::min({sigma_t.r, sigma_t.g, sigma_t.b}));
  return std::min(looks / path.least_share, 1.0f);
}

/// Sends a path on from a place in a medium. Returns false, and makes it black, if it ends there.
bool PhotonWalk::scatter(LightPath& path, float distance, float before, int bounce, Sampler& sampler,
                         PhotonChunk& chunk) const {
  const int bounces = bounce + ++path.scatterings;
  RGB scattered = std::exchange(path.throughput, RGB(0.0f));
  path.bounces = with_bounce(path.bounces, 0);
  if (is_black(scattered) || !may_leave(pass_.choice, path.bounces)) return false;
  const Medium& medium = scene_.media()[path.medium.index];
  const Vec3 position = path.ray.origin + path.ray.direction * distance;
  const float returns = medium.bounds ? 1.0f : share_that_returns(looked_at_, position);
  const float least = std::min(path.least_share, returns);
  const float kept = max_component(scattered) / std::max(before, 1e-30f) * (least / path.least_share);
  const float probability = roulette(kept, kLeastOfPhotons, bounces, [&] { return sampler.next1(); });
  if (!(probability > 0)) return false;
  path.least_share = least;
  scattered *= 1 / probability;
  add(chunk.balance.scattered, scattered);
  if (bounces >= pass_.max_bounces) {
    add(chunk.balance.cut, scattered);
    return false;
  }
  path.throughput = scattered;
  path.medium.named = true;
  path.ray = {position, 0, sample_henyey_greenstein(-path.ray.direction, medium.g, sampler.next2()),
              std::numeric_limits<float>::infinity(), path.ray.time};
  return true;
}

}  // namespace glowworm
