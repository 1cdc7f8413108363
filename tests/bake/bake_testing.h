// Meshes and charts for tests of baking.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "bake/atlas.h"
#include "bake/chart.h"
#include "bake/texels.h"
#include "builtin/mesh_builder.h"
#include "scene/scene_parts.h"

namespace glowworm {

/// The fronts of all triangles.
inline std::vector<BakeFace> fronts(const Geometry& geometry) {
  std::vector<BakeFace> faces;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) faces.push_back({t, false});
  return faces;
}

/// A mesh with its charts, atlases and texels.
struct FlatMesh {
  Geometry geometry;
  std::vector<BakeFace> faces;
  std::vector<Chart> charts;
  Atlas atlas;
  TexelMap texels;

  explicit FlatMesh(Geometry mesh, AtlasRequest request = {256, 0})
      : geometry(std::move(mesh)), faces(fronts(geometry)), charts(make_charts(geometry, faces)) {
    atlas = pack(charts, request);
    texels = map_texels(charts, atlas);
  }

  Vec3 point(std::size_t texel) const {
    const auto& [a, b, c] = geometry.triangles[faces[texels.face[texel]].triangle];
    const Vec2 w = texels.barycentric[texel];
    return geometry.positions[a] * (1 - w.x - w.y) + geometry.positions[b] * w.x + geometry.positions[c] * w.y;
  }
};

inline Geometry sphere_mesh(int segments = 24, int rings = 12) {
  Geometry geometry;
  MeshBuilder(geometry).sphere({0, 0, 0}, 1, segments, rings);
  return geometry;
}

inline Geometry box_mesh() {
  Geometry geometry;
  MeshBuilder(geometry).box({0, 0, 0}, {3, 2, 1});
  return geometry;
}

/// A screw of two turns: faces of like direction lie above one another.
inline Geometry ramp_mesh() {
  Geometry geometry;
  constexpr int kSteps = 64;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    const float angle = 4 * kPi * static_cast<float>(i) / kSteps, y = 0.05f * static_cast<float>(i);
    for (const float radius : {1.0f, 2.0f})
      geometry.positions.push_back({radius * std::cos(angle), y, radius * std::sin(angle)});
    if (i == 0) continue;
    geometry.triangles.push_back({2 * i - 2, 2 * i, 2 * i - 1});
    geometry.triangles.push_back({2 * i - 1, 2 * i, 2 * i + 1});
  }
  geometry.normals.resize(geometry.positions.size());
  geometry.uvs.resize(geometry.positions.size());
  geometry.material.assign(geometry.triangles.size(), 0);
  geometry.emission.assign(geometry.triangles.size(), kNone);
  return geometry;
}

/// Two rooms of 2 x 2 x 2 m that share a floor and a ceiling, with a wall of 0.2 m between them; a lamp in one.
inline SceneDescription two_rooms() {
  SceneDescription d;
  d.name = "two rooms";
  d.materials.resize(1);
  MeshBuilder builder(d.geometry);
  builder.set_material(0);
  builder.room({0, 0, 0}, {4.2f, 2, 2});
  builder.box({2, 0, 0}, {2.2f, 2, 2});
  add_quad(d, {0.5f, 1.9f, 0.5f}, {1, 0, 0}, {0, 0, 1}, 0, add_emission(d, RGB(5.0f)));
  return d;
}

/// A room with a panel that glows: material 1, at x = 1.
inline SceneDescription room_with_panel(RGB emission, bool textured) {
  SceneDescription d = two_rooms();
  d.materials.resize(2);
  d.materials[1].reflectance.value = {0.5f, 0.25f, 0};
  const std::uint32_t glow = add_emission(d, emission);
  if (textured) {
    d.emissions[glow].radiance.texture = static_cast<std::uint32_t>(d.textures.size());
    d.textures.emplace_back();
  }
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0}, 1, glow);
  return d;
}

}  // namespace glowworm
