#include "photon/chunk_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "bsdf/phase.h"
#include "core/random.h"
#include "kernels/sobol.h"
#include "photon/beams.h"
#include "photon/diffuse_hits.h"
#include "photon/emission_guide.h"
#include "photon/light_paths.h"
#include "photon/material_lobes.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// A pair of random numbers for every path.
struct Pairs {
  std::vector<float> x = std::vector<float>(kPathsPerChunk + kDiffuseScatterPadding), y = x;
};
/// Pairs of random numbers used by emission; every bounce takes two more.
constexpr std::uint32_t kEmissionPairs = 3;

/// Photons that a path stores on average, or more.
constexpr std::size_t kPhotonsEach = 2;

/// Sum of `count` floats, in four partial sums, which compilers vectorise.
template <typename Value>
double sum(std::size_t count, const Value& value) {
  double lanes[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) lanes[lane] += static_cast<double>(value(i + lane));
  for (; i < count; ++i) lanes[0] += static_cast<double>(value(i));
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

Ray photon_ray(Vec3 origin, Vec3 direction, float time) {
  return {origin, 0, direction, std::numeric_limits<float>::infinity(), time};
}

}  // namespace

class ChunkTracers::ChunkTracer {
 public:
  ChunkTracer(const PhotonChunkSettings& settings, const StartMedia& media)
      : scene_(settings.tracer->scene()),
        settings_(settings),
        pass_(*settings.pass),
        media_(media),
        block_(settings.pass->on_all_surfaces) {}

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
    chunk.make_room(kPhotonsEach * count);
    emit(first_path, count);
    for (int bounce = 0; paths_.count > 0; ++bounce) {
      const std::span<const Ray> rays(paths_.rays.data(), paths_.count);
      settings_.tracer->intersect(rays, {paths_.hits.data(), paths_.count}, RayOrder::incoherent);
      if (crosses_media_)
        for (std::size_t i = 0; i < paths_.count; ++i) cross_media(i, first_path, bounce);
      else if (pass_.discs)
        for (std::size_t i = 0; i < paths_.count; ++i) keep_segment(i, paths_.rays[i], length_to(paths_.hits[i]), {});
      draw_bounce(first_path, bounce);
      std::size_t kept = 0;
      for (std::size_t first = 0; first < rays.size(); first += DiffuseHits::kBlock)
        kept = scatter_block(first, std::min(DiffuseHits::kBlock, rays.size() - first), bounce, kept);
      paths_.count = kept;
    }
  }

 private:
  /// Notes a straight part of path i if it crosses discs of the pass.
  void keep_segment(std::size_t i, const Ray& ray, float length, RGB absorption) {
    if (!pass_.discs || !leaves(pass_.choice, paths_.bounces[i])) return;
    bool crosses = false;
    pass_.discs->for_crossed(ray.origin, ray.direction, length, [&](const DiscCrossing&) {
      crosses = true;
      return false;
    });
    if (!crosses) return;
    result_->segments.push_back({ray.origin, length, ray.direction, paths_.light[i], flux(i), absorption});
    if (settings_.pilot) result_->segment_path.push_back(paths_.number[i]);
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
    if (is_black(flux(i))) hit.triangle = kNone;
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
    const RGB before = flux(i);
    before_medium_ = max_component(before);
    const MediumSample sample = sample_medium(*medium, path.ray, length, before, sampler.next2());
    keep_segment(i, path.ray, sample.scatters ? sample.distance : length,
                 is_black(medium->sigma_s) ? medium->sigma_a : RGB(0.0f));
    const bool is_stored =
        pass_.choice == PhotonChoice::all && !is_straight_from_lamp(paths_.bounces[i]) && !is_black(medium->sigma_s);
    if (is_stored) {
      const MediumSpan span =
          span_in(*medium, path.ray.origin, path.ray.direction, 0, sample.scatters ? sample.distance : length);
      add_beams(*medium, path, span, before, paths_.light[i], sampler.next1(), result_->beams);
    }
    const RGB after = before * sample.weight;
    if (is_stored && sample.scatters && !is_black(after))
      result_->in_media.push_back(path.ray.origin + path.ray.direction * sample.distance, path.ray.direction, after,
                                  path.medium.index, paths_.light[i]);
    // What scatters has arrived, with all of its flux.
    for (int c = 0; c < 3; ++c)
      result_->balance.arrived[c] += static_cast<double>(sample.scatters ? before[c] : before[c] - after[c]);
    put_flux(i, after);
    return sample;
  }

  /// Sends path i on from a place in a medium. Returns false if it ends there.
  bool scatter_in_medium(std::size_t i, PathState& path, float distance, int bounce, Sampler& sampler) {
    const int bounces = bounce + ++paths_.scatterings[i];
    RGB scattered = flux(i);
    put_flux(i, RGB(0.0f));
    paths_.bounces[i] = with_bounce(paths_.bounces[i], 0);
    if (is_black(scattered) || !may_leave(pass_.choice, paths_.bounces[i])) return false;
    const float kept = max_component(scattered) / std::max(before_medium_, 1e-30f);
    const float probability = roulette(kept, kLeastOfPhotons, bounces, [&] { return sampler.next1(); });
    if (!(probability > 0)) return false;
    scattered *= 1 / probability;
    for (int c = 0; c < 3; ++c) result_->balance.scattered[c] += static_cast<double>(scattered[c]);
    if (bounces >= pass_.max_bounces) {
      for (int c = 0; c < 3; ++c) result_->balance.cut[c] += static_cast<double>(scattered[c]);
      return false;
    }
    put_flux(i, scattered);
    const Medium& medium = scene_.media()[path.medium.index];
    const Vec3 position = path.ray.origin + path.ray.direction * distance;
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
    for (int c = 0; c < 3; ++c) result_->balance.emitted[c] += static_cast<double>(photon.flux[c]);
    if (!may_leave(pass_.choice, bounces)) return;
    const std::size_t at = paths_.count++;
    paths_.rays[at] = photon_ray(photon.origin, photon.direction, 0);
    put_flux(at, photon.flux);
    paths_.number[at] = static_cast<std::uint32_t>(i);
    paths_.light[at] = photon.light;
    paths_.bounces[at] = bounces;
    if (!crosses_media_) return;
    paths_.medium[at] = media_.of(scene_, photon.light, photon.direction);
    paths_.scatterings[at] = 0;
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

  /// Stores the photons of paths [first, first + count) at their hits, and moves the paths that continue behind the
  /// first `kept` paths. Returns the new number of paths.
  std::size_t scatter_block(std::size_t first, std::size_t count, int bounce, std::size_t kept) {
    ArrivedPaths numbers;
    numbers.roulette = choice_.y.data();
    numbers.square[0] = direction_.x.data();
    numbers.square[1] = direction_.y.data();
    for (std::size_t c = 0; c < 3; ++c) numbers.flux[c] = paths_.flux[c].data();
    block_.scatter(scene_, {paths_.rays.data(), paths_.count}, {paths_.hits.data(), paths_.count}, first, count,
                   numbers);
    bool any_left_over = false;
    for (std::size_t i = 0; i < count; ++i) any_left_over |= block_.left_over(i);
    if (any_left_over)
      for (std::size_t i = 0; i < count; ++i) bounce_[i] = block_.left_over(i) ? scatter_other(first + i, i) : 0;
    if (bounce + 1 > kEvenBounces) end_long_paths(first, count, bounce + 1);
    const bool last = bounce + 1 >= pass_.max_bounces;
    add_balance(first, count, last);
    store_photons(first, count);
    if (!last) kept = keep_paths(first, count, kept);
    if (any_left_over) bounce_.fill(0);
    return kept;
  }

  RGB flux(std::size_t path) const { return {paths_.flux[0][path], paths_.flux[1][path], paths_.flux[2][path]}; }
  void put_flux(std::size_t path, RGB flux) {
    for (int c = 0; c < 3; ++c) paths_.flux[c][path] = flux[c];
  }

  /// Scatters one path, number i of its block, with any BSDF; returns the bits of its bounce.
  std::uint8_t scatter_other(std::size_t path, std::size_t i) {
    block_.put_outcome(i, 0);
    const Hit& hit = paths_.hits[path];
    const Vec3 back = block_.back(i);
    Vertex vertex = vertex_at(scene_, paths_.rays[path], hit);
    float u_lobe = choice_.x[path], u_roulette = choice_.y[path];
    RGB arriving = flux(path);
    resolve_material(scene_, vertex, arriving, [&] {
      // The wavelength takes a share of the number that chooses the lobe: its digits beyond the third.
      const float thousand = u_lobe * 1024;
      return thousand - std::floor(thousand);
    });
    const ShadedSurface surface = vertex.surface();
    const ArrivedPhoton arrived = surface.arrive(back, u_lobe);
    arriving *= arrived.factor;
    std::uint32_t outcome = 0;
    // Estimates reach over all points of a material, also those without a broad lobe: their photons are stored where
    // other points may have one.
    if (arrived.factor > 0 &&
        (pass_.on_all_surfaces || vertex.has(kBroad) ||
         may_have_lobes(scene_, vertex.point, scene_.geometry().material_of(hit.triangle), kBroad))) {
      outcome |= kPhotonLeft;
      block_.put_photon(i, vertex.point.position, vertex.normal(), arriving);
      block_.put_back(i, arrived.back);
    }
    ScatteredRay s;
    if (arrived.factor > 0)
      s = surface.scatter_photon(arrived.back, u_lobe, {direction_.x[path], direction_.y[path]}, u_roulette);
    if (s.valid && leave(path, i, vertex, arriving, u_roulette, s)) outcome |= kPathGoesOn;
    if (!(outcome & kPathGoesOn)) block_.put_path(i, {}, {}, RGB(0.0f));
    block_.put_outcome(i, outcome);
    if (s.lobe != kSharp) return 0;
    if (s.straight && arrived.back == back) return kNoneBroad;
    return s.delta ? kCaustic : kCaustic | kRoughFirst;
  }

  /// Continues a path in the sampled direction, or ends it by Russian roulette.
  bool leave(std::size_t path, std::size_t i, const Vertex& vertex, RGB arriving, float u, const ScatteredRay& s) {
    const RGB next = arriving * s.weight;
    const float kept = max_component(next) / std::max(max_component(flux(path)), 1e-30f);
    const float probability = roulette(kept, kLeastOfPhotons, 1, [u] { return u; });
    if (!(probability > 0)) return false;
    const Ray ray = leave_surface(vertex.point.position, s.side, vertex.point.offset, s.direction, vertex.time);
    block_.put_path(i, ray.origin, ray.direction, next / probability);
    return true;
  }

  /// Ends some of paths [first, first + count), a block, by the length that they reach with bounce `bounces`.
  void end_long_paths(std::size_t first, std::size_t count, int bounces) {
    const float probability = survival_by_length(bounces);
    const std::uint32_t key =
        Sampler::pair_key(pass_.seed, hash_combine(kPhotonEndStream, pass_.pass), static_cast<std::uint32_t>(bounces));
    for (std::size_t i = 0; i < count; ++i) {
      if (!(block_.outcome(i) & kPathGoesOn)) continue;
      if (to_unit_float(hash_combine(key, index_[first + i])) < probability) {
        block_.put_path(i, block_.origin(i), block_.direction(i), block_.flux(i) / probability);
      } else {
        block_.put_path(i, {}, {}, RGB(0.0f));
        block_.put_outcome(i, block_.outcome(i) & ~std::uint32_t{kPathGoesOn});
      }
    }
  }

  /// Adds the flux of paths [first, first + count), a block, to the flux balance.
  void add_balance(std::size_t first, std::size_t count, bool last) {
    FluxBalance& balance = result_->balance;
    bool all_left = true;
    for (std::size_t i = 0; i < count; ++i) all_left &= ((block_.outcome(i) & kPhotonLeft) | block_.missed()[i]) != 0;
    for (int c = 0; c < 3; ++c) {
      const float* const in = paths_.flux[c].data() + first;
      const double whole = sum(count, [&](std::size_t i) { return in[i]; });
      const double escaped = sum(count, [in, missed = block_.missed()](std::size_t i) {
        return std::bit_cast<float>(std::bit_cast<std::uint32_t>(in[i]) & missed[i]);
      });
      const double on = sum(count, [out = block_.flux_channel(c)](std::size_t i) { return out[i]; });
      double not_stored = 0;
      for (std::size_t i = 0; !all_left && i < count; ++i)
        if (!(block_.outcome(i) & kPhotonLeft) && !block_.missed()[i]) not_stored += static_cast<double>(in[i]);
      balance.escaped[c] += escaped;
      balance.arrived[c] += whole - escaped;
      balance.stored[c] += whole - escaped - not_stored;
      balance.scattered[c] += on;
      if (last) balance.cut[c] += on;
    }
  }

  /// Appends the photons of paths [first, first + count), a block. A path without a photon writes one, too, which the
  /// next path overwrites: a branch would mispredict often.
  void store_photons(std::size_t first, std::size_t count) {
    PhotonChunk& photons = *result_;
    const std::size_t before = photons.count;
    photons.make_room(before + count);
    Vec3* const position = photons.position.data();
    Vec3* const direction = photons.direction.data();
    Vec3* const normal = photons.normal.data();
    RGB* const flux = photons.flux.data();
    std::uint32_t* const light = photons.light.data();
    std::uint8_t* const caustic = photons.caustic.data();
    const std::uint32_t* const light_of = paths_.light.data() + first;
    const std::uint8_t* const bounces = paths_.bounces.data() + first;
    const bool only_segments = pass_.discs && pass_.choice != PhotonChoice::all;
    const auto is_stored = [&](std::size_t i) {
      const bool in_map = !only_segments && leaves(pass_.choice, bounces[i]);
      return (block_.outcome(i) / kPhotonLeft) & std::uint32_t{in_map};
    };
    std::size_t at = before;
    for (std::size_t i = 0; i < count; ++i) {
      position[at] = block_.position(i);
      direction[at] = block_.back(i);
      normal[at] = block_.normal(i);
      flux[at] = block_.photon_flux(i);
      light[at] = light_of[i];
      caustic[at] = (bounces[i] & kCaustic) == kCaustic;
      at += is_stored(i);
    }
    photons.count = at;
    if (settings_.pilot)
      for (std::size_t i = 0, to = before; i < count; ++i)
        if (is_stored(i)) photons.path[to++] = paths_.number[first + i];
    for (std::size_t i = before; pass_.importance && i < at; ++i)
      photons.used[i] = importance_for(pass_, position[i], normal[i], caustic[i] != 0) > 0;
  }

  /// Moves those of paths [first, first + count), a block, that continue behind the first `kept` paths; returns the new
  /// number of paths.
  std::size_t keep_paths(std::size_t first, std::size_t count, std::size_t kept) {
    Ray* const rays = paths_.rays.data();
    float* const flux[3] = {paths_.flux[0].data(), paths_.flux[1].data(), paths_.flux[2].data()};
    std::uint32_t* const number = paths_.number.data();
    std::uint32_t* const light = paths_.light.data();
    std::uint8_t* const bounces = paths_.bounces.data();
    for (std::size_t i = 0; i < count; ++i) {
      rays[kept] = photon_ray(block_.origin(i), block_.direction(i), rays[first + i].time);
      const RGB of_path = block_.flux(i);
      flux[0][kept] = of_path.r;
      flux[1][kept] = of_path.g;
      flux[2][kept] = of_path.b;
      number[kept] = number[first + i];
      light[kept] = light[first + i];
      bounces[kept] = with_bounce(bounces[first + i], bounce_[i]);
      if (crosses_media_) keep_medium(first + i, i, kept);
      const bool may_store = may_leave(pass_.choice, bounces[kept]);
      kept += (block_.outcome(i) / kPathGoesOn) & std::uint32_t{may_store};
    }
    return kept;
  }

  /// Notes the medium that path number i of its block goes on in.
  void keep_medium(std::size_t path, std::size_t i, std::size_t kept) {
    const std::uint32_t triangle = paths_.hits[path].triangle;
    paths_.scatterings[kept] = paths_.scatterings[path];
    if (triangle != kNone)
      paths_.medium[kept] = medium_behind(scene_, paths_.medium[path], triangle, block_.direction(i));
  }

  const Scene& scene_;
  const PhotonChunkSettings& settings_;
  const PhotonPassSettings& pass_;
  const StartMedia& media_;
  LightPaths paths_;
  std::vector<std::uint32_t> index_ =
      std::vector<std::uint32_t>(kPathsPerChunk);  // of the paths, among all of the pass
  Pairs choice_, direction_, light_;
  DiffuseHits block_;
  std::array<std::uint8_t, DiffuseHits::kBlock> bounce_ = {};  // the bits of each path's bounce
  PhotonChunk* result_ = nullptr;
  const bool crosses_media_ = scene_.crosses_media();
  float before_medium_ = 0;  // largest flux of a path before its piece in a medium
};

float importance_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic) {
  if (!pass.importance) return 1;
  const float gathered = pass.choice != PhotonChoice::all ? 0.0f : pass.importance->gathered.value(position, normal);
  return gathered + (caustic ? pass.importance->seen.value(position, normal) : 0.0f);
}

ChunkTracers::ChunkTracers(const PhotonChunkSettings& settings) : settings_(settings), media_(*settings.tracer) {}
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
  if (!tracer) tracer = std::make_unique<ChunkTracer>(settings_, media_);
  tracer->trace(first, count, chunk);
  const std::scoped_lock lock(mutex_);
  idle_.push_back(std::move(tracer));
}

}  // namespace glowworm
