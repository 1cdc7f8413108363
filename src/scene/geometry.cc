#include "scene/geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/transform_double.h"
#include "scene/placed_box.h"
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

/// Normal of a mesh in the world.
Vec3 placed_normal(const Transform& to_world, Vec3 normal) {
  return normal == Vec3{0, 0, 0} ? normal : unit_or_zero(to_world.normal(normal));
}

/// The largest component of a vector, without signs.
float largest(Vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// How much a map and its inverse may enlarge a rounding error between them: the norm of the product of their matrices
/// without signs. It is 1 for scaling along axes, and at most 3 for a rotation.
double error_growth(const Transform& m) {
  const TransformDouble forth{Vec3d(m.x), Vec3d(m.y), Vec3d(m.z), {}}, back = inverse(forth);
  const auto absolute = [](Vec3d v) { return Vec3d{std::abs(v.x), std::abs(v.y), std::abs(v.z)}; };
  const TransformDouble a{absolute(forth.x), absolute(forth.y), absolute(forth.z), {}};
  const Vec3d sums = a.vector(absolute(back.x) + absolute(back.y) + absolute(back.z));
  return std::max({sums.x, sums.y, sums.z});
}

/// Instance::rounding. A unit of rounding of the distance from the mesh's origin enters when a corner is transformed
/// (4), when a ray is (6, with the rounding of the inverse), and when it is tested there (12, as in
/// core/offset_origin.h); the sum of three components of a unit vector is at most 2.
float rounding_of(const Transform& to_world, const Box3& mesh) {
  constexpr double kHalfUlp = 0x1p-24, kRoundings = (4 + 6 + 12) * 2;
  const Box3 box = placed_box({to_world.x, to_world.y, to_world.z, {0, 0, 0}}, mesh);
  const float extent = std::max(largest(box.min), largest(box.max));
  return static_cast<float>(kHalfUlp * kRoundings * error_growth(to_world) * extent);
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

bool is_placeable(const Transform& to_world) {
  // Rays then keep 20 of their 24 bits.
  constexpr double kMostGrowth = 16;
  for (const Vec3& v : {to_world.x, to_world.y, to_world.z, to_world.translation})
    if (!is_finite(v)) return false;
  // Not a number compares as false.
  return std::abs(to_world.determinant()) > 0 && error_growth(to_world) <= kMostGrowth;
}

std::size_t Geometry::end_of_instances() const {
  return std::size_t{instances.back().first} + meshes[instances.back().mesh]->triangles.size();
}

void Geometry::number_instances() {
  std::vector<Box3> boxes;
  for (const auto& mesh : meshes) boxes.push_back(mesh->bounds());
  std::size_t first = triangles.size();
  for (Instance& instance : instances) {
    instance.first = static_cast<std::uint32_t>(first);
    if (instance.mesh >= meshes.size()) continue;  // check_description() rejects it
    instance.rounding = rounding_of(instance.to_world, boxes[instance.mesh]);
    first += meshes[instance.mesh]->triangles.size();
    if (first >= kNone)
      throw Error("the scene has more triangles than 32 bits can count",
                  "Leave some instances or parts of their meshes out.");
  }
  objects.resize(objects.size() - std::exchange(numbered_objects, instance_objects.size()));
  for (const ObjectStart& object : instance_objects)
    objects.push_back({instances[object.first_triangle].first, object.name});
}

StoredTriangle Geometry::stored_by_instance(std::uint32_t triangle) const {
  const auto after = std::upper_bound(instances.begin(), instances.end(), triangle,
                                      [](std::uint32_t t, const Instance& i) { return t < i.first; });
  const Instance& instance = *(after - 1);
  return {meshes[instance.mesh].get(), triangle - instance.first, &instance};
}

std::uint32_t Geometry::material_by_instance(std::uint32_t triangle) const {
  const StoredTriangle at = stored_by_instance(triangle);
  return at.mesh->material[at.index];
}

std::array<Vec3, 3> Geometry::corners(const StoredTriangle& at) {
  const auto& [a, b, c] = at.mesh->triangles[at.index];
  const std::vector<Vec3>& p = at.mesh->positions;
  if (!at.instance) return {p[a], p[b], p[c]};
  const Transform& to_world = at.instance->to_world;
  return {to_world.point(p[a]), to_world.point(p[b]), to_world.point(p[c])};
}

std::array<Vec3, 3> Geometry::corner_normals(const StoredTriangle& at) {
  const auto& [a, b, c] = at.mesh->triangles[at.index];
  const std::vector<Vec3>& n = at.mesh->normals;
  if (!at.instance) return {n[a], n[b], n[c]};
  const Transform& to_world = at.instance->to_world;
  return {placed_normal(to_world, n[a]), placed_normal(to_world, n[b]), placed_normal(to_world, n[c])};
}

Geometry Geometry::expanded() const {
  Geometry out = *this;
  out.instances.clear();
  out.meshes.clear();
  out.instance_objects.clear();
  out.numbered_objects = 0;
  for (const Instance& instance : instances) {
    const Geometry& mesh = *meshes[instance.mesh];
    VertexAppender appender(out, mesh);
    const auto base = static_cast<std::uint32_t>(out.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      out.positions.push_back(instance.to_world.point(mesh.positions[v]));
      appender.append(v);
      out.normals.back() = placed_normal(instance.to_world, mesh.normals[v]);
    }
    for (const auto& [a, b, c] : mesh.triangles) out.triangles.push_back({base + a, base + b, base + c});
    out.material.insert(out.material.end(), mesh.material.begin(), mesh.material.end());
    out.emission.insert(out.emission.end(), mesh.triangles.size(), kNone);
  }
  return out;
}

std::uint32_t Geometry::object_of(std::uint32_t triangle) const {
  const auto after = std::upper_bound(objects.begin(), objects.end(), triangle,
                                      [](std::uint32_t t, const ObjectStart& o) { return t < o.first_triangle; });
  return after == objects.begin() ? kNone : static_cast<std::uint32_t>(after - objects.begin() - 1);
}

void Geometry::begin_object(const std::string& name) {
  const auto first = static_cast<std::uint32_t>(triangles.size());
  objects.resize(objects.size() - std::exchange(numbered_objects, 0));
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
