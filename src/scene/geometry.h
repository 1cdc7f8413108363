// The triangles of a scene: an indexed mesh in world space, and instances of other meshes.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/box.h"
#include "core/rgb.h"
#include "core/transform.h"
#include "core/vec.h"

namespace glowworm {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// The first triangle of an object, whose triangles follow one another, and its name in the file.
struct ObjectStart {
  std::uint32_t first_triangle = 0;
  std::string name;
};

/// A factor on a material's colour, linear, and on its alpha.
struct VertexColor {
  RGB color{1.0f};
  float alpha = 1;
};

struct Geometry;

/// One of the places of a mesh.
struct Instance {
  Transform to_world;       ///< from the mesh's space; is_placeable()
  std::uint32_t mesh = 0;   ///< index into Geometry::meshes
  std::uint32_t first = 0;  ///< number of its first triangle; the others follow in the order of the mesh
  /// How much farther than from its place alone (core/offset_origin.h) rays must start from a triangle: a bound of the
  /// rounding of corners and rays that are transformed, metres.
  float rounding = 0;
};

/// Whether rays can be transformed to a mesh's space and back without much loss: the map is finite, has an inverse, and
/// does not shear the mesh to a sliver.
bool is_placeable(const Transform& to_world);

/// Length of a scaled normal. The square of an area exceeds the range of float in scenes of micrometres and of billions
/// of metres.
inline float length_in_range(Vec3 n) {
  const double x = n.x, y = n.y, z = n.z;
  return static_cast<float>(std::sqrt(x * x + y * y + z * z));
}
/// The unit vector along a scaled normal; (0,0,0) if that is zero.
inline Vec3 unit_normal(Vec3 n) {
  const float l = length_in_range(n);
  return l > 0 ? n / l : Vec3{0, 0, 0};
}

/// Where the data of a triangle are.
struct StoredTriangle {
  const Geometry* mesh;
  std::uint32_t index;       ///< in the mesh
  const Instance* instance;  ///< that places the mesh; null: the mesh is in world space
};

/// The triangles of a scene, metres. A triangle's number is its index in the arrays, or for one of an instance
/// Instance::first plus the index in the arrays of its mesh.
struct Geometry {
  std::vector<Vec3> positions;                          ///< one per vertex
  std::vector<Vec3> normals;                            ///< one per vertex, unit; (0,0,0): use the triangle's own
  std::vector<Vec2> uvs;                                ///< one per vertex; (0,0) if the file has none
  std::vector<Vec2> second_uvs;                         ///< one per vertex, or empty: a second set of coordinates
  std::vector<VertexColor> colors;                      ///< one per vertex, or empty: all white
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< vertex indices, counter-clockwise seen from outside
  std::vector<std::uint32_t> material;                  ///< one per triangle: index into the materials
  std::vector<std::uint32_t> emission;                  ///< one per triangle: index into the emissions, or kNone
  std::vector<ObjectStart> objects;                     ///< in the order of triangles; may be empty
  std::vector<std::shared_ptr<const Geometry>> meshes;  ///< of instances: without emission, objects and instances
  std::vector<Instance> instances;                      ///< in the order of their triangles
  std::vector<ObjectStart> instance_objects;            ///< of instances, which they count in place of triangles
  std::size_t numbered_objects = 0;                     ///< how many of these are the last of `objects`

  /// Number of all triangles.
  std::size_t triangle_count() const { return instances.empty() ? triangles.size() : end_of_instances(); }
  /// Numbers the triangles of instances after the others, and adds their objects. Call it after triangles or instances
  /// are added; a Scene does so, too. Throws Error if 32 bits cannot count them.
  void number_instances();
  /// The same triangles without instances.
  Geometry expanded() const;

