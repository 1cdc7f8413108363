#include "gather/final_gather.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "gather/direct_light.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

/// Final gather rays that one piece of parallel work traces at once.
constexpr std::size_t kRaysPerChunk = 4096;
constexpr int kRouletteAfter = 2;

/// Which part of its path a gather ray is.
enum class Segment : std::uint8_t {
  first,       ///< straight from the gather point
  chain,       ///< behind a sharp bounce: lights seen through it are the caustic map's
  again,       ///< straight from a corner that gathers once more: its direct light is sampled there
  again_chain  ///< behind a sharp bounce after that: nothing else counts the lights seen through it
};

/// Rays under way.
struct GatherRays {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<RGB> weight;
  std::vector<float> pdf;  ///< of the direction from the gather point, per steradian
  std::vector<std::uint32_t> point;
  std::vector<std::uint32_t> stratum;
  std::vector<Segment> segment;
  std::vector<std::uint8_t> bounces;

  void move(std::size_t from, std::size_t to) {
    if (from == to) return;
    rays[to] = rays[from];
    weight[to] = weight[from];
    pdf[to] = pdf[from];
    point[to] = point[from];
    stratum[to] = stratum[from];
    segment[to] = segment[from];
    bounces[to] = bounces[from];
  }
  void shrink(std::size_t n) {
    rays.resize(n);
    weight.resize(n);
    pdf.resize(n);
    point.resize(n);
    stratum.resize(n);
    segment.resize(n);
    bounces.resize(n);
  }
  void push_back(const Ray& ray, RGB w, float density, std::uint32_t gather_point, std::uint32_t cell) {
    rays.push_back(ray);
    weight.push_back(w);
    pdf.push_back(density);
    point.push_back(gather_point);
    stratum.push_back(cell);
    segment.push_back(Segment::first);
    bounces.push_back(0);
  }
};

/// The cells that the square of directions is cut into: columns * rows = count, as square as may be.
struct Strata {
  std::uint32_t columns, rows;
  explicit Strata(std::uint32_t count) : columns(1), rows(count) {
    for (std::uint32_t c = 1; c * c <= count; ++c)
      if (count % c == 0) columns = c;
    rows = count / columns;
    // A prime count has no near-square factors: then one long row would be no strata at all.
    if (columns * 4 < rows) columns = rows = 0;
  }
  bool usable() const { return columns > 0; }
};

class ChunkGatherer {
 public:
  ChunkGatherer(const Tracer& tracer, const GatherPoints& points, const FinalGatherSettings& settings,
                SlotRadiance& radiance)
      : tracer_(tracer), scene_(tracer.scene()), points_(points), settings_(settings), radiance_(radiance) {}

  QueryPoints gather(std::size_t first, std::size_t last) {
    create(first, last);
    while (!rays_.rays.empty()) {
      rays_.hits.resize(rays_.rays.size());
      tracer_.intersect(rays_.rays, rays_.hits, RayOrder::incoherent);
      rays_traced += rays_.rays.size();
      std::size_t kept = 0;
      for (std::size_t i = 0; i < rays_.rays.size(); ++i)
        if (advance(i)) rays_.move(i, kept++);
      rays_.shrink(kept);
    }
    return std::move(queries_);
  }

  std::uint64_t rays_traced = 0, shadow_rays = 0;

 private:
  /// All rays of one stratum stand together: neighbours start near each other and point much the same way.
  void create(std::size_t first, std::size_t last) {
    const Strata strata(settings_.rays);
    const float share = 1.0f / static_cast<float>(settings_.rays);
    for (std::uint32_t cell = 0; cell < settings_.rays; ++cell)
      for (std::size_t i = first; i < last; ++i) {
        Vec2 u;
        if (strata.usable()) {
          Sampler sampler(SamplerKind::sobol, settings_.seed, hash_combine(points_.sequence[i], cell),
                          points_.sample[i]);
          u = sampler.next2();
          u.x = (static_cast<float>(cell % strata.columns) + u.x) / static_cast<float>(strata.columns);
          u.y = (static_cast<float>(cell / strata.columns) + u.y) / static_cast<float>(strata.rows);
        } else {
          Sampler sampler(SamplerKind::sobol, settings_.seed, hash_combine(points_.sequence[i], 0x67617468u),
                          points_.sample[i] * settings_.rays + cell);
          u = sampler.next2();
        }
        const float u_lobe = needs_lobe(points_.bsdf[i]) ? hashed(i, cell, 0x6c6f6265u) : 0;
        const Vec3 wo = points_.frame[i].to_local(points_.wo[i]);
        const BsdfSample s = sample(points_.bsdf[i], wo, u_lobe, u, kBroad, Transport::radiance);
        if (!s.valid || is_black(s.weight)) continue;
        Ray ray;
        if (!leave(points_.position[i], points_.normal[i], points_.frame[i].to_world(s.wi), s.wi.z * wo.z > 0, ray))
          continue;
        rays_.push_back(ray, points_.throughput[i] * s.weight * share, s.pdf, static_cast<std::uint32_t>(i), cell);
      }
  }

