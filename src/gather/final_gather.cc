#include "gather/final_gather.h"

#include <algorithm>
#include <vector>

#include "core/make_parts.h"
#include "core/random.h"
#include "gather/gather_rays.h"
#include "gather/medium_walk.h"
#include "scene/surface.h"
#include "transport/light_connection.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Least radius of the spot that rays of a narrow lobe may meet, in radii of photons. An estimate has the noise of
/// some fifty photons, which rays average if they spread over several discs.
constexpr float kSpotRadii = 3;

/// Most likely survival of a ray that is short again: white rooms smaller than the photons' radius would never end.
constexpr float kMostSurvival = 0.9f;

/// Final gather rays per piece of parallel work.
constexpr std::size_t kRaysPerChunk = 32768;
/// Of these, so many, or one stratum, are traced at a time: their arrays fit into the second-level cache.
constexpr std::size_t kRaysAtOnce = 2048;

/// Gather points of each chunk except the last, which may have fewer.
std::size_t points_of_chunk(std::uint32_t rays_each) {
  constexpr std::size_t kMaxPoints = 2048;
  return std::clamp<std::size_t>(kRaysPerChunk / rays_each, 1, kMaxPoints);
}

/// Strata of a chunk that are traced at a time. All chunks use the same number, whatever their size, so that the light
/// of a point is summed in the same order in any task.
std::uint32_t strata_under_way(std::uint32_t rays_each) {
  return static_cast<std::uint32_t>(std::max<std::size_t>(1, kRaysAtOnce / points_of_chunk(rays_each)));
}

class ChunkGatherer {
 public:
  ChunkGatherer(const Tracer& tracer, const GatherPoints& points, const FinalGatherSettings& settings,
                SlotRadiance& radiance, GatherRays& rays, QueryPoints& queries, QueryPoints* caustic_queries,
                VolumeSegments& segments)
      : tracer_(tracer),
        scene_(tracer.scene()),
        points_(points),
        settings_(settings),
        radiance_(radiance),
        rays_(rays),
        queries_(queries),
        caustic_queries_(caustic_queries),
        walk_(tracer, radiance, segments, settings.photons_alone) {}

  void gather(std::size_t first, std::size_t last) {
    queries_.clear();
    if (caustic_queries_) caustic_queries_->clear();
    std::vector<std::uint32_t> order;
    coherent_order(points_, first, last, order);
    maker_.prepare(points_, order, settings_.rays, settings_.seed, settings_.guide);
    queries_.reserve(order.size() * settings_.rays);
    const std::uint32_t strata_at_once = strata_under_way(settings_.rays);
    for (std::uint32_t stratum = 0; stratum < settings_.rays; stratum += strata_at_once) {
      start_rays();
      maker_.create(stratum, std::min(settings_.rays, stratum + strata_at_once), rays_);
      enter_media();
      while (!rays_.rays.empty()) trace([](std::size_t) { return true; });
    }
    if (settings_.looks_at_patches()) look_at_patches(order);
  }

  std::uint64_t rays_traced = 0;
  std::uint64_t shadow_rays() const { return shadow_rays_ + walk_.shadow_rays; }

