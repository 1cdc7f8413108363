#include "photon/chunk_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/random.h"
#include "kernels/sobol.h"
#include "photon/diffuse_hits.h"
#include "photon/emission_block.h"
#include "photon/light_paths.h"
#include "photon/material_lobes.h"
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
  explicit ChunkTracer(const PhotonChunkSettings& settings)
      : scene_(settings.tracer->scene()),
        settings_(settings),
        pass_(*settings.pass),
        block_(settings.pass->on_all_surfaces) {}

  void trace(std::uint64_t first_path, std::size_t count, PhotonChunk& chunk) {
    result_ = &chunk;
    chunk.count = 0;
    chunk.balance = {};
    chunk.segments.clear();
    chunk.segment_path.clear();
    chunk.numbers.clear();
    chunk.guide_weight.clear();
    chunk.make_room(kPhotonsEach * count);
    emit(first_path, count);
    for (int bounce = 0; paths_.count > 0; ++bounce) {
      const std::span<const Ray> rays(paths_.rays.data(), paths_.count);
      settings_.tracer->intersect(rays, {paths_.hits.data(), paths_.count}, RayOrder::incoherent);
      if (pass_.discs) keep_segments();
      if (absorbs_) absorb();
      draw_bounce(first_path, bounce);
      std::size_t kept = 0;
      for (std::size_t first = 0; first < rays.size(); first += DiffuseHits::kBlock)
        kept = scatter_block(first, std::min(DiffuseHits::kBlock, rays.size() - first), bounce, kept);
      paths_.count = kept;
    }
  }

 private:
  /// Notes those straight parts of paths that cross discs of the pass.
  void keep_segments() {
    for (std::size_t i = 0; i < paths_.count; ++i) {
      if (!leaves(pass_.choice, paths_.bounces[i])) continue;
      const Ray& ray = paths_.rays[i];
      const Hit& hit = paths_.hits[i];
      const bool ends = hit.triangle != kNone;
      PhotonSegment segment{ray.origin,    ends ? hit.distance : std::numeric_limits<float>::infinity(),
                            ray.direction, paths_.light[i],
                            flux(i),       absorbs_ ? paths_.medium[i].absorption : RGB(0.0f)};
      bool crosses = false;
      pass_.discs->for_crossed(segment.origin, segment.direction, segment.length, [&](const DiscCrossing&) {
        crosses = true;
        return false;
      });
      if (!crosses) continue;
      if (absorbs_ && ends) {
        // As transmittance() has it.
        const RGB behind = absorption(scene_, hit.triangle, -ray.direction);
        for (int c = 0; c < 3; ++c) segment.absorption[c] = std::max(segment.absorption[c], behind[c]);
      }
      result_->segments.push_back(segment);
      if (settings_.pilot) result_->segment_path.push_back(paths_.number[i]);
    }
  }

  /// Takes off what volumes absorb of the paths on their way to their hits.
  void absorb() {
    for (std::size_t i = 0; i < paths_.count; ++i) {
      const Hit& hit = paths_.hits[i];
      if (hit.triangle == kNone) continue;
      const RGB left = transmittance(scene_, paths_.medium[i], paths_.rays[i], hit);
      for (int c = 0; c < 3; ++c) {
        const float before = paths_.flux[c][i];
        paths_.flux[c][i] *= left[c];
        result_->balance.arrived[c] += static_cast<double>(before - paths_.flux[c][i]);
      }
    }
  }

  /// Pair `dimension` of the random numbers of paths index_[0..count).
  void draw(std::uint32_t dimension, std::size_t count, Pairs& pairs) {
    sobol_pairs(Sampler::pair_key(pass_.seed, hash_combine(kPhotonStream, pass_.pass), dimension), index_.data(), count,
                pairs.x.data(), pairs.y.data());
  }

  void emit(std::uint64_t first_path, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) index_[i] = static_cast<std::uint32_t>(first_path + i);
    draw(0, count, direction_);
    draw(1, count, choice_);
    draw(2, count, light_);
    result_->emitted_light.resize(count);
    paths_.count = 0;
    for (std::size_t first = 0; first < count; first += EmissionBlock::kBlock)
      emit_block(first, std::min(EmissionBlock::kBlock, count - first));
  }

  /// Emits paths [first, first + count) and appends them.
  void emit_block(std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t path = first + i;
      EmissionNumbers numbers = {light_.x[path], choice_.x[path], choice_.y[path], direction_.x[path],
                                 direction_.y[path]};
      const float guide_weight = pass_.guide ? pass_.guide->warp(numbers) : 1.0f;
      emission_.set_numbers(i, numbers, guide_weight);
      if (!settings_.pilot) continue;
      result_->numbers.push_back(numbers);
      result_->guide_weight.push_back(guide_weight);
    }
    emission_.emit(scene_, count);
    for (int c = 0; c < 3; ++c)
      result_->balance.emitted[c] += sum(count, [flux = emission_.flux_channel(c)](std::size_t i) { return flux[i]; });
    std::size_t at = paths_.count;
    for (std::size_t i = 0; i < count; ++i) {
      const RGB flux = emission_.flux(i);
      result_->emitted_light[first + i] = emission_.light(i);
      paths_.rays[at] = photon_ray(emission_.origin(i), emission_.direction(i), 0);
      for (int c = 0; c < 3; ++c) paths_.flux[c][at] = flux[c];
      paths_.number[at] = static_cast<std::uint32_t>(first + i);
      paths_.light[at] = emission_.light(i);
      paths_.bounces[at] = is_delta(emission_.light(i)) ? kNoneBroad | kFromDelta : kNoneBroad;
      paths_.medium[at] = {};
      at += !is_black(flux) && may_leave(pass_.choice, paths_.bounces[at]);
    }
    paths_.count = at;
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
         may_have_lobes(scene_, vertex.point, scene_.geometry().material[hit.triangle], kBroad))) {
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
    for (std::size_t i = before; pass_.demand && i < at; ++i)
      photons.used[i] = demand_for(pass_, position[i], normal[i], caustic[i] != 0) > 0;
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
      if (absorbs_) keep_medium(first + i, i, kept);
      const bool may_store = may_leave(pass_.choice, bounces[kept]);
      kept += (block_.outcome(i) / kPathGoesOn) & std::uint32_t{may_store};
    }
    return kept;
  }

  /// Notes the volume that path number i of its block goes on in.
  void keep_medium(std::size_t path, std::size_t i, std::size_t kept) {
    const std::uint32_t triangle = paths_.hits[path].triangle;
    paths_.medium[kept] = {triangle == kNone ? RGB(0.0f) : absorption(scene_, triangle, block_.direction(i))};
  }

  const Scene& scene_;
  const PhotonChunkSettings& settings_;
  const PhotonPassSettings& pass_;
  LightPaths paths_;
  std::vector<std::uint32_t> index_ =
      std::vector<std::uint32_t>(kPathsPerChunk);  // of the paths, among all of the pass
  Pairs choice_, direction_, light_;
  EmissionBlock emission_;
  DiffuseHits block_;
  std::array<std::uint8_t, DiffuseHits::kBlock> bounce_ = {};  // the bits of each path's bounce
  PhotonChunk* result_ = nullptr;
  const bool absorbs_ = has_absorption(scene_);
};

float demand_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic) {
  if (!pass.demand) return 1;
  const float gathered = pass.choice != PhotonChoice::all ? 0.0f : pass.demand->gathered.value(position, normal);
  return gathered + (caustic ? pass.demand->seen.value(position, normal) : 0.0f);
}

ChunkTracers::ChunkTracers(const PhotonChunkSettings& settings) : settings_(settings) {}
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
  if (!tracer) tracer = std::make_unique<ChunkTracer>(settings_);
  tracer->trace(first, count, chunk);
  const std::scoped_lock lock(mutex_);
  idle_.push_back(std::move(tracer));
}

}  // namespace glowworm
