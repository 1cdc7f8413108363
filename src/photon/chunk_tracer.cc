#include "photon/chunk_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bsdf/phase.h"
#include "core/random.h"
#include "core/shading_light.h"
#include "core/warp.h"
#include "kernels/sobol.h"
#include "photon/beams.h"
#include "photon/emission_guide.h"
#include "photon/kept_paths.h"
#include "photon/light_paths.h"
#include "photon/material_lobes.h"
#include "photon/outside.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// A pair of random numbers for every path.
struct Pairs {
  std::vector<float> x = std::vector<float>(kPathsPerChunk), y = x;
};
/// Pairs of random numbers used by emission; every bounce takes two more.
constexpr std::uint32_t kEmissionPairs = 3;

Ray photon_ray(Vec3 origin, Vec3 direction, float time) {
  return {origin, 0, direction, std::numeric_limits<float>::infinity(), time};
}

/// What becomes of a path at a surface.
struct PathBounce {
  bool leaves_photon = false, goes_on = false;
  Vec3 position, normal, back;  ///< of the photon: metres; unit, where it arrived; towards its origin
  RGB photon_flux{0.0f};        ///< W, with the arrival_factor() of the shading normal
  Ray next;                     ///< of the path that goes on
  RGB flux{0.0f};               ///< of it, W
  std::uint8_t bits = 0;        ///< of the bounce, for with_bounce()
};

void add(std::array<double, 3>& sum, RGB flux) {
  for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += static_cast<double>(flux[c]);
}

/// Around surfaces, lamps without size that have a place, and what the picture needs; empty where there are no
/// surfaces.
Box3 box_of(const Scene& scene, const PhotonImportance* importance) {
  Box3 box = scene.bounds();
  if (box.empty()) return box;
  if (importance && !importance->box.empty()) box.grow(importance->box);
  for (const Light& light : scene.lights())
    if (light.kind != LightKind::directional) box.grow(light.position);
  return box;
}

/// ChunkTracers::images_ of a pass.
std::vector<std::vector<Vec3>> images_of_suns(const Scene& scene, const PhotonPassSettings& pass) {
  if (!pass.discs || pass.choice == PhotonChoice::all) return {};
  const SunImages images(scene);
  if (images.empty()) return {};
  std::vector<std::vector<Vec3>> out(scene.light_power().size());
  for (std::size_t i = 0; i < scene.lights().size(); ++i)
    if (const Light& light = scene.lights()[i]; light.kind == LightKind::directional)
      out[scene.emissive_triangles().size() + i] = images.of(-light.direction);
  return out;
}

}  // namespace

class ChunkTracers::ChunkTracer {
 public:
  ChunkTracer(const PhotonChunkSettings& settings, const StartMedia& media,
              const std::vector<std::vector<Vec3>>& images)
      : scene_(settings.tracer->scene()), settings_(settings), pass_(*settings.pass), media_(media), images_(images) {}

  void trace(std::uint64_t first_path, std::size_t count, PhotonChunk& chunk) {
    result_ = &chunk;
    chunk.count = 0;
    chunk.balance = {};
    chunk.segments.clear();
    chunk.segment_path.clear();
    chunk.in_media.clear();
    chunk.beams.clear();
    chunk.numbers.clear();
    chunk.guide_weight.clear();
    emit(first_path, count);
    if (pass_.kept)
      follow_changed(pass_.kept->chunk(first_path / kPathsPerChunk), first_path, count);
    else
      follow(first_path);
  }

 private:
  /// Follows the paths to their ends.
  void follow(std::uint64_t first_path) {
    for (int bounce = 0; paths_.count > 0; ++bounce) {
      const std::span<const Ray> rays(paths_.rays.data(), paths_.count);
      settings_.tracer->intersect(rays, {paths_.hits.data(), paths_.count}, RayOrder::incoherent);
      if (crosses_media_)
        for (std::size_t i = 0; i < paths_.count; ++i) cross_media(i, first_path, bounce);
      else if (pass_.discs)
        for (std::size_t i = 0; i < paths_.count; ++i) keep_segment(i, paths_.rays[i], length_to(paths_.hits[i]), {});
      if (pass_.kept) keep_parts();
      draw_bounce(first_path, bounce);
      paths_.count = scatter_paths(bounce);
      if (pass_.kept) followed_.ends_of_bounces.push_back(result_->count);
    }
  }