 private:
  /// Sets the media in which rays start.
  void enter_media() {
    if (points_.media.empty()) return;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const std::uint32_t p = rays_.point[i];
      rays_.medium[i] = points_.media[p].towards(rays_.rays[i].direction, points_.normal[p]);
    }
  }

  /// Takes ray i through media and interfaces. Returns false if nothing comes from behind.
  bool cross_media(std::size_t i) {
    PathState path = rays_.path(i);
    Sampler sampler = sampler_of(i, kMediumStream + segments_);
    // Rays to patches find the light of these alone.
    std::vector<RGB>* const part = rays_.segment[i] == Segment::to_patch ? nullptr : &radiance_.indirect;
    const bool goes_on =
        walk_.cross(path, rays_.hits[i], RayOrder::incoherent, {part, points_.slot[rays_.point[i]], true}, sampler);
    rays_.put(i, path);
    return goes_on;
  }

  void start_rays() {
    rays_.clear();
    segments_ = 0;
  }

  /// Traces rays to bright patches. A ray counts if nothing is in its way.
  void look_at_patches(std::span<const std::uint32_t> order) {
    start_rays();
    std::vector<std::uint32_t> targets;
    create_patch_rays(scene_, *settings_.bright, points_, order,
                      {settings_.rays, settings_.patch_samples, settings_.seed}, rays_, targets);
    enter_media();
    if (!rays_.rays.empty()) trace([&](std::size_t i) { return meets(i, targets[i]); });
    while (!rays_.rays.empty()) trace([](std::size_t) { return true; });
  }

  bool meets(std::size_t i, std::uint32_t patch) const {
    const Hit& hit = rays_.hits[i];
    return hit.triangle != kNone && settings_.bright->find(hit.triangle, hit.barycentric) == patch;
  }

  /// Weights a BSDF-sampled ray that ends on a bright patch against the rays to patches.
  void weigh_against_patches(std::size_t i, const Hit& hit) {
    const std::uint32_t patch = settings_.bright->find(hit.triangle, hit.barycentric);
    if (patch != kNone)
      rays_.weight[i] *= patch_weight(scene_, *settings_.bright, patch, rays_.rays[i], hit, rays_.pdf[i],
                                      settings_.rays, settings_.patch_samples);
  }

  /// Traces all rays to their next hits. Drops rays that end there or that `counts` rejects.
  template <typename Counts>
  void trace(Counts&& counts) {
    rays_.hits.resize(rays_.rays.size());
    tracer_.intersect(rays_.rays, rays_.hits, RayOrder::incoherent);
    rays_traced += rays_.rays.size();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rays_.rays.size(); ++i) {
      if (crosses_media_ && !cross_media(i)) continue;
      if (!counts(i)) continue;
      if (rays_.hits[i].triangle != kNone && !weighs_patches(i) && ends_on_diffuse(i)) continue;
      if (advance(i)) rays_.move(i, kept++);
    }
    rays_.resize(kept);
    ++segments_;
  }

  /// Whether the weight of ray i depends on the patch where it may end.
  bool weighs_patches(std::size_t i) const {
    return settings_.looks_at_patches() && rays_.segment[i] == Segment::first;
  }

  /// If ray i ends on a surface that only reflects diffusely, as most do, makes it a query point and returns true.
  bool ends_on_diffuse(std::size_t i) {
    const Hit& hit = rays_.hits[i];
    DiffusePoint point;
    if (!diffuse_vertex(scene_, hit, point) || is_short(i, hit, point.position)) return false;
    add_query(queries_, point, -rays_.rays[i].direction, rays_.weight[i], points_.slot[rays_.point[i]]);
    return true;
  }

  /// What gather rays do on their step.
  struct Policy {
    ChunkGatherer& gatherer;
    std::size_t ray;
    PathState& path;

    bool finds_light() const { return gatherer.counts_light(ray); }
    template <typename Density>
    void add_light(RGB light, std::uint32_t source, Density&& density) {
      gatherer.add_light(ray, path, light, source, density);
    }
    float wavelength_number() const { return gatherer.number(ray, kWavelengthStream + gatherer.rays_.bounces[ray]); }
    bool scatter(Vertex& vertex) { return gatherer.scatter(ray, path, vertex); }
  };

  /// Processes the hit of ray i. Returns true if the ray continues.
  bool advance(std::size_t i) {
    const Hit& hit = rays_.hits[i];
    if (weighs_patches(i) && hit.triangle != kNone) {
      weigh_against_patches(i, hit);
      if (ends_on_diffuse(i)) return false;
    }
    PathState path = rays_.path(i);
    if (!meet(scene_, path, hit, Policy{*this, i, path})) return false;
    rays_.put(i, path);
    return true;
  }

  float number(std::size_t i, std::uint32_t what) const {
    return gather_ray_number(points_, rays_.point[i], rays_.stratum[i], settings_.seed, what);
  }

  bool scatter(std::size_t i, PathState& path, Vertex& vertex) {
    if (is_lambertian(vertex.bsdf)) return arrive(i, path, vertex);
    // A secondary ray exists only for some numbers of the rays before it, so it needs another one.
    const std::uint32_t first_choice = kSplitStream + rays_.bounces[i];
    const float before = max_component(path.throughput),
                u = number(i, is_second(i) ? hash_combine(first_choice, segments_) : first_choice);
    const LobeChoice choice = vertex.surface().choose_lobes(vertex.wo, u);
    if (!(choice.probability > 0)) return false;
    path.throughput *= 1 / choice.probability;
    if (choice.lobes == kDiffuse) return arrive(i, path, vertex);
    return choice.lobes == kGlossy ? secondary_gather(i, path, vertex, kGlossy) : follow(i, path, vertex, before);
  }

  /// Whether light that ray i meets is direct light of the gather point, which light samples bring, too.
  bool is_direct(std::size_t i) const {
    return rays_.segment[i] == Segment::first || rays_.segment[i] == Segment::through_panes;
  }

  /// Whether the final gather adds the light that ray i meets.
  bool counts_light(std::size_t i) const {
    switch (rays_.segment[i]) {
      case Segment::first:
      case Segment::through_panes:
        return settings_.light_samples > 0;
      case Segment::chain:
        return settings_.adds_caustics;
      case Segment::secondary:
        return !settings_.photons_alone;
      case Segment::secondary_chain:
        return !settings_.photons_alone && !caustic_queries_;
      case Segment::to_patch:
        return false;
    }
    return false;
  }

  /// Whether the photons' radius at `position`, where ray i ends, is large beside the ray's length, or beside the spot
  /// that rays of its lobe meet there. Then it needs a secondary gather: the estimates of a point's rays would all be
  /// blurred, or be of the same few photons.
  bool is_short(std::size_t i, const Hit& hit, Vec3 position) const {
    const bool first = rays_.segment[i] == Segment::first;
    const bool is_counted = first || rays_.segment[i] == Segment::to_patch || (settings_.gathers_on && is_secondary(i));
    if (!settings_.radii || !is_counted) return false;
    const float narrowness = first ? std::max(kPi * rays_.pdf[i] - 1, 0.0f) : 0.0f;
    const float length_squared = hit.distance * hit.distance / (1 + kSpotRadii * kSpotRadii * narrowness);
    const auto reaches = [&](float radius) { return length_squared < radius * radius; };
    return reaches(settings_.radii->max_radius()) && reaches(settings_.radii->radius(position));
  }

  /// Adds the light that a ray meets, if counts_light(i). A ray straight from the gather point, or from the end of a
  /// short ray, is a sample of direct light there, and is weighted against the light samples.
  /// @param source light source, counted as in Scene::light_power()
  template <typename Density>
  void add_light(std::size_t i, const PathState& path, RGB emitted, std::uint32_t source, Density&& density) {
    const std::uint32_t p = rays_.point[i];
    const Segment segment = rays_.segment[i];
    const bool secondary = segment == Segment::secondary;
    float weight = 1;
    if (is_direct(i))
      weight = balance_heuristic(static_cast<float>(settings_.rays), maker_.density(p).weighing_pdf(path.ray.direction),
                                 static_cast<float>(settings_.light_samples), density(points_.position[p]));
    else if (secondary)
      weight = weight_of_met_light(path, density);
    std::vector<RGB>& target = is_direct(i)                                       ? radiance_.direct
                               : secondary || segment == Segment::secondary_chain ? radiance_.indirect
                                                                                  : radiance_.caustic;
    radiance_.add(target, points_.slot[p], path.throughput * emitted * weight, source);
  }

  /// Processes a ray that ends on a diffuse lobe: makes query points, or starts a secondary gather if the ray is too
  /// short.
  bool arrive(std::size_t i, PathState& path, Vertex& vertex) {
    if (is_short(i, rays_.hits[i], vertex.point.position)) return secondary_gather(i, path, vertex, kDiffuse);
    add_query(queries_, vertex, path.throughput, points_.slot[rays_.point[i]], kDiffuse);
    return false;
  }

  bool is_secondary(std::size_t i) const { return rays_.segment[i] == Segment::secondary; }
  bool is_second(std::size_t i) const { return is_secondary(i) || rays_.segment[i] == Segment::secondary_chain; }

  /// Secondary gather: caustics by their map, all other light by one more ray, whose direct light is weighted against
  /// that of one light sample. The sample alone would have no bound where a light touches a corner. Roulette ends rays
  /// that are short again. Glossy lobes are always gathered: few photons lie in their directions, and estimates on
  /// curved parts count photons whose directions lie behind the surface at the end of the ray.
  bool secondary_gather(std::size_t i, PathState& path, Vertex& vertex, Lobes lobes) {
    const std::uint32_t p = rays_.point[i];
    Sampler sampler = sampler_of(i, kGatherAgainStream + segments_);
    const Vec2 u_light = sampler.next2();
    const LightSample sample = sample_light(scene_, vertex, u_light, sampler.next1());
    const UnoccludedLight light = reflected_light(sample, vertex, lobes, lobes);
    if (!settings_.photons_alone && !is_black(light.radiance)) {
      ++shadow_rays_;
      radiance_.add(radiance_.indirect, points_.slot[p],
                    path.throughput * light.radiance * passed_share(tracer_, light), light.source);
    }
    if (caustic_queries_) add_query(*caustic_queries_, vertex, path.throughput, points_.slot[p], lobes);
    const float u_lobe = sampler.next1();
    Vec2 u = sampler.next2();
    float factor = guide(vertex, u);
    const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, u, lobes);
    if (is_secondary(i)) {
      const float survival = std::min(max_component(s.weight * factor), kMostSurvival);
      if (!(sampler.next1() < survival)) return false;
      factor /= survival;
    }
    path.throughput *= factor;
    return leave_for(i, path, vertex, s, Segment::secondary);
  }

  /// Random numbers of a ray's bounce.
  Sampler sampler_of(std::size_t i, std::uint32_t stream) const {
    const std::uint32_t p = rays_.point[i];
    return {SamplerKind::sobol, settings_.seed,
            hash_combine(hash_combine(points_.sequence[p], stream), rays_.stratum[i]), points_.sample[p]};
  }

  /// Warps the random numbers of a ray from a diffuse point where the guide knows more light, and turns the point's
  /// frame to the guide's. Returns the factor on the ray's weight.
  float guide(Vertex& vertex, Vec2& u) const {
    if (!settings_.guide || !is_lambertian(vertex.bsdf)) return 1;
    const Vec3 normal = face_forward(vertex.point.frame.n, vertex.wo);
    const std::uint32_t region = settings_.guide->region(vertex.point.position, normal);
    if (region == kNoTable) return 1;
    vertex.point.frame = GatherGuide::frame(normal);
    return settings_.guide->warp(region, u);
  }

  /// Continues through the specular lobes. @param before largest component of the throughput that arrived
  bool follow(std::size_t i, PathState& path, const Vertex& vertex, float before) {
    const std::uint32_t bounces = ++rays_.bounces[i];
    Sampler sampler = sampler_of(i, kSpecularStream + bounces);
    const Segment next = is_second(i) ? Segment::secondary_chain : Segment::chain;
    const float u_lobe = sampler.next1();
    const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler.next2(), kSpecular);
    if (!leave_for(i, path, vertex, s, next)) return false;
    const float kept = max_component(path.throughput) / before;
    float& chain = rays_.chain[i];
    chain = bounces == 1 ? kept : kept * chain;
    const float probability =
        survive(path, chain, kLeastOfChains, static_cast<int>(bounces), [&] { return sampler.next1(); });
    if (!(probability > 0)) return false;
    chain /= probability;
    return true;
  }

  /// The segment behind a pane.
  static Segment behind_pane(Segment before) {
    return before == Segment::first || before == Segment::to_patch ? Segment::through_panes : before;
  }

  /// Sends ray i on from a vertex. Returns whether it has anywhere to go.
  bool leave_for(std::size_t i, PathState& path, const Vertex& vertex, const ScatteredRay& s, Segment next) {
    rays_.segment[i] = s.is_null ? behind_pane(rays_.segment[i]) : next;
    return leave(path, vertex, s, s.weight);
  }

  const Tracer& tracer_;
  const Scene& scene_;
  const GatherPoints& points_;
  const FinalGatherSettings& settings_;
  SlotRadiance& radiance_;
  GatherRays& rays_;
  GatherRayMaker maker_;
  QueryPoints& queries_;
  QueryPoints* caustic_queries_;  // null: there is no caustic map
  std::uint32_t segments_ = 0;    // of the paths under way, before those being traced
  MediumWalk walk_;
  std::uint64_t shadow_rays_ = 0;
  const bool crosses_media_ = scene_.crosses_media();
};

