// The public header glowworm/rays.h.
#include "glowworm/rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
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

float t_max_of(const Rays& rays, std::size_t i) {
  if (rays.t_max.empty()) return std::numeric_limits<float>::infinity();
  return rays.t_max[rays.t_max.size() == 1 ? 0 : i];
}

/// Throws Error for the first of rays [first, last) whose numbers make no ray.
void check_numbers(const Rays& rays, std::size_t first, std::size_t last) {
  // Vectors of integers find whether there may be one: a number is finite if it is less than infinity without its sign.
  constexpr std::uint32_t kInfinity = 0x7f800000u;
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value) & 0x7fffffffu; };
  std::uint32_t greatest = 0, shortest = kInfinity;
  for (std::size_t i = first; i < last; ++i) {
    const Vec3 &o = rays.origin[i], &d = rays.direction[i];
    greatest = std::max({greatest, bits(o.x), bits(o.y), bits(o.z), bits(d.x), bits(d.y), bits(d.z)});
    shortest = std::min(shortest, std::max({bits(d.x), bits(d.y), bits(d.z)}));
  }
  // Squares of greater numbers are not 0.
  bool good = greatest < kInfinity && shortest > bits(1e-18f);
  for (std::size_t i = first; i < std::min(last, rays.t_max.size()); ++i) good &= !std::isnan(rays.t_max[i]);
  if (good) return;
  for (std::size_t i = first; i < last; ++i) {
    const glowworm::Vec3 direction = inner(rays.direction[i]);
    if (!is_finite(inner(rays.origin[i])) || !is_finite(direction) || std::isnan(t_max_of(rays, i)))
      throw Error("ray " + std::to_string(i) + " is not finite");
    if (!(dot(direction, direction) > 0)) throw Error("the direction of ray " + std::to_string(i) + " has no length");
  }
}

/// The arrays of rays [first, last) as the tracer has them, until the next call by this thread.
RayArrays block_of(const Rays& rays, std::size_t first, std::size_t last, const glowworm::Scene& scene) {
  const auto inner_of = [&](std::span<const Vec3> all) {
    const auto part = all.subspan(first, last - first);
    return std::span(reinterpret_cast<const glowworm::Vec3*>(part.data()), part.size());
  };
  const auto t_max = rays.t_max.size() > 1 ? rays.t_max.subspan(first, last - first) : rays.t_max;
  std::span<const glowworm::Vec3> origin = inner_of(rays.origin);
  static thread_local std::vector<glowworm::Vec3> moved;
  if (!(scene.origin() == glowworm::Vec3{0, 0, 0})) {
    moved.assign(origin.begin(), origin.end());
    for (glowworm::Vec3& p : moved) p = scene.inside(p);
    origin = moved;
  }
  return {origin, inner_of(rays.direction), rays.t_min, t_max};
}

}  // namespace

void Tracer::intersect(const Rays& rays, const HitSpans& hits) const {
  check(rays);
  const std::size_t count = rays.origin.size();
  check_lengths(hits.distance.size(), count, "distances", "origins");
  check_lengths(hits.triangle.size(), count, "triangles", "origins");
  check_lengths(hits.barycentric.size(), count, "barycentric coordinates", "origins");
  const glowworm::Tracer& tracer = *scene_.implementation().tracer;
  auto* const barycentric = reinterpret_cast<glowworm::Vec2*>(hits.barycentric.data());
  parallel_for(0, count, kBlock, [&](std::size_t first, std::size_t last) {
    check_numbers(rays, first, last);
    const std::size_t n = last - first;
    tracer.intersect(block_of(rays, first, last, tracer.scene()),
                     {hits.distance.subspan(first, n), hits.triangle.subspan(first, n), {barycentric + first, n}});
  });
}

Hits Tracer::intersect(const Rays& rays) const {
  const std::size_t count = rays.origin.size();
  Hits out{std::vector<float>(count), std::vector<std::uint32_t>(count), std::vector<Vec2>(count), {}};
  intersect(rays, {out.distance, out.triangle, out.barycentric});
  out.normal = normals(out.triangle);
  return out;
}

std::vector<Vec3> Tracer::normals(std::span<const std::uint32_t> triangles) const {
  const glowworm::Scene& scene = *scene_.implementation().scene;
  std::vector<Vec3> out(triangles.size());
  parallel_for(0, out.size(), kBlock, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (triangles[i] == kNoTriangle) continue;
      if (triangles[i] >= scene.geometry().triangle_count())
        throw Error("the scene has no triangle " + std::to_string(triangles[i]));
      const glowworm::Vec3 n = scene.diffuse_triangle(triangles[i]).normal;
      out[i] = {n.x, n.y, n.z};
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
    check_numbers(rays, first, last);
    batch.clear();
    for (std::size_t i = first; i < last; ++i)
      batch.push_back(
          {tracer.scene().inside(inner(rays.origin[i])), rays.t_min, inner(rays.direction[i]), t_max_of(rays, i)});
    tracer.occluded(batch, std::span(out).subspan(first, last - first));
  });
  return out;
}

}  // namespace glowworm::api
