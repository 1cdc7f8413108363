#include "photon/diffuse_hits.h"

#include <algorithm>

#include "scene/surface.h"

namespace glowworm {

DiffuseMaterials::DiffuseMaterials(const Scene& scene) : scene_(&scene) {
  const Geometry& g = scene.geometry();
  entries_.reserve(scene.materials().size() + 1);
  for (const Material& m : scene.materials()) {
    const bool served = m.kind == MaterialKind::diffuse && m.transmittance.texture == kNone &&
                        !(max_component(m.transmittance.value) > 0) && m.normal_map.texture == kNone &&
                        m.bump.texture == kNone;
    Entry entry;
    entry.left_over = !served;
    entry.textured = served && m.reflectance.texture != kNone;
    if (served && !entry.textured) entry.reflectance = clamp(m.reflectance.value, 0, 1);
    entries_.push_back(entry);
  }
  entries_.emplace_back();
  smooth_ = std::any_of(g.normals.begin(), g.normals.end(), [](Vec3 n) { return !(n == Vec3{0, 0, 0}); });
  // What fits the second cache besides the rest.
  large_ = g.triangle_count() > 2048;
}

RGB DiffuseMaterials::reflectance(std::uint32_t triangle, Vec2 barycentric) const {
  const Geometry& g = scene_->geometry();
  const auto& [a, b, c] = g.triangles[triangle];
  const float u = barycentric.x, v = barycentric.y;
  const Vec2 uv = g.uvs[a] * (1 - u - v) + g.uvs[b] * u + g.uvs[c] * v;
  return clamp(evaluate(scene_->textures(), scene_->materials()[g.material[triangle]].reflectance, uv), 0, 1);
}

void DiffuseHits::place(const DiffuseMaterials& materials, std::span<const Hit> hits, std::size_t first,
                        std::size_t count) {
  const Geometry& g = materials.scene().geometry();
  const auto* const triangles = g.triangles.data();
  const Vec3* const positions = g.positions.data();
  const std::uint32_t* const material = g.material.data();
  const DiffuseMaterials::Entry* const entries = materials.entries().data();
  const std::size_t black = materials.entries().size() - 1;
  const bool fetched = materials.large();
  for (std::size_t i = 0; i < count; ++i) {
    if (fetched)
      fetch_ahead(materials.scene(), first + i, hits.size(), [&](std::size_t at) { return hits[at].triangle; });
    // Paths that hit nothing go through as if they had hit a black triangle: a branch would often be foretold wrongly.
    const Hit& hit = hits[first + i];
    const bool missed = hit.triangle == kNone;
    const std::uint32_t triangle = missed ? 0 : hit.triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3 position = positions[triangles[triangle][corner]];
      vertices_[3 * corner][i] = position.x;
      vertices_[3 * corner + 1][i] = position.y;
      vertices_[3 * corner + 2][i] = position.z;
    }
    const std::size_t of_material = material[triangle];
    const DiffuseMaterials::Entry& entry = entries[missed ? black : of_material];
    RGB reflectance = entry.reflectance;
    if (entry.textured) reflectance = materials.reflectance(triangle, hit.barycentric);
    reflectance_[0][i] = reflectance.r;
    reflectance_[1][i] = reflectance.g;
    reflectance_[2][i] = reflectance.b;
    barycentric_[0][i] = hit.barycentric.x;
    barycentric_[1][i] = hit.barycentric.y;
    other_[i] = entry.left_over;
    missed_[i] = -static_cast<std::uint32_t>(missed);
  }
}

void DiffuseHits::place_normals(const Geometry& geometry, const Hit* hits, std::size_t count) {
  const auto* const triangles = geometry.triangles.data();
  const Vec3* const normals = geometry.normals.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t triangle = hits[i].triangle == kNone ? 0 : hits[i].triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3 normal = normals[triangles[triangle][corner]];
      vertex_normals_[3 * corner][i] = normal.x;
      vertex_normals_[3 * corner + 1][i] = normal.y;
      vertex_normals_[3 * corner + 2][i] = normal.z;
    }
  }
}

void DiffuseHits::scatter(const DiffuseMaterials& materials, std::span<const Ray> rays, std::span<const Hit> hits,
                          std::size_t first, std::size_t count, const ArrivedPaths& paths) {
  place(materials, hits, first, count);
  // Else they are all zero, as they were made.
  if (materials.smooth()) place_normals(materials.scene().geometry(), hits.data() + first, count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 direction = rays[first + i].direction;
    back_[0][i] = -direction.x;
    back_[1][i] = -direction.y;
    back_[2][i] = -direction.z;
  }
  ArrivedPaths arrived;
  arrived.count = count;
  arrived.roulette = paths.roulette + first;
  for (std::size_t k = 0; k < 9; ++k) {
    arrived.vertices[k] = vertices_[k];
    arrived.vertex_normals[k] = vertex_normals_[k];
  }
  for (std::size_t k = 0; k < 2; ++k) {
    arrived.barycentric[k] = barycentric_[k];
    arrived.square[k] = paths.square[k] + first;
  }
  ScatteredPaths scattered;
  scattered.outcome = outcome_;
  for (std::size_t k = 0; k < 3; ++k) {
    arrived.reflectance[k] = reflectance_[k];
    arrived.back[k] = back_[k];
    arrived.flux[k] = paths.flux[k] + first;
    scattered.position[k] = position_[k];
    scattered.normal[k] = normal_[k];
    scattered.photon_flux[k] = photon_flux_[k];
    scattered.origin[k] = origin_[k];
    scattered.direction[k] = direction_[k];
    scattered.flux[k] = flux_[k];
  }
  diffuse_scatter(arrived, scattered);
}

void DiffuseHits::put_photon(std::size_t i, Vec3 position, Vec3 normal, RGB flux) {
  for (int k = 0; k < 3; ++k) {
    position_[k][i] = position[k];
    normal_[k][i] = normal[k];
    photon_flux_[k][i] = flux[k];
  }
}

void DiffuseHits::put_path(std::size_t i, Vec3 origin, Vec3 direction, RGB flux) {
  for (int k = 0; k < 3; ++k) {
    origin_[k][i] = origin[k];
    direction_[k][i] = direction[k];
    flux_[k][i] = flux[k];
  }
}

}  // namespace glowworm
