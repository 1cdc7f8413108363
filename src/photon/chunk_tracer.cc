#include "photon/chunk_tracer.h"

#include <limits>
#include <utility>

#include "core/offset_origin.h"
#include "photon/emission_guide.h"
#include "scene/light_sampling.h"

namespace glowworm {

namespace {

/// Surfaces nearer to a light without size than this, in units of position_rounding(), do not stop its light. Rays at
/// more than 15 degrees to a plane through the light meet the plane nearer than that.
constexpr float kRoundings = 4;

/// The bits of paths without a bounce. What media emit is never part of the caustic map: gather rays see it through
/// mirrors and glass, too.
std::uint8_t first_bounces(const Scene& scene, std::uint32_t light) {
  if (scene.medium_of_source(light)) return 0;
  const std::size_t first = scene.emissive_triangles().size();
  const bool is_delta = light >= first && light < first + scene.lights().size();
  return is_delta ? kNoneBroad | kFromDelta : kNoneBroad;
}

/// The paths of a chunk as they leave their lights.
std::vector<EmittedPath> emitted_paths(const std::vector<LightPath>& paths, std::size_t count) {
  std::vector<EmittedPath> out(count);
  for (const LightPath& path : paths)
    out[path.in_chunk] = {path.ray.origin, path.ray.direction, path.throughput, path.light, path.medium.index};
  return out;
}

}  // namespace

float importance_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic) {
  if (!pass.importance) return 1;
  const float gathered = pass.choice != PhotonChoice::all ? 0.0f : pass.importance->gathered.value(position, normal);
  return gathered + (caustic ? pass.importance->seen.value(position, normal) : 0.0f);
}

void ChunkTracer::trace(std::uint64_t first, std::size_t count, PhotonChunk& chunk) const {
  chunk.clear();
  PathQueue<LightPath> queue;
  queue.paths.reserve(count);
  for (std::size_t i = 0; i < count; ++i) emit(first, i, queue.paths, chunk);
  if (pass_.kept)
    follow_changed(pass_.kept->chunk(first / kPathsPerChunk), queue, count, chunk);
  else
    follow(queue, chunk);
}

/// Starts a path of the chunk, unless it has nothing to carry.
void ChunkTracer::emit(std::uint64_t first, std::size_t in_chunk, std::vector<LightPath>& paths,
                       PhotonChunk& chunk) const {
  const Scene& scene = tracer_.scene();
  const auto number = static_cast<std::uint32_t>(first + in_chunk);
  Sampler sampler(SamplerKind::sobol, pass_.seed, hash_combine(kPhotonStream, pass_.pass), number);
  const Vec2 direction = sampler.next2(), choice = sampler.next2();
  EmissionNumbers numbers = {sampler.next1(), choice.x, choice.y, direction.x, direction.y};
  const float guide_weight = pass_.guide ? pass_.guide->warp(numbers) : 1.0f;
  if (pilot_) {
    chunk.numbers.push_back(numbers);
    chunk.guide_weight.push_back(guide_weight);
  }
  EmittedPhoton photon = sample_emission(scene, numbers[0], {numbers[1], numbers[2]}, {numbers[3], numbers[4]});
  photon.flux *= guide_weight;
  if (is_outside_of_medium(tracer_, photon)) photon.flux = RGB(0.0f);
  chunk.emitted_light.push_back(photon.light);
  if (is_black(photon.flux)) return;
  add(chunk.balance.emitted, photon.flux);
  const std::uint8_t bounces = first_bounces(scene, photon.light);
  // A light without size has no side to leave. Where it lies in a surface to rounding, that does not stop its light, as
  // in ray_to_light() of light samples.
  const float t_min = bounces & kFromDelta ? kRoundings * position_rounding(photon.origin) : 0;
  LightPath path{{{photon.origin, t_min, photon.direction, std::numeric_limits<float>::infinity()}, photon.flux},
                 sampler,
                 number,
                 static_cast<std::uint16_t>(in_chunk),
                 photon.light,
                 bounces};
  if (!may_leave(pass_.choice, path.bounces)) return;
  path.medium = media_.of(scene, photon.light, photon.direction);
  path.image = photon.origin;
  paths.push_back(path);
}

/// Follows paths to their ends.
void ChunkTracer::follow(PathQueue<LightPath>& queue, PhotonChunk& chunk) const {
  for (int bounce = 0; !queue.empty(); ++bounce)
    queue.step(tracer_, [&](LightPath& path, Hit& hit) {
      walk_.cross(path, hit, bounce, chunk);
      return scatter(path, hit, bounce, chunk);
    });
}

/// Follows the paths of a chunk that are not as they were, and takes the photons of the others from before.
void ChunkTracer::follow_changed(KeptChunk& before, PathQueue<LightPath>& queue, std::size_t count,
                                 PhotonChunk& chunk) const {
  std::vector<EmittedPath> emitted = emitted_paths(queue.paths, count);
  const std::vector<bool> stays = pass_.kept->staying_paths(before, emitted);
  std::erase_if(queue.paths, [&](const LightPath& path) { return stays[path.in_chunk]; });
  follow(queue, chunk);
  pass_.kept->join(before, stays, std::move(emitted), chunk);
  chunk.balance = {};
}

/// Scatters a path at its hit, and stores its photon. Returns whether it goes on and may still leave photons.
bool ChunkTracer::scatter(LightPath& path, const Hit& hit, int bounce, PhotonChunk& chunk) const {
  if (hit.triangle == kNone) {
    add(chunk.balance.escaped, path.throughput);
    return false;
  }
  const PhotonBounce out = scatter_photon(tracer_.scene(), pass_, path, hit, bounce);
  add(chunk.balance.arrived, path.throughput);
  if (out.leaves_photon) {
    add(chunk.balance.stored, path.throughput);
    store(path, out, bounce, chunk);
  }
  if (!out.goes_on) return false;
  add(chunk.balance.scattered, out.flux);
  if (bounce + 1 >= pass_.max_bounces) {
    add(chunk.balance.cut, out.flux);
    return false;
  }
  path.bounces = with_bounce(path.bounces, out.bits);
  path.throughput = out.flux;
  path.ray = out.next;
  if (tracer_.scene().crosses_media())
    path.medium = medium_behind(tracer_.scene(), path.medium, hit.triangle, path.ray.direction);
  return may_leave(pass_.choice, path.bounces);
}

/// Appends the photon of a path if the pass keeps it. @param number of the bounce
void ChunkTracer::store(const LightPath& path, const PhotonBounce& bounce, int number, PhotonChunk& chunk) const {
  if ((pass_.discs && pass_.choice != PhotonChoice::all) || !leaves(pass_.choice, path.bounces)) return;
  const bool caustic = (path.bounces & kCaustic) == kCaustic;
  const bool used = pass_.importance && importance_for(pass_, bounce.position, bounce.normal, caustic) > 0;
  chunk.photons.push_back({bounce.position, bounce.back, bounce.normal, bounce.photon_flux, path.light,
                           static_cast<std::uint32_t>(number), path.in_chunk, caustic, used});
}

}  // namespace glowworm
