// The public header glowworm/rays.h.
#include "glowworm/rays.h"

#include <cmath>
#include <limits>
#include <string>

#include "api/checks.h"
#include "api/scene_implementation.h"
#include "core/error.h"
#include "core/parallel.h"

namespace glowworm::api {

namespace {

/// Rays that a thread traces at once: they fit into its cache.
constexpr std::size_t kBlock = 1024;

void check(const Rays& rays) {
  const std::size_t count = rays.origin.size();
  check_lengths(rays.direction.size(), count, "directions", "origins");
  if (rays.t_max.size() > 1) check_lengths(rays.t_max.size(), count, "values of t_max", "origins");
  if (!(rays.t_min >= 0)) throw Error("t_min of rays is negative or not a number", "Give 0 or more.");
}

/// Makes rays [first, last). Throws Error for numbers that make no ray.
void make_rays(const Rays& from, std::size_t first, std::size_t last, std::vector<Ray>& rays) {
  rays.resize(last - first);
  for (std::size_t i = first; i < last; ++i) {
    const Vec3 &o = from.origin[i], &d = from.direction[i];
    const glowworm::Vec3 origin{o.x, o.y, o.z}, direction{d.x, d.y, d.z};
    const float far = from.t_max.empty()       ? std::numeric_limits<float>::infinity()
                      : from.t_max.size() == 1 ? from.t_max[0]
                                               : from.t_max[i];
    if (!is_finite(origin) || !is_finite(direction) || std::isnan(far))
      throw Error("ray " + std::to_string(i) + " is not finite");
    if (!(dot(direction, direction) > 0)) throw Error("the direction of ray " + std::to_string(i) + " has no length");
    rays[i - first] = {origin, from.t_min, direction, far};
  }
}

}  // namespace

Hits Tracer::intersect(const Rays& rays) const {
  check(rays);
  const std::size_t count = rays.origin.size();
  Hits out;
  out.distance.resize(count);
  out.triangle.resize(count);
  out.barycentric.resize(count);
  out.normal.resize(count);
  const glowworm::Scene& scene = *scene_.implementation().scene;
  const glowworm::Tracer& tracer = *scene_.implementation().tracer;
  parallel_for(0, count, kBlock, [&](std::size_t first, std::size_t last) {
    static thread_local std::vector<Ray> batch;
    static thread_local std::vector<Hit> hits;
    make_rays(rays, first, last, batch);
    hits.resize(batch.size());
    tracer.intersect(batch, hits, RayOrder::incoherent);
    for (std::size_t i = first; i < last; ++i) {
      const Hit& hit = hits[i - first];
      const bool found = hit.triangle != kNone;
      out.distance[i] = found ? hit.distance : std::numeric_limits<float>::infinity();
      out.triangle[i] = hit.triangle;
      out.barycentric[i] = found ? Vec2{hit.barycentric.x, hit.barycentric.y} : Vec2();
      const glowworm::Vec3 n = found ? scene.diffuse_triangle(hit.triangle).normal : glowworm::Vec3();
      out.normal[i] = {n.x, n.y, n.z};
    }
  });
  return out;
}

std::vector<std::uint8_t> Tracer::occluded(const Rays& rays) const {
  check(rays);
  std::vector<std::uint8_t> out(rays.origin.size());
  const glowworm::Tracer& tracer = *scene_.implementation().tracer;
  parallel_for(0, out.size(), kBlock, [&](std::size_t first, std::size_t last) {
    static thread_local std::vector<Ray> batch;
    make_rays(rays, first, last, batch);
    tracer.occluded(batch, std::span(out).subspan(first, last - first));
  });
  return out;
}

}  // namespace glowworm::api
