#include "scene/diffuse_triangles.h"

#include "core/offset_origin.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// The upper half of the bits of a positive number, rounded up to the next number without lower bits.
std::uint16_t upper_half(float x) {
  return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(x) + 0xffffu) >> 16);
}

std::uint16_t kind_of(const Material& m) {
  const bool transmits = m.transmittance.texture != kNone || max_component(m.transmittance.value) > 0;
  if (m.kind != MaterialKind::diffuse || transmits) return 0;
  std::uint16_t kind = DiffuseTriangle::kDiffuse;
  if (m.reflectance.texture != kNone) kind |= DiffuseTriangle::kTextured;
  if (m.normal_map.texture != kNone || m.bump.texture != kNone) kind |= DiffuseTriangle::kMapped;
  return kind;
}

}  // namespace

DiffuseTriangle make_diffuse_triangle(const Geometry& geometry, const std::vector<Material>& materials,
                                      std::uint32_t triangle) {
  const StoredTriangle stored = geometry.stored(triangle);
  const Geometry& g = *stored.mesh;
  DiffuseTriangle out;
  const auto [a, b, c] = Geometry::corners(stored);
  out.corner = a;
  out.edge[0] = b - a;
  out.edge[1] = c - a;
  const Vec3 normal = unit_normal(cross(out.edge[0], out.edge[1]));
  const bool has_area = !(normal == Vec3{0, 0, 0});
  out.normal = has_area ? normal : Vec3{0, 0, 1};
  if (has_area) {
    const double offset = rounding_offset(out.corner, out.edge[0], out.edge[1]);
    out.offset_bits = upper_half(static_cast<float>(stored.instance ? offset + stored.instance->rounding : offset));
  }
  const Material& m = materials[g.material[stored.index]];
  out.kind = kind_of(m);
  if (out.kind == 0) return out;
  if (!(out.kind & DiffuseTriangle::kTextured)) out.reflectance = clamp(m.reflectance.value, 0, 1);
  for (const std::uint32_t vertex : g.triangles[stored.index])
    if (!(g.normals[vertex] == Vec3{0, 0, 0})) out.kind |= DiffuseTriangle::kSmooth;
  if (geometry.emission_of(triangle) != kNone) out.kind |= DiffuseTriangle::kEmits;
  return out;
}

LargeVector<DiffuseTriangle> diffuse_triangles(const Geometry& geometry, const std::vector<Material>& materials) {
  LargeVector<DiffuseTriangle> out(geometry.triangles.size());
  parallel_for_each(out.size(), 4096, [&](std::size_t i) {
    out[i] = make_diffuse_triangle(geometry, materials, static_cast<std::uint32_t>(i));
  });
  return out;
}

}  // namespace glowworm