  static bool needs_lobe(const Bsdf& bsdf) { return !is_lambertian(bsdf); }

  float hashed(std::size_t point, std::uint32_t stratum, std::uint32_t what) const {
    const std::uint32_t key = hash_combine(hash_combine(settings_.seed ^ what, points_.sequence[point]), stratum);
    return to_unit_float(hash_combine(key, points_.sample[point]));
  }

  /// The ray that leaves a surface; false where shading normals would send it through an opaque one, or keep a
  /// transmitted one in. `normal` is on the side that the path came from.
  static bool leave(Vec3 position, Vec3 normal, Vec3 direction, bool reflected, Ray& ray) {
    const float side = dot(direction, normal);
    if ((side > 0) != reflected || side == 0) return false;
    ray = {offset_origin(position, side > 0 ? normal : -normal), 0, direction, std::numeric_limits<float>::infinity()};
    return true;
  }

  /// Takes ray i over its hit; true where it goes on.
  bool advance(std::size_t i) {
    const Hit& hit = rays_.hits[i];
    const Vec3 wo = -rays_.rays[i].direction;
    if (hit.triangle == kNone) {
      add_light(i, environment_radiance(scene_, rays_.rays[i].direction), [&](Vec3 from) {
        return environment_pdf(scene_, from, {0, 0, 0}, rays_.rays[i].direction);
      });
      return false;
    }
    SurfacePoint point = surface_point(scene_, hit.triangle, hit.barycentric);
    if (scene_.geometry().emission[hit.triangle] != kNone)
      add_light(i, emitted_radiance(scene_, point, wo), [&](Vec3 from) {
        return light_pdf(scene_, from, {0, 0, 0}, point);
      });
    const Bsdf bsdf = resolve_bsdf(scene_, point, wo);
    if (is_lambertian(bsdf)) return arrive(i, hit, point, bsdf, wo, 1);
    const Lobes have = lobes(bsdf);
    if (!(have & kSharp)) return arrive(i, hit, point, bsdf, wo, 1);
    if (!(have & kBroad)) return follow(i, point, bsdf, wo, 1);
    const Vec3 wo_local = point.frame.to_local(wo);
    const float broad = luminance(albedo(bsdf, wo_local, kBroad)), sharp = luminance(albedo(bsdf, wo_local, kSharp));
    const float probability = broad + sharp > 0 ? broad / (broad + sharp) : 1;
    const float u = hashed(rays_.point[i], rays_.stratum[i], 0x73706c69u + rays_.bounces[i]);
    return u < probability ? arrive(i, hit, point, bsdf, wo, 1 / probability)
                           : follow(i, point, bsdf, wo, 1 / (1 - probability));
  }

  /// What a ray that meets a light brings. Straight from the gather point it is a BSDF sample of direct light.
  template <typename PdfFrom>
  void add_light(std::size_t i, RGB emitted, PdfFrom&& light_density_from) {
    if (is_black(emitted)) return;
    const std::uint32_t p = rays_.point[i];
    if (rays_.segment[i] == Segment::first && settings_.light_samples > 0) {
      const float weight =
          balance_heuristic(static_cast<float>(settings_.rays), rays_.pdf[i],
                            static_cast<float>(settings_.light_samples), light_density_from(points_.position[p]));
      radiance_.direct[points_.slot[p]] += rays_.weight[i] * emitted * weight;
    } else if (rays_.segment[i] == Segment::again_chain) {
      radiance_.indirect[points_.slot[p]] += rays_.weight[i] * emitted;
    }
  }

  /// The ray ends on a broad lobe: it becomes query points, or gathers again where it is too short.
  bool arrive(std::size_t i, const Hit& hit, SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, float factor) {
    const RGB weight = rays_.weight[i] * factor;
    const bool may_gather_again = rays_.segment[i] == Segment::first && settings_.radii;
    if (may_gather_again && hit.distance < settings_.radii->max_radius() &&
        hit.distance < settings_.radii->radius(point.position))
      return gather_again(i, point, bsdf, wo, weight);
    const std::uint32_t slot = points_.slot[rays_.point[i]];
    const Vec3 normal = face_forward(point.geometric_normal, wo);
    if (bsdf.kind == BsdfKind::lambertian) {
      if (!is_black(bsdf.diffuse)) queries_.push_back(point.position, normal, bsdf.diffuse, weight, slot);
      if (!is_black(bsdf.transmission)) queries_.push_back(point.position, -normal, bsdf.transmission, weight, slot);
    } else {
      const Frame& f = point.frame;
      queries_.push_back(point.position, normal, QueryBsdf{bsdf, f.s, f.t, f.n, wo}, weight, slot);
    }
    return false;
  }

