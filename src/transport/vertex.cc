#include "transport/vertex.h"

#include <cmath>

namespace glowworm {

float broad_probability(const Vertex& vertex) {
  if (!vertex.has(kBroad)) return 0;
  if (!vertex.has(kSpecular)) return 1;
  const ShadedSurface surface = vertex.surface();
  const float broad = luminance(surface.albedo(vertex.wo, kBroad)),
              sharp = luminance(surface.albedo(vertex.wo, kSpecular));
  return broad + sharp > 0 ? broad / (broad + sharp) : 1;
}

SmoothLobes smooth_lobes(const Vertex& vertex) {
  constexpr float kRounding = 1e-5f;
  const ShadedSurface surface = vertex.surface();
  const ScatteredRay first = surface.sample(vertex.wo, 0, {0.5f, 0.5f}, kSpecular),
                     last = surface.sample(vertex.wo, kBelowOne, {0.5f, 0.5f}, kSpecular);
  if (!first.valid || !first.delta) return {};
  if (std::abs(first.pdf - 1) < kRounding) return {{first, {}}, 1};
  if (!last.valid || !last.delta || std::abs(first.pdf + last.pdf - 1) >= kRounding) return {};
  return {{first, last}, 2};
}

void add_query(QueryPoints& queries, const Vertex& vertex, RGB weight, std::uint32_t target, Lobes lobes) {
  const Bsdf& bsdf = vertex.bsdf;
  const Vec3 position = vertex.point.position, normal = vertex.normal();
  if (bsdf.kind != BsdfKind::lambertian) {
    const Frame& frame = vertex.point.frame;
    const QueryBsdf query{bsdf, frame.s, frame.t, frame.n, vertex.surface().seen_from(vertex.wo), lobes};
    queries.push_back(position, normal, query, weight, target);
    if ((bsdf.kind == BsdfKind::metallic_roughness && bsdf.diffuse_transmission > 0) || bsdf.kind == BsdfKind::measured)
      queries.push_back(position, -normal, query, weight, target);
    return;
  }
  if (!is_black(bsdf.diffuse)) queries.push_back(position, normal, bsdf.diffuse, weight, target);
  if (!is_black(bsdf.transmission)) queries.push_back(position, -normal, bsdf.transmission, weight, target);
}

void add_gather_point(GatherPoints& points, const Vertex& vertex, RGB throughput, std::uint32_t slot,
                      std::uint32_t sequence, std::uint32_t sample, bool in_media) {
  points.add(slot, sequence, sample, vertex.point.position, vertex.normal(), vertex.point.offset, vertex.point.frame,
             vertex.wo, vertex.bsdf, throughput);
  if (in_media) points.media.push_back(vertex.media);
}

Vertex vertex_of(const GatherPoints& points, std::size_t i) {
  Vertex out;
  out.point.position = points.position[i];
  out.point.geometric_normal = points.normal[i];
  out.point.offset = points.offset[i];
  out.point.frame = points.frame[i];
  out.wo = points.wo[i];
  out.bsdf = points.bsdf[i];
  if (!points.media.empty()) out.media = points.media[i];
  return out;
}

QueryPoints gather_points_as_queries(const GatherPoints& points) {
  QueryPoints queries;
  queries.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    add_query(queries, vertex_of(points, i), points.throughput[i], points.slot[i]);
  return queries;
}

}  // namespace glowworm