  /// The paths of a chunk as they leave their lights.
  std::vector<EmittedPath> emitted_paths(std::size_t count) const {
    std::vector<EmittedPath> out(count);
    for (std::size_t i = 0; i < paths_.count; ++i)
      out[paths_.number[i]] = {paths_.rays[i].origin, paths_.rays[i].direction, paths_.flux[i], paths_.light[i]};
    return out;
  }

  /// Follows the paths of a chunk that are not as they were, and takes the photons of the others from before.
  void follow_changed(KeptChunk& before, std::uint64_t first_path, std::size_t count) {
    KeptChunk now;
    now.emitted = emitted_paths(count);
    const std::vector<bool> stays = pass_.kept->staying_paths(before, now.emitted);
    std::size_t left = 0;
    for (std::size_t i = 0; i < paths_.count; ++i)
      if (!stays[paths_.number[i]]) start_as(i, left++);
    paths_.count = left;
    followed_.parts.clear();
    followed_.ends_of_bounces.clear();
    follow(first_path);
    pass_.kept->join(before, stays, followed_, std::move(now), *result_);
    result_->balance = {};
  }

  /// Moves path i before its first bounce.
  void start_as(std::size_t i, std::size_t to) {
    paths_.rays[to] = paths_.rays[i];
    paths_.flux[to] = paths_.flux[i];
    paths_.number[to] = paths_.number[i];
    paths_.light[to] = paths_.light[i];
    paths_.bounces[to] = paths_.bounces[i];
  }

  /// Notes the straight parts of all paths to their hits.
  void keep_parts() {
    for (std::size_t i = 0; i < paths_.count; ++i) {
      const Ray& ray = paths_.rays[i];
      const bool escapes = paths_.hits[i].triangle == kNone;
      followed_.parts.push_back({escapes ? ray.direction : ray.origin + ray.direction * paths_.hits[i].distance,
                                 paths_.number[i] | (escapes ? KeptChunk::kEscapes : 0)});
    }
  }

  /// Notes a straight part of path i if it crosses discs of the pass.
  void keep_segment(std::size_t i, const Ray& ray, float length, RGB absorption) {
    if (!pass_.discs || !leaves(pass_.choice, paths_.bounces[i]) || is_from_image(i, ray.direction)) return;
    bool crosses = false;
    pass_.discs->for_crossed(ray.origin, ray.direction, length, [&](const DiscCrossing&) {
      crosses = true;
      return false;
    });
    if (!crosses) return;
    result_->segments.push_back({ray.origin, length, ray.direction, paths_.light[i], paths_.flux[i], absorption});
    if (settings_.pilot) result_->segment_path.push_back(paths_.number[i]);
  }

  /// Whether path i brings the light of an image of its sun.
  bool is_from_image(std::size_t i, Vec3 direction) const {
    if (images_.empty() || (paths_.bounces[i] & kNotSmooth)) return false;
    const std::vector<Vec3>& images = images_[paths_.light[i]];
    return std::any_of(images.begin(), images.end(), [&](Vec3 image) { return SunImages::same(image, -direction); });
  }

  /// Takes path i through media to the next surface, or out of the scene, however often it scatters on its way.
  void cross_media(std::size_t i, std::uint64_t first_path, int bounce) {
    Sampler sampler(SamplerKind::sobol, pass_.seed,
                    hash_combine(hash_combine(kMediumStream, pass_.pass), static_cast<std::uint32_t>(bounce)),
                    static_cast<std::uint32_t>(first_path + paths_.number[i]));
    PathState path;
    path.ray = paths_.rays[i];
    path.medium = paths_.medium[i];
    Hit hit = paths_.hits[i];
    for (;;) {
      MediumSample sample;
      const bool arrives =
          travel(*settings_.tracer, path, hit, RayOrder::incoherent, [&](const Medium* medium, float length) {
            sample = cross(i, medium, path, length, sampler);
            return !sample.scatters;
          });
      if (arrives || !scatter_in_medium(i, path, sample.distance, bounce, sampler)) break;
      hit = settings_.tracer->intersect(path.ray);
    }
    if (is_black(paths_.flux[i])) hit.triangle = kNone;
    paths_.rays[i] = path.ray;
    paths_.medium[i] = path.medium;
    paths_.hits[i] = hit;
  }

