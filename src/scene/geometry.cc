#include "scene/geometry.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/scene_checks.h"

namespace glowworm {

namespace {

void check_array(std::size_t size, std::size_t wanted, const char* name, const char* what) {
  if (size != 0 && size != wanted)
    throw Error(std::string(name) + ": the mesh has " + std::to_string(size) + " " + what + " where " +
                    std::to_string(wanted) + " or none were expected",
                "Export the mesh again, or leave these values out.");
}

void check_mesh(const Geometry& mesh, const char* name) {
  check_array(mesh.normals.size(), mesh.positions.size(), name, "normals");
  check_array(mesh.uvs.size(), mesh.positions.size(), name, "texture coordinates");
  check_array(mesh.second_uvs.size(), mesh.positions.size(), name, "second texture coordinates");
  check_array(mesh.colors.size(), mesh.positions.size(), name, "vertex colours");
  check_array(mesh.material.size(), mesh.triangles.size(), name, "material indices");
  check_array(mesh.emission.size(), mesh.triangles.size(), name, "emission indices");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t vertex : mesh.triangles[t])
      if (vertex >= mesh.positions.size())
        throw Error(std::string(name) + ": triangle " + std::to_string(t) + " refers to vertex " +
                        std::to_string(vertex) + ", but there are only " + std::to_string(mesh.positions.size()),
                    "The file is damaged or was cut short; export the mesh again.");
}

Vec3 unit_or_zero(Vec3 n) {
  const float l = length(n);
  return l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
}

Vec2 finite_or_zero(Vec2 uv) { return std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : Vec2{0, 0}; }

/// Adds vertices of a mesh to all arrays of a scene's geometry except the positions.
class VertexAppender {
 public:
  VertexAppender(Geometry& geometry, const Geometry& mesh)
      : geometry_(geometry),
        mesh_(mesh),
        second_uvs_(!geometry.second_uvs.empty() || !mesh.second_uvs.empty()),
        colors_(!geometry.colors.empty() || !mesh.colors.empty()) {
    // Existing vertices lack the attributes that only this mesh has.
    if (second_uvs_) geometry.second_uvs.resize(geometry.positions.size());
    if (colors_) geometry.colors.resize(geometry.positions.size());
  }
  void append(std::uint32_t vertex) {
    geometry_.normals.push_back(mesh_.normals.empty() ? Vec3{0, 0, 0} : unit_or_zero(mesh_.normals[vertex]));
    geometry_.uvs.push_back(mesh_.uvs.empty() ? Vec2{0, 0} : finite_or_zero(mesh_.uvs[vertex]));
    if (second_uvs_)
      geometry_.second_uvs.push_back(mesh_.second_uvs.empty() ? Vec2{0, 0} : finite_or_zero(mesh_.second_uvs[vertex]));
    if (colors_) geometry_.colors.push_back(mesh_.colors.empty() ? VertexColor{} : mesh_.colors[vertex]);
  }

 private:
  Geometry& geometry_;
  const Geometry& mesh_;
  bool second_uvs_, colors_;
};

}  // namespace

std::uint32_t Geometry::object_of(std::uint32_t triangle) const {
  const auto after = std::upper_bound(objects.begin(), objects.end(), triangle,
                                      [](std::uint32_t t, const ObjectStart& o) { return t < o.first_triangle; });
  return after == objects.begin() ? kNone : static_cast<std::uint32_t>(after - objects.begin() - 1);
}

void Geometry::begin_object(const std::string& name) {
  const auto first = static_cast<std::uint32_t>(triangles.size());
  if (!objects.empty() && objects.back().name == name) return;
  // Removes an object without triangles.
  if (!objects.empty() && objects.back().first_triangle == first) objects.pop_back();
  objects.push_back({first, name});
}

AppendResult append_mesh(Geometry& geometry, const Geometry& mesh, const char* name, std::uint32_t material,
                         std::uint32_t emission) {
  check_mesh(mesh, name);
  AppendResult result;
  VertexAppender appender(geometry, mesh);
  // Only vertices of kept triangles are copied, so that a stray NaN never reaches the bounds of the scene.
  std::vector<std::uint32_t> moved(mesh.positions.size(), kNone);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const float doubled_area = mesh.doubled_area(static_cast<std::uint32_t>(t));
    bool finite = true;
    for (const std::uint32_t vertex : corners) finite = finite && is_finite(mesh.positions[vertex]);
    for (const std::uint32_t vertex : corners)
      if (finite && !is_within_bounds(mesh.positions[vertex]))
        check_within_bounds(mesh.positions[vertex], std::string(name) + ": vertex " + std::to_string(vertex));
    // An area beyond the range of float has no normal either.
    if (!finite || !std::isfinite(doubled_area)) {
      ++result.not_finite;
      continue;
    }
    if (doubled_area == 0) {
      ++result.degenerate;
      continue;
    }
    std::array<std::uint32_t, 3> kept{};
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = corners[corner];
      if (moved[vertex] == kNone) {
        if (geometry.positions.size() >= kNone)
          throw Error(std::string(name) + ": the scene has more vertices than 32 bits can count",
                      "Simplify its meshes, or leave some of them out.");
        moved[vertex] = static_cast<std::uint32_t>(geometry.positions.size());
        geometry.positions.push_back(mesh.positions[vertex]);
        appender.append(vertex);
      }
      kept[corner] = moved[vertex];
    }
    geometry.triangles.push_back(kept);
    geometry.material.push_back(mesh.material.empty() ? material : mesh.material[t]);
    geometry.emission.push_back(mesh.emission.empty() ? emission : mesh.emission[t]);
  }
  return result;
}

}  // namespace glowworm
