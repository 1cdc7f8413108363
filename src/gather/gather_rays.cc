#include "gather/gather_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

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

/// Cell of a unit vector in a grid of 2^bits x 2^bits over the octahedron (Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", JCGT 3(2), 2014).
std::uint32_t octahedral_cell(Vec3 d, int bits) {
  const float scale = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * scale, y = d.y * scale;
  if (d.z < 0) {
    const float folded = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = folded;
  }
  const int side = 1 << bits;
  const auto along = [&](float v) {
    return static_cast<std::uint32_t>(
        std::clamp(static_cast<int>((v + 1) * 0.5f * static_cast<float>(side)), 0, side - 1));
  };
  return along(y) << bits | along(x);
}

}  // namespace

void GatherRays::reserve(std::size_t n) {
  rays.reserve(n);
  hits.reserve(n);
  weight.reserve(n);
  pdf.reserve(n);
  point.reserve(n);
  stratum.reserve(n);
  segment.reserve(n);
  bounces.reserve(n);
}

void GatherRays::clear() { shrink(0); }

void GatherRays::move(std::size_t from, std::size_t to) {
  if (from == to) return;
  rays[to] = rays[from];
  weight[to] = weight[from];
  pdf[to] = pdf[from];
  point[to] = point[from];
  stratum[to] = stratum[from];
  segment[to] = segment[from];
  bounces[to] = bounces[from];
}

void GatherRays::shrink(std::size_t n) {
  rays.resize(n);
  weight.resize(n);
  pdf.resize(n);
  point.resize(n);
  stratum.resize(n);
  segment.resize(n);
  bounces.resize(n);
}

void GatherRays::push_back(const Ray& ray, RGB w, float density, std::uint32_t gather_point, std::uint32_t cell) {
  rays.push_back(ray);
  weight.push_back(w);
  pdf.push_back(density);
  point.push_back(gather_point);
  stratum.push_back(cell);
  segment.push_back(Segment::first);
  bounces.push_back(0);
}

void coherent_order(const GatherPoints& points, std::size_t first, std::size_t last,
                    std::vector<std::uint32_t>& order) {
  constexpr int kNormalBits = 3, kTangentBits = 2;
  std::vector<std::uint64_t> keys;
  keys.reserve(last - first);
  for (std::size_t i = first; i < last; ++i) {
    const Frame& frame = points.frame[i];
    // A stratum is a cell of directions about the side of the surface that the viewer is on.
    const bool below = dot(points.wo[i], frame.n) < 0;
    const std::uint64_t cell = octahedral_cell(below ? -frame.n : frame.n, kNormalBits) << (2 * kTangentBits) |
                               octahedral_cell(frame.s, kTangentBits);
    keys.push_back(cell << 32 | i);
  }
  std::sort(keys.begin(), keys.end());
  order.clear();
  for (const std::uint64_t key : keys) order.push_back(static_cast<std::uint32_t>(key));
}

void create_gather_rays(const GatherPoints& points, std::span<const std::uint32_t> order, std::uint32_t rays_each,
                        std::uint32_t seed, GatherRays& out) {
  const Strata strata(rays_each);
  const float share = 1.0f / static_cast<float>(rays_each);
  out.reserve(out.size() + order.size() * rays_each);
  for (std::uint32_t cell = 0; cell < rays_each; ++cell)
    for (const std::uint32_t i : order) {
      Vec2 u;
      if (strata.usable()) {
        Sampler sampler(SamplerKind::sobol, seed, hash_combine(points.sequence[i], cell), points.sample[i]);
        u = sampler.next2();
        u.x = (static_cast<float>(cell % strata.columns) + u.x) / static_cast<float>(strata.columns);
        u.y = (static_cast<float>(cell / strata.columns) + u.y) / static_cast<float>(strata.rows);
      } else {
        Sampler sampler(SamplerKind::sobol, seed, hash_combine(points.sequence[i], 0x67617468u),
                        points.sample[i] * rays_each + cell);
        u = sampler.next2();
      }
      const Bsdf& bsdf = points.bsdf[i];
      const float u_lobe = is_lambertian(bsdf) ? 0 : gather_ray_number(points, i, cell, seed, 0x6c6f6265u);
      const Vec3 wo = points.frame[i].to_local(points.wo[i]);
      const BsdfSample s = sample(bsdf, wo, u_lobe, u, kBroad, Transport::radiance);
      if (!s.valid || is_black(s.weight)) continue;
      Ray ray;
      if (!leave_surface(points.position[i], points.normal[i], points.frame[i].to_world(s.wi), s.wi.z * wo.z > 0, ray))
        continue;
      out.push_back(ray, points.throughput[i] * s.weight * share, s.pdf, i, cell);
    }
}

float gather_ray_number(const GatherPoints& points, std::size_t point, std::uint32_t stratum, std::uint32_t seed,
                        std::uint32_t what) {
  const std::uint32_t key = hash_combine(hash_combine(seed ^ what, points.sequence[point]), stratum);
  return to_unit_float(hash_combine(key, points.sample[point]));
}

bool leave_surface(Vec3 position, Vec3 normal, Vec3 direction, bool reflected, Ray& ray) {
  const float side = dot(direction, normal);
  if ((side > 0) != reflected || side == 0) return false;
  ray = {offset_origin(position, side > 0 ? normal : -normal), 0, direction, std::numeric_limits<float>::infinity()};
  return true;
}

}  // namespace glowworm