  /// Takes path i along a piece of its way, and keeps it as beams and a photon.
  MediumSample cross(std::size_t i, const Medium* medium, const PathState& path, float length, Sampler& sampler) {
    if (!medium) {
      keep_segment(i, path.ray, length, {});
      return {};
    }
    const RGB before = paths_.flux[i];
    before_medium_ = max_component(before);
    const MediumSample sample = sample_medium(*medium, path.ray, length, before, sampler.next2());
    keep_segment(i, path.ray, sample.scatters ? sample.distance : length,
                 is_black(medium->sigma_s) ? medium->sigma_a : RGB(0.0f));
    const bool is_stored =
        pass_.choice == PhotonChoice::all && !is_straight_from_lamp(paths_.bounces[i]) && !is_black(medium->sigma_s);
    const RGB after = before * sample.weight;
    if (is_stored)
      store_in_medium(i, *medium, path, sample.scatters ? sample.distance : length, sample.scatters ? after : RGB(0.0f),
                      sampler.next1());
    // What scatters has arrived, with all of its flux.
    add(result_->balance.arrived, sample.scatters ? before : before - after);
    paths_.flux[i] = after;
    return sample;
  }

  /// Keeps a piece of the way of path i as beams, and its end as a photon; far from the scene with a probability only.
  /// @param scattered flux at the end; black: it does not scatter there
  void store_in_medium(std::size_t i, const Medium& medium, const PathState& path, float length, RGB scattered,
                       float u) {
    const Ray& ray = path.ray;
    const MediumSpan span = span_in(medium, ray.origin, ray.direction, 0, length);
    const Vec3 to_middle = looked_at_.center() - ray.origin;
    const float nearest = std::clamp(dot(to_middle, ray.direction), span.first, std::max(span.first, span.last));
    const float of_beam = share_kept(i, medium, ray.origin + ray.direction * nearest);
    if (u < of_beam)
      add_beams(medium, path, span, paths_.flux[i] / of_beam, paths_.light[i], u / of_beam, result_->beams);
    if (is_black(scattered)) return;
    const Vec3 end = ray.origin + ray.direction * length;
    const float of_photon = share_kept(i, medium, end);
    if (u < of_photon)
      result_->in_media.push_back(end, ray.direction, scattered / of_photon, path.medium.index, paths_.light[i]);
  }

  /// The share of photons of path i that are kept at a place in a medium: such that all matter as much.
  float share_kept(std::size_t i, const Medium& medium, Vec3 position) const {
    if (medium.bounds) return 1;
    const RGB sigma_t = medium.sigma_a + medium.sigma_s;
    const float looks = share_that_looks(looked_at_, position, std::min({sigma_t.r, sigma_t.g, sigma_t.b}));
    return std::min(looks / paths_.least_share[i], 1.0f);
  }

  /// Sends path i on from a place in a medium. Returns false if it ends there.
  bool scatter_in_medium(std::size_t i, PathState& path, float distance, int bounce, Sampler& sampler) {
    const int bounces = bounce + ++paths_.scatterings[i];
    RGB scattered = paths_.flux[i];
    paths_.flux[i] = RGB(0.0f);
    paths_.bounces[i] = with_bounce(paths_.bounces[i], 0);
    if (is_black(scattered) || !may_leave(pass_.choice, paths_.bounces[i])) return false;
    const Medium& medium = scene_.media()[path.medium.index];
    const Vec3 position = path.ray.origin + path.ray.direction * distance;
    const float returns = medium.bounds ? 1.0f : share_that_returns(looked_at_, position);
    const float least = std::min(paths_.least_share[i], returns);
    const float kept = max_component(scattered) / std::max(before_medium_, 1e-30f) * (least / paths_.least_share[i]);
    const float probability = roulette(kept, kLeastOfPhotons, bounces, [&] { return sampler.next1(); });
    if (!(probability > 0)) return false;
    paths_.least_share[i] = least;
    scattered *= 1 / probability;
    add(result_->balance.scattered, scattered);
    if (bounces >= pass_.max_bounces) {
      add(result_->balance.cut, scattered);
      return false;
    }
    paths_.flux[i] = scattered;
    path.medium.named = true;
    path.ray =
        photon_ray(position, sample_henyey_greenstein(-path.ray.direction, medium.g, sampler.next2()), path.ray.time);
    return true;
  }