  /// Secondary final gather: direct light by a light sample, the rest by one more ray.
  bool gather_again(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, RGB weight) {
    const std::uint32_t p = rays_.point[i];
    Sampler sampler(SamplerKind::sobol, settings_.seed,
                    hash_combine(hash_combine(points_.sequence[p], 0x61676169u), rays_.stratum[i]), points_.sample[p]);
    const Vec2 u_light = sampler.next2();
    const UnoccludedLight light = sample_direct_light(scene_, point, bsdf, wo, kBroad, sampler.next1(), u_light, 1, 0);
    if (!is_black(light.radiance)) {
      ++shadow_rays;
      if (!tracer_.occluded(light.shadow_ray)) radiance_.indirect[points_.slot[p]] += weight * light.radiance;
    }
    return bounce(i, point, bsdf, wo, weight, kBroad, sampler, Segment::again);
  }

  /// Goes on through the sharp lobes.
  bool follow(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, float factor) {
    const int bounces = ++rays_.bounces[i];
    if (bounces > settings_.max_sharp_bounces) return false;
    const std::uint32_t p = rays_.point[i];
    Sampler sampler(SamplerKind::sobol, settings_.seed,
                    hash_combine(hash_combine(points_.sequence[p], 0x73686172u + static_cast<std::uint32_t>(bounces)),
                                 rays_.stratum[i]),
                    points_.sample[p]);
    RGB weight = rays_.weight[i] * factor;
    if (bounces > kRouletteAfter) {
      const float survival = 0.75f;
      if (sampler.next1() >= survival) return false;
      weight *= 1 / survival;
    }
    const bool second = rays_.segment[i] == Segment::again || rays_.segment[i] == Segment::again_chain;
    return bounce(i, point, bsdf, wo, weight, kSharp, sampler, second ? Segment::again_chain : Segment::chain);
  }

  bool bounce(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, RGB weight, Lobes which,
              Sampler& sampler, Segment next) {
    const Vec3 wo_local = point.frame.to_local(wo);
    const float u_lobe = sampler.next1();
    const BsdfSample s = sample(bsdf, wo_local, u_lobe, sampler.next2(), which, Transport::radiance);
    if (!s.valid || is_black(s.weight)) return false;
    const Vec3 normal = face_forward(point.geometric_normal, wo);
    if (!leave(point.position, normal, point.frame.to_world(s.wi), s.wi.z * wo_local.z > 0, rays_.rays[i]))
      return false;
    rays_.weight[i] = weight * s.weight;
    rays_.segment[i] = next;
    return true;
  }

  const Tracer& tracer_;
  const Scene& scene_;
  const GatherPoints& points_;
  const FinalGatherSettings& settings_;
  SlotRadiance& radiance_;
  GatherRays rays_;
  QueryPoints queries_;
};

}  // namespace

QueryPoints final_gather(const Tracer& tracer, const GatherPoints& points, std::size_t first, std::size_t last,
                         const FinalGatherSettings& settings, SlotRadiance& radiance, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::gather_rays);
  QueryPoints queries;
  if (first >= last || settings.rays == 0) return queries;
  const std::size_t per_chunk = std::max<std::size_t>(1, kRaysPerChunk / settings.rays);
  std::vector<QueryPoints> parts((last - first + per_chunk - 1) / per_chunk);
  parallel_for(first, last, per_chunk, [&](std::size_t begin, std::size_t end) {
    ChunkGatherer gatherer(tracer, points, settings, radiance);
    parts[(begin - first) / per_chunk] = gatherer.gather(begin, end);
    statistics.add(Counter::gather_rays, gatherer.rays_traced);
    statistics.add(Counter::occlusion_rays, gatherer.shadow_rays);
  });
  for (const QueryPoints& part : parts) queries.append(part);
  return queries;
}

QueryPoints gather_points_as_queries(const GatherPoints& points) {
  QueryPoints queries;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Bsdf& bsdf = points.bsdf[i];
    if (bsdf.kind == BsdfKind::lambertian) {
      queries.push_back(points.position[i], points.normal[i], bsdf.diffuse, points.throughput[i], points.slot[i]);
      if (!is_black(bsdf.transmission))
        queries.push_back(points.position[i], -points.normal[i], bsdf.transmission, points.throughput[i],
                          points.slot[i]);
    } else {
      const Frame& f = points.frame[i];
      queries.push_back(points.position[i], points.normal[i], QueryBsdf{bsdf, f.s, f.t, f.n, points.wo[i]},
                        points.throughput[i], points.slot[i]);
    }
  }
  return queries;
}

void complete(const QueryPoints& queries, std::span<const RGB> queried, std::span<RGB> target, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::completion);
  for (std::size_t i = 0; i < queries.size(); ++i) target[queries.gather_point[i]] += queries.weight[i] * queried[i];
}

}  // namespace glowworm