  StoredTriangle stored(std::uint32_t triangle) const {
    return triangle < triangles.size() ? StoredTriangle{this, triangle, nullptr} : stored_by_instance(triangle);
  }
  std::uint32_t material_of(std::uint32_t triangle) const {
    return triangle < triangles.size() ? material[triangle] : material_by_instance(triangle);
  }
  /// Index into the emissions, or kNone.
  std::uint32_t emission_of(std::uint32_t triangle) const {
    return triangle < triangles.size() ? emission[triangle] : kNone;
  }
  /// Positions of the vertices of a triangle, metres.
  std::array<Vec3, 3> corners(std::uint32_t triangle) const {
    if (triangle >= triangles.size()) return corners(stored_by_instance(triangle));
    const auto& [a, b, c] = triangles[triangle];
    return {positions[a], positions[b], positions[c]};
  }
  static std::array<Vec3, 3> corners(const StoredTriangle& stored);
  /// Their normals: unit, or (0,0,0) for the triangle's own.
  std::array<Vec3, 3> corner_normals(std::uint32_t triangle) const {
    if (triangle >= triangles.size()) return corner_normals(stored_by_instance(triangle));
    const auto& [a, b, c] = triangles[triangle];
    return {normals[a], normals[b], normals[c]};
  }
  static std::array<Vec3, 3> corner_normals(const StoredTriangle& stored);
  /// Calls use(position) for each vertex.
  template <typename Use>
  void for_each_position(Use&& use) const {
    for (const Vec3& p : positions) use(p);
    for (const Instance& instance : instances)
      for (const Vec3& p : meshes[instance.mesh]->positions) use(instance.to_world.point(p));
  }
  /// Calls use(corners) for each triangle, in order.
  template <typename Use>
  void for_each_triangle(Use&& use) const {
    for (std::uint32_t t = 0; t < triangles.size(); ++t) use(corners(t));
    for (const Instance& instance : instances) {
      const Geometry* mesh = meshes[instance.mesh].get();
      for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) use(corners({mesh, t, &instance}));
    }
  }
  /// Calls use(material, number of triangles) for runs of triangles of one material, in any order.
  template <typename Use>
  void for_each_material(Use&& use) const {
    for (const std::uint32_t m : material) use(m, std::size_t{1});
    std::vector<std::size_t> places(meshes.size());
    for (const Instance& instance : instances) ++places[instance.mesh];
    for (std::size_t i = 0; i < meshes.size(); ++i)
      if (places[i] > 0)
        for (const std::uint32_t m : meshes[i]->material) use(m, places[i]);
  }

  /// Index into `objects` of a triangle's object; kNone if it has none.
  std::uint32_t object_of(std::uint32_t triangle) const;
  /// Starts an object with the next triangle, or continues the current one if the name is the same.
  void begin_object(const std::string& name);
  /// Twice the area times the unit normal (m^2), by the winding.
  Vec3 scaled_normal(std::uint32_t triangle) const {
    const auto [a, b, c] = corners(triangle);
    return cross(b - a, c - a);
  }
  /// Twice the area in m^2; infinite or 0 only if float cannot represent it.
  float doubled_area(std::uint32_t triangle) const { return length_in_range(scaled_normal(triangle)); }
  /// Area in m^2.
  float area(std::uint32_t triangle) const { return 0.5f * doubled_area(triangle); }
  /// Unit normal by the winding; (0,0,0) for a triangle without area.
  Vec3 normal(std::uint32_t triangle) const { return unit_normal(scaled_normal(triangle)); }
  Box3 bounds() const {
    Box3 box;
    for_each_position([&](const Vec3& p) { box.grow(p); });
    return box;
  }

 private:
  std::size_t end_of_instances() const;
  StoredTriangle stored_by_instance(std::uint32_t triangle) const;
  std::uint32_t material_by_instance(std::uint32_t triangle) const;
};

/// Adds a mesh to a scene's geometry. Drops triangles without area and those with a vertex that is not finite, and
/// counts them; throws Error naming `name` if an index is out of range.
/// @param mesh triangles of one shape; if its material and emission arrays are empty, the last two arguments apply to
/// all its triangles
struct AppendResult {
  std::size_t degenerate = 0;  ///< triangles dropped for having no area
  std::size_t not_finite = 0;  ///< triangles dropped for a NaN or infinite vertex
};
AppendResult append_mesh(Geometry& geometry, const Geometry& mesh, const char* name, std::uint32_t material,
                         std::uint32_t emission);

}  // namespace glowworm
