#include "import/mesh_tools.h"

#include <algorithm>
#include <bit>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scene/material.h"

namespace glowworm {

void reverse_winding(Geometry& mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

namespace {

FloatBits<8> vertex_bits(const Geometry& mesh, std::size_t i) {
  const float values[8] = {mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z, mesh.normals[i].x,
                           mesh.normals[i].y,   mesh.normals[i].z,   mesh.uvs[i].x,       mesh.uvs[i].y};
  return std::bit_cast<FloatBits<8>>(values);
}

}  // namespace

std::uint64_t material_bytes() { return 2 * sizeof(Material); }

std::uint64_t mesh_bytes(const Geometry& mesh) {
  const auto bytes = [](const auto& array) { return std::uint64_t{array.size()} * sizeof array[0]; };
  return bytes(mesh.positions) + bytes(mesh.normals) + bytes(mesh.uvs) + bytes(mesh.second_uvs) + bytes(mesh.colors) +
         bytes(mesh.triangles) + bytes(mesh.material) + bytes(mesh.emission) + bytes(mesh.instances);
}

std::uint64_t scene_bytes(const Geometry& mesh) { return scene_bytes(mesh.triangles.size(), mesh.positions.size()); }

std::uint64_t scene_bytes(std::uint64_t triangles, std::uint64_t vertices) {
  constexpr std::uint64_t kBytesPerTriangle = 200, kBytesPerVertex = 72;
  return triangles * kBytesPerTriangle + std::min(vertices, 3 * triangles) * kBytesPerVertex;
}

namespace {

/// Transforms normals, and reverses the winding if the transform mirrors.
void turn_mesh(Geometry& mesh, const Transform& to_world) {
  for (Vec3& n : mesh.normals) {
    const Vec3 mapped = to_world.normal(n);
    const float l = length(mapped);
    n = l > 0 && std::isfinite(l) ? mapped / l : Vec3{0, 0, 0};
  }
  if (to_world.determinant() < 0) reverse_winding(mesh);
}

}  // namespace

void transform_mesh(Geometry& mesh, const Transform& to_world) {
  for (Vec3& p : mesh.positions) p = to_world.point(p);
  for (Instance& instance : mesh.instances) instance.to_world = to_world * instance.to_world;
  if (!mesh.instances.empty()) mesh.number_instances();
  turn_mesh(mesh, to_world);
}

void place_mesh(Geometry& mesh, const TransformDouble& to_world, CoordinateOrigin& origin) {
  const Box3 box = mesh.bounds();
  if (!(origin_for(Vec3d(box.min), Vec3d(box.max)) == Vec3{0, 0, 0})) origin.set_rounded();
  for (Vec3& p : mesh.positions) p = origin.take(to_world.point(Vec3d(p)));
  turn_mesh(mesh, to_world.relative_to(origin.origin()));
}

void merge_identical_vertices(Geometry& mesh) {
  std::unordered_map<FloatBits<8>, std::uint32_t, FloatBitsHash> seen;
  seen.reserve(mesh.positions.size() / 2);
  std::vector<std::uint32_t> target(mesh.positions.size());
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto [place, fresh] = seen.try_emplace(vertex_bits(mesh, i), kept);
    if (fresh) {
      mesh.positions[kept] = mesh.positions[i];
      mesh.normals[kept] = mesh.normals[i];
      mesh.uvs[kept] = mesh.uvs[i];
      ++kept;
    }
    target[i] = place->second;
  }
  mesh.positions.resize(kept);
  mesh.normals.resize(kept);
  mesh.uvs.resize(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = target[vertex];
  }
}

std::size_t wind_by_normals(Geometry& mesh) {
  std::size_t turned = 0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    auto& triangle = mesh.triangles[i];
    const Vec3 face = mesh.scaled_normal(i);
    bool against = true;
    for (const std::uint32_t vertex : triangle) against = against && dot(face, mesh.normals[vertex]) < 0;
    if (against) {
      std::swap(triangle[1], triangle[2]);
      ++turned;
    }
  }
  return turned;
}

void append_counted(Geometry& geometry, const Geometry& mesh, const std::string& name, std::uint32_t material,
                    std::uint32_t emission, NoteCounter& notes) {
  const AppendResult dropped = append_mesh(geometry, mesh, name.c_str(), material, emission);
  notes.add("triangle without area, left out", dropped.degenerate);
  notes.add("triangle with a vertex that is not finite, left out", dropped.not_finite);
}

}  // namespace glowworm