/// Working memory, reused for one chunk after another.
struct ChunkMemory {
  GatherRays rays;
  QueryPoints queries, caustic_queries;
  VolumeSegments segments;
};

}  // namespace

void final_gather(const Tracer& tracer, const GatherPoints& points, std::size_t first, std::size_t last,
                  const FinalGatherSettings& settings, SlotRadiance& radiance, const GatherQueries& found,
                  Statistics& statistics) {
  QueryPoints& queries = found.queries;
  QueryPoints* const caustic_queries = found.caustic_queries;
  const PhaseTimer timer(statistics, Phase::gather_rays);
  queries.clear();
  if (caustic_queries) caustic_queries->clear();
  if (found.segments) found.segments->clear();
  if (first >= last || settings.rays == 0) return;
  queries.reserve((last - first) * (settings.rays + (settings.looks_at_patches() ? settings.patch_samples : 0)));
  const std::size_t per_chunk = points_of_chunk(settings.rays);
  const std::size_t chunks = (last - first + per_chunk - 1) / per_chunk;
  const auto gather = [&](std::size_t chunk, ChunkMemory& memory) {
    const std::size_t begin = first + chunk * per_chunk, end = std::min(begin + per_chunk, last);
    memory.segments.clear();
    ChunkGatherer gatherer(tracer, points, settings, radiance, memory.rays, memory.queries,
                           caustic_queries ? &memory.caustic_queries : nullptr, memory.segments);
    gatherer.gather(begin, end);
    statistics.add(Counter::gather_rays, gatherer.rays_traced);
    statistics.add(Counter::occlusion_rays, gatherer.shadow_rays());
  };
  make_parts<ChunkMemory>(chunks, gather, [&](const ChunkMemory& chunk) {
    queries.append(chunk.queries);
    if (caustic_queries) caustic_queries->append(chunk.caustic_queries);
    if (found.segments) found.segments->append(chunk.segments);
  });
}

void complete(const QueryPoints& queries, std::span<const RGB> queried, std::span<RGB> target, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::completion);
  for (std::size_t i = 0; i < queries.size(); ++i) target[queries.gather_point[i]] += queries.weight[i] * queried[i];
}

}  // namespace glowworm
