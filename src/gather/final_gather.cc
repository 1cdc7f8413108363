#include "gather/final_gather.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "core/part_queue.h"
#include "core/random.h"
#include "core/roulette.h"
#include "gather/direct_light.h"
#include "gather/gather_rays.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

/// Least radius of the spot that rays of a narrow lobe may meet, over that of photons. An estimate has the noise of
/// some fifty photons, which rays average if they spread over several discs.
constexpr float kSpotRadii = 3;

/// Samples of the direct light at the end of a short ray.
constexpr LightSampleCounts kSecondaryCounts{1, 1};
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
                SlotRadiance& radiance, GatherRays& rays, QueryPoints& queries, QueryPoints* caustic_queries)
      : tracer_(tracer),
        scene_(tracer.scene()),
        points_(points),
        settings_(settings),
        radiance_(radiance),
        rays_(rays),
        queries_(queries),
        caustic_queries_(caustic_queries) {}

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
      while (!rays_.rays.empty()) trace([](std::size_t) { return true; });
    }
    if (settings_.looks_at_patches()) look_at_patches(order);
  }

  std::uint64_t rays_traced = 0, shadow_rays = 0;

 private:
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
      fetch_ahead<false>(scene_, i, rays_.hits.size(), [&](std::size_t at) { return rays_.hits[at].triangle; });
      if (!counts(i)) continue;
      if (absorbs_ && rays_.hits[i].triangle != kNone)
        rays_.weight[i] *=
            transmittance(rays_.absorption[i], absorption(scene_, rays_.hits[i].triangle, -rays_.rays[i].direction),
                          rays_.hits[i].distance);
      if (rays_.hits[i].triangle != kNone && !weighs_patches(i) && ends_on_diffuse(i)) continue;
      if (advance(i)) rays_.move(i, kept++);
    }
    rays_.shrink(kept);
    ++segments_;
  }

  /// Whether the weight of ray i depends on the patch where it may end.
  bool weighs_patches(std::size_t i) const {
    return settings_.looks_at_patches() && rays_.segment[i] == Segment::first;
  }

  /// If ray i ends on a surface that only reflects diffusely, as most do, makes it a query point and returns true.
  bool ends_on_diffuse(std::size_t i) {
    const Hit& hit = rays_.hits[i];
    const Vec3 wo = -rays_.rays[i].direction;
    DiffusePoint point;
    if (scene_.diffuse_triangle(hit.triangle).kind & DiffuseTriangle::kEmits ||
        !diffuse_point(scene_, hit.triangle, hit.barycentric, point) || is_short(i, hit, point.position))
      return false;
    if (!is_black(point.reflectance))
      queries_.push_back(point.position, face_forward(point.geometric_normal, wo), point.reflectance, rays_.weight[i],
                         points_.slot[rays_.point[i]]);
    return true;
  }

  /// Processes the hit of ray i. Returns true if the ray continues.
  bool advance(std::size_t i) {
    const Hit& hit = rays_.hits[i];
    if (weighs_patches(i) && hit.triangle != kNone) weigh_against_patches(i, hit);
    const Vec3 wo = -rays_.rays[i].direction;
    if (hit.triangle == kNone) {
      if (!counts_light(i)) return false;
      add_light(i, environment_radiance(scene_, rays_.rays[i].direction),
                environment_source(scene_, rays_.rays[i].direction), [&](Vec3 from) {
                  return environment_pdf(scene_, from, {0, 0, 0}, rays_.rays[i].direction);
                });
      return false;
    }
    return !ends_on_diffuse(i) && advance_in_full(i, hit, wo);
  }

  /// The same for any surface.
  bool advance_in_full(std::size_t i, const Hit& hit, Vec3 wo) {
    SurfacePoint point = surface_point(scene_, hit.triangle, hit.barycentric);
    if (scene_.geometry().emission[hit.triangle] != kNone && counts_light(i))
      add_light(i, emitted_radiance(scene_, point, wo), scene_.emissive_index(hit.triangle), [&](Vec3 from) {
        return light_pdf(scene_, from, {0, 0, 0}, point);
      });
    Bsdf bsdf = resolve_bsdf(scene_, point);
    if (bsdf.dispersion > 0)
      rays_.weight[i] *= choose_wavelength(bsdf, rays_.weight[i],
                                           gather_ray_number(points_, rays_.point[i], rays_.stratum[i], settings_.seed,
                                                             kWavelengthStream + rays_.bounces[i]));
    if (is_lambertian(bsdf)) return arrive(i, hit, point, bsdf, wo, 1);
    const Lobes have = lobes(bsdf);
    if (!(have & kSharp)) return arrive(i, hit, point, bsdf, wo, 1);
    if (!(have & kBroad)) return follow(i, point, bsdf, wo, 1);
    const ShadedSurface surface = shaded(point, bsdf);
    const float broad = luminance(surface.albedo(wo, kBroad)), sharp = luminance(surface.albedo(wo, kSharp));
    const float probability = broad + sharp > 0 ? broad / (broad + sharp) : 1;
    // A secondary ray exists only for some numbers of the rays before it, so it needs another one.
    const bool is_second = rays_.segment[i] == Segment::secondary || rays_.segment[i] == Segment::secondary_chain;
    const std::uint32_t first_choice = kSplitStream + rays_.bounces[i];
    const std::uint32_t choice = is_second ? hash_combine(first_choice, segments_) : first_choice;
    const float u = gather_ray_number(points_, rays_.point[i], rays_.stratum[i], settings_.seed, choice);
    return u < probability ? arrive(i, hit, point, bsdf, wo, 1 / probability)
                           : follow(i, point, bsdf, wo, 1 / (1 - probability));
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
  template <typename PdfFrom>
  void add_light(std::size_t i, RGB emitted, std::uint32_t source, PdfFrom&& light_density_from) {
    if (is_black(emitted)) return;
    const std::uint32_t p = rays_.point[i];
    const Segment segment = rays_.segment[i];
    const bool secondary = segment == Segment::secondary;
    float weight = 1;
    if (is_direct(i))
      weight =
          balance_heuristic(static_cast<float>(settings_.rays), maker_.density(p).weighing_pdf(rays_.rays[i].direction),
                            static_cast<float>(settings_.light_samples), light_density_from(points_.position[p]));
    else if (secondary)
      weight = balance_heuristic(kSecondaryCounts.directions, rays_.pdf[i], kSecondaryCounts.light,
                                 light_density_from(rays_.scattered_at[i]));
    std::vector<RGB>& target = is_direct(i)                                       ? radiance_.direct
                               : secondary || segment == Segment::secondary_chain ? radiance_.indirect
                                                                                  : radiance_.caustic;
    radiance_.add(target, points_.slot[p], rays_.weight[i] * emitted * weight, source);
  }

  /// Processes a ray that ends on a broad lobe: makes query points, or starts a secondary gather if the ray is too
  /// short.
  bool arrive(std::size_t i, const Hit& hit, SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, float factor) {
    const RGB weight = rays_.weight[i] * factor;
    if (is_short(i, hit, point.position)) return secondary_gather(i, point, bsdf, wo, weight);
    const std::uint32_t slot = points_.slot[rays_.point[i]];
    const Vec3 normal = face_forward(point.geometric_normal, wo);
    add_query(queries_, point.position, normal, point.frame, wo, bsdf, weight, slot);
    return false;
  }

  bool is_secondary(std::size_t i) const { return rays_.segment[i] == Segment::secondary; }

  /// Secondary gather: caustics by their map, all other light by one more ray, whose direct light is weighted against
  /// that of one light sample. The sample alone would have no bound where a light touches a corner. Roulette ends rays
  /// that are short again.
  bool secondary_gather(std::size_t i, SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, RGB weight) {
    const std::uint32_t p = rays_.point[i];
    Sampler sampler(SamplerKind::sobol, settings_.seed,
                    hash_combine(hash_combine(points_.sequence[p], kGatherAgainStream + segments_), rays_.stratum[i]),
                    points_.sample[p]);
    const Vec2 u_light = sampler.next2();
    const LightSample sample = sample_light(scene_, point.position, {0, 0, 0}, u_light.x, {sampler.next1(), u_light.y});
    const UnoccludedLight light = reflected_light(scene_, sample, point, bsdf, wo, kBroad, kSecondaryCounts);
    if (!settings_.photons_alone && !is_black(light.radiance)) {
      ++shadow_rays;
      radiance_.add(radiance_.indirect, points_.slot[p],
                    weight * light.radiance * tracer_.transmittance(light.shadow_ray), light.source);
    }
    if (caustic_queries_)
      add_query(*caustic_queries_, point.position, face_forward(point.geometric_normal, wo), point.frame, wo, bsdf,
                weight, points_.slot[p]);
    const float u_lobe = sampler.next1();
    Vec2 u = sampler.next2();
    float factor = guide(point, bsdf, wo, u);
    const ScatteredRay s = shaded(point, bsdf).sample(wo, u_lobe, u, kBroad);
    if (is_secondary(i)) {
      const float survival = std::min(max_component(s.weight * factor), kMostSurvival);
      if (!(sampler.next1() < survival)) return false;
      factor /= survival;
    }
    return leave(i, point, s, weight * factor, Segment::secondary);
  }

  /// Warps the random numbers of a ray from a diffuse point where the guide knows more light, and turns the point's
  /// frame to that of the guide. Returns the factor on the ray's weight.
  float guide(SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, Vec2& u) const {
    if (!settings_.guide || !is_lambertian(bsdf)) return 1;
    const Vec3 normal = face_forward(point.frame.n, wo);
    const std::uint32_t region = settings_.guide->region(point.position, normal);
    if (region == kNoTable) return 1;
    point.frame = GatherGuide::frame(normal);
    return settings_.guide->warp(region, u);
  }

  /// Continues through the sharp lobes.
  bool follow(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, float factor) {
    const std::uint32_t bounces = ++rays_.bounces[i];
    const std::uint32_t p = rays_.point[i];
    Sampler sampler(SamplerKind::sobol, settings_.seed,
                    hash_combine(hash_combine(points_.sequence[p], kSharpStream + bounces), rays_.stratum[i]),
                    points_.sample[p]);
    const RGB weight = rays_.weight[i] * factor;
    const bool second = rays_.segment[i] == Segment::secondary || rays_.segment[i] == Segment::secondary_chain;
    const float u_lobe = sampler.next1();
    const ScatteredRay s = shaded(point, bsdf).sample(wo, u_lobe, sampler.next2(), kSharp);
    if (!s.valid) return false;
    const float kept = max_component(weight * s.weight) / max_component(rays_.weight[i]);
    float& chain = rays_.chain[i];
    chain = bounces == 1 ? kept : kept * chain;
    const float probability = survival(chain, kLeastOfChains, static_cast<int>(bounces));
    if (probability < 1) {
      if (!(probability > 0) || sampler.next1() >= probability) return false;
      chain /= probability;
    }
    return leave(i, point, s, weight / probability, second ? Segment::secondary_chain : Segment::chain);
  }

  /// The segment behind a pane.
  static Segment behind_pane(Segment before) {
    return before == Segment::first || before == Segment::to_patch ? Segment::through_panes : before;
  }

  /// Makes ray i leave a point where it ended. Returns whether it has anywhere to go.
  bool leave(std::size_t i, const SurfacePoint& point, const ScatteredRay& s, RGB weight, Segment next) {
    if (!s.valid || is_black(s.weight)) return false;
    rays_.rays[i] = leave_surface(point.position, s.side, point.offset, s.direction);
    rays_.weight[i] = weight * s.weight;
    if (s.straight) {
      rays_.segment[i] = behind_pane(rays_.segment[i]);
    } else {
      rays_.segment[i] = next;
      rays_.pdf[i] = s.pdf;
      rays_.scattered_at[i] = point.position;
    }
    rays_.absorption[i] = absorption(scene_, point.triangle, s.direction);
    return true;
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
  const bool absorbs_ = has_absorption(scene_);
};

/// Working memory, reused for one chunk after another.
struct ChunkMemory {
  GatherRays rays;
  QueryPoints queries, caustic_queries;
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
  if (first >= last || settings.rays == 0) return;
  queries.reserve((last - first) * (settings.rays + (settings.looks_at_patches() ? settings.patch_samples : 0)));
  const std::size_t per_chunk = points_of_chunk(settings.rays);
  const std::size_t chunks = (last - first + per_chunk - 1) / per_chunk;
  PartQueue<ChunkMemory> queue(chunks, [&](const ChunkMemory& chunk) {
    queries.append(chunk.queries);
    if (caustic_queries) caustic_queries->append(chunk.caustic_queries);
  });
  parallel_for(0, chunks, 1, [&](std::size_t, std::size_t) {
    const std::size_t chunk = queue.take();
    const std::size_t begin = first + chunk * per_chunk, end = std::min(begin + per_chunk, last);
    std::unique_ptr<ChunkMemory> memory = queue.borrow();
    ChunkGatherer gatherer(tracer, points, settings, radiance, memory->rays, memory->queries,
                           caustic_queries ? &memory->caustic_queries : nullptr);
    gatherer.gather(begin, end);
    statistics.add(Counter::gather_rays, gatherer.rays_traced);
    statistics.add(Counter::occlusion_rays, gatherer.shadow_rays);
    queue.put(chunk, std::move(memory));
  });
}

void add_query(QueryPoints& queries, Vec3 position, Vec3 normal, const Frame& frame, Vec3 wo, const Bsdf& bsdf,
               RGB weight, std::uint32_t target) {
  if (bsdf.kind != BsdfKind::lambertian) {
    const QueryBsdf query{bsdf, frame.s, frame.t, frame.n, ShadedSurface(bsdf, frame, normal).seen_from(wo)};
    queries.push_back(position, normal, query, weight, target);
    if (bsdf.kind == BsdfKind::metallic_roughness && bsdf.diffuse_transmission > 0)
      queries.push_back(position, -normal, query, weight, target);
    return;
  }
  if (!is_black(bsdf.diffuse)) queries.push_back(position, normal, bsdf.diffuse, weight, target);
  if (!is_black(bsdf.transmission)) queries.push_back(position, -normal, bsdf.transmission, weight, target);
}

QueryPoints gather_points_as_queries(const GatherPoints& points) {
  QueryPoints queries;
  queries.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    add_query(queries, points.position[i], points.normal[i], points.frame[i], points.wo[i], points.bsdf[i],
              points.throughput[i], points.slot[i]);
  return queries;
}

void complete(const QueryPoints& queries, std::span<const RGB> queried, std::span<RGB> target, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::completion);
  for (std::size_t i = 0; i < queries.size(); ++i) target[queries.gather_point[i]] += queries.weight[i] * queried[i];
}

}  // namespace glowworm