  /// Pair `dimension` of the random numbers of paths index_[0..count).
  void draw(std::uint32_t dimension, std::size_t count, Pairs& pairs) {
    sobol_pairs(Sampler::pair_key(pass_.seed, hash_combine(kPhotonStream, pass_.pass), dimension), index_.data(), count,
                pairs.x.data(), pairs.y.data());
  }

  /// Starts paths [first_path, first_path + count).
  void emit(std::uint64_t first_path, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) index_[i] = static_cast<std::uint32_t>(first_path + i);
    draw(0, count, direction_);
    draw(1, count, choice_);
    draw(2, count, light_);
    result_->emitted_light.resize(count);
    paths_.count = 0;
    for (std::size_t i = 0; i < count; ++i) emit_path(i);
  }

  /// Starts path number i of the chunk, unless it has nothing to carry.
  void emit_path(std::size_t i) {
    EmissionNumbers numbers = {light_.x[i], choice_.x[i], choice_.y[i], direction_.x[i], direction_.y[i]};
    const float guide_weight = pass_.guide ? pass_.guide->warp(numbers) : 1.0f;
    if (settings_.pilot) {
      result_->numbers.push_back(numbers);
      result_->guide_weight.push_back(guide_weight);
    }
    EmittedPhoton photon = sample_emission(scene_, numbers[0], {numbers[1], numbers[2]}, {numbers[3], numbers[4]});
    photon.flux *= guide_weight;
    if (is_outside_of_medium(photon)) photon.flux = RGB(0.0f);
    result_->emitted_light[i] = photon.light;
    const std::uint8_t bounces = first_bounces(photon.light);
    if (is_black(photon.flux)) return;
    add(result_->balance.emitted, photon.flux);
    if (!may_leave(pass_.choice, bounces)) return;
    const std::size_t at = paths_.count++;
    paths_.rays[at] = photon_ray(photon.origin, photon.direction, 0);
    paths_.flux[at] = photon.flux;
    paths_.number[at] = static_cast<std::uint32_t>(i);
    paths_.light[at] = photon.light;
    paths_.bounces[at] = bounces;
    if (!crosses_media_) return;
    paths_.medium[at] = media_.of(scene_, photon.light, photon.direction);
    paths_.scatterings[at] = 0;
    paths_.least_share[at] = 1;
  }

  /// Whether a photon that a medium emits starts where surfaces leave this medium out.
  bool is_outside_of_medium(const EmittedPhoton& photon) const {
    const MediumEmission* const emission = scene_.medium_of_source(photon.light);
    return emission && !is_black(photon.flux) &&
           medium_at_start(*settings_.tracer, photon.origin, photon.direction).index != emission->medium();
  }

  /// The bits of paths without a bounce. What media emit is never part of the caustic map: gather rays see it through
  /// mirrors and glass, too.
  std::uint8_t first_bounces(std::uint32_t light) const {
    if (scene_.medium_of_source(light)) return 0;
    return is_delta(light) ? kNoneBroad | kFromDelta : kNoneBroad;
  }
  /// Whether a light source has no size.
  bool is_delta(std::uint32_t source) const {
    const std::size_t first = scene_.emissive_triangles().size();
    return source >= first && source < first + scene_.lights().size();
  }

  /// The random numbers of a bounce for all paths: a pair for the lobe and Russian roulette, and a pair for the
  /// direction.
  void draw_bounce(std::uint64_t first_path, int bounce) {
    for (std::size_t i = 0; i < paths_.count; ++i)
      index_[i] = static_cast<std::uint32_t>(first_path + paths_.number[i]);
    const auto dimension = kEmissionPairs + 2 * static_cast<std::uint32_t>(bounce);
    draw(dimension, paths_.count, choice_);
    draw(dimension + 1, paths_.count, direction_);
  }

  /// Stores the photons of all paths at their hits, and moves the paths that go on to the front. Returns their number.
  std::size_t scatter_paths(int bounce) {
    FluxBalance& balance = result_->balance;
    result_->make_room(result_->count + paths_.count);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < paths_.count; ++i) {
      if (paths_.hits[i].triangle == kNone) {
        add(balance.escaped, paths_.flux[i]);
        continue;
      }
      PathBounce out;
      out.back = -paths_.rays[i].direction;
      if (!scatter_diffuse(i, out)) scatter_any(i, out);
      if (out.goes_on) end_if_long(i, bounce + 1, out);
      add(balance.arrived, paths_.flux[i]);
      if (out.leaves_photon) {
        add(balance.stored, paths_.flux[i]);
        store_photon(i, out);
      }
      if (!out.goes_on) continue;
      add(balance.scattered, out.flux);
      if (bounce + 1 >= pass_.max_bounces)
        add(balance.cut, out.flux);
      else
        kept += keep_path(i, out, kept);
    }
    return kept;
  }

  /// Scatters path i, if it has hit a surface that only reflects diffusely and has no map of normals, as most have.
  bool scatter_diffuse(std::size_t i, PathBounce& out) {
    const Hit& hit = paths_.hits[i];
    DiffuseTriangleRoom room;
    const DiffuseTriangle& triangle = scene_.diffuse_triangle(hit.triangle, room);
    DiffusePoint point;
    Vec3 shading;
    if (!diffuse_point(scene_, hit.triangle, hit.barycentric, point) ||
        !diffuse_shading_normal(scene_, hit.triangle, hit.barycentric, point, shading))
      return false;
    const float geometric = dot(point.geometric_normal, out.back), along = dot(shading, out.back);
    const float factor =
        arrival_factor(geometric < 0 ? -along : along, std::abs(geometric), dot(shading, point.geometric_normal));
    out.position = point.position;
    out.normal = face_forward(point.geometric_normal, out.back);
    out.photon_flux = paths_.flux[i] * factor;
    // Estimates around a black texel reach over it.
    const bool may_reflect =
        pass_.on_all_surfaces || (triangle.kind & DiffuseTriangle::kTextured) || !is_black(point.reflectance);
    out.leaves_photon = factor > 0 && may_reflect;
    const Vec3 local = square_to_cosine_hemisphere({direction_.x[i], direction_.y[i]});
    if (!out.leaves_photon || !(local.z > 0)) return true;
    out.goes_on = survives(i, paths_.flux[i] * point.reflectance * factor, choice_.y[i], out);
    out.next = leave_surface(out.position, out.normal, triangle.offset(),
                             Frame::from_normal(out.normal).to_world(local), paths_.rays[i].time);
    return true;
  }

  /// Scatters path i with any BSDF.
  void scatter_any(std::size_t i, PathBounce& out) {
    const Hit& hit = paths_.hits[i];
    const Vec3 back = out.back;
    Vertex vertex = vertex_at(scene_, paths_.rays[i], hit);
    float u_lobe = choice_.x[i], u_roulette = choice_.y[i];
    RGB arriving = paths_.flux[i];
    resolve_material(scene_, vertex, arriving, [&] {
      // The wavelength takes a share of the number that chooses the lobe: its digits beyond the third.
      const float thousand = u_lobe * 1024;
      return thousand - std::floor(thousand);
    });
    const ShadedSurface surface = vertex.surface();
    const ArrivedPhoton arrived = surface.arrive(back, u_lobe);
    if (!(arrived.factor > 0)) return;
    out.position = vertex.point.position;
    out.normal = vertex.normal();
    out.back = arrived.back;
    out.photon_flux = arriving * arrived.factor;
    // Estimates reach over all points of a material, also those without a broad lobe: their photons are stored where
    // other points may have one.
    out.leaves_photon = pass_.on_all_surfaces || vertex.has(kBroad) ||
                        may_have_lobes(scene_, vertex.point, scene_.geometry().material_of(hit.triangle), kBroad);
    const ScatteredRay s = surface.scatter_photon(arrived.back, u_lobe, {direction_.x[i], direction_.y[i]}, u_roulette);
    if (s.lobe == kSharp)
      out.bits = s.straight && arrived.back == back ? kNoneBroad : s.delta ? kCaustic : kCaustic | kRoughFirst;
    if (!images_.empty() && s.lobe == kSharp && !is_smooth(scene_, hit.triangle, vertex)) out.bits |= kNotSmooth;
    if (!s.valid) return;
    out.goes_on = survives(i, out.photon_flux * s.weight, u_roulette, out);
    out.next = leave_surface(vertex.point.position, s.side, vertex.point.offset, s.direction, vertex.time);
  }

  /// Plays Russian roulette for path i, and sets the flux with which it goes on. @param next before that, W
  bool survives(std::size_t i, RGB next, float u, PathBounce& out) const {
    const float kept = max_component(next) / std::max(max_component(paths_.flux[i]), 1e-30f);
    const float probability = roulette(kept, kLeastOfPhotons, 1, [u] { return u; });
    if (probability > 0) out.flux = next / probability;
    return probability > 0;
  }

  /// Ends some paths by the length that they reach with bounce `bounces`.
  void end_if_long(std::size_t i, int bounces, PathBounce& out) const {
    const float probability = survival_by_length(bounces);
    if (probability >= 1) return;
    const std::uint32_t key =
        Sampler::pair_key(pass_.seed, hash_combine(kPhotonEndStream, pass_.pass), static_cast<std::uint32_t>(bounces));
    out.goes_on = to_unit_float(hash_combine(key, index_[i])) < probability;
    out.flux = out.flux / probability;
  }

  /// Appends the photon of path i if the pass keeps it.
  void store_photon(std::size_t i, const PathBounce& out) {
    if ((pass_.discs && pass_.choice != PhotonChoice::all) || !leaves(pass_.choice, paths_.bounces[i])) return;
    PhotonChunk& photons = *result_;
    const std::size_t at = photons.count++;
    photons.position[at] = out.position;
    photons.direction[at] = out.back;
    photons.normal[at] = out.normal;
    photons.flux[at] = out.photon_flux;
    photons.light[at] = paths_.light[i];
    photons.caustic[at] = (paths_.bounces[i] & kCaustic) == kCaustic;
    if (settings_.pilot || pass_.kept) photons.path[at] = paths_.number[i];
    if (pass_.importance)
      photons.used[at] = importance_for(pass_, out.position, out.normal, photons.caustic[at] != 0) > 0;
  }

  /// Makes path i the path `kept`. Returns whether it may still leave photons.
  bool keep_path(std::size_t i, const PathBounce& out, std::size_t kept) {
    const std::uint8_t bounces = with_bounce(paths_.bounces[i], out.bits);
    if (!may_leave(pass_.choice, bounces)) return false;
    paths_.rays[kept] = out.next;
    paths_.flux[kept] = out.flux;
    paths_.number[kept] = paths_.number[i];
    paths_.light[kept] = paths_.light[i];
    paths_.bounces[kept] = bounces;
    if (!crosses_media_) return true;
    paths_.scatterings[kept] = paths_.scatterings[i];
    paths_.least_share[kept] = paths_.least_share[i];
    paths_.medium[kept] = medium_behind(scene_, paths_.medium[i], paths_.hits[i].triangle, out.next.direction);
    return true;
  }

  const Scene& scene_;
  const PhotonChunkSettings& settings_;
  const PhotonPassSettings& pass_;
  const StartMedia& media_;
  const std::vector<std::vector<Vec3>>& images_;  // ChunkTracers::images_
  const Box3 looked_at_ = box_of(scene_, pass_.importance);
  LightPaths paths_;
  std::vector<std::uint32_t> index_ =
      std::vector<std::uint32_t>(kPathsPerChunk);  // of the paths, among all of the pass
  Pairs choice_, direction_, light_;
  PhotonChunk* result_ = nullptr;
  FollowedPaths followed_;  // if paths are kept
  const bool crosses_media_ = scene_.crosses_media();
  float before_medium_ = 0;  // largest flux of a path before its piece in a medium
};

float importance_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic) {
  if (!pass.importance) return 1;
  const float gathered = pass.choice != PhotonChoice::all ? 0.0f : pass.importance->gathered.value(position, normal);
  return gathered + (caustic ? pass.importance->seen.value(position, normal) : 0.0f);
}

ChunkTracers::ChunkTracers(const PhotonChunkSettings& settings)
    : settings_(settings),
      media_(*settings.tracer),
      images_(images_of_suns(settings.tracer->scene(), *settings.pass)) {}
ChunkTracers::~ChunkTracers() = default;

void ChunkTracers::trace(std::uint64_t first, std::size_t count, PhotonChunk& chunk) {
  std::unique_ptr<ChunkTracer> tracer;
  {
    const std::scoped_lock lock(mutex_);
    if (!idle_.empty()) {
      tracer = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!tracer) tracer = std::make_unique<ChunkTracer>(settings_, media_, images_);
  tracer->trace(first, count, chunk);
  const std::scoped_lock lock(mutex_);
  idle_.push_back(std::move(tracer));
}

}  // namespace glowworm
