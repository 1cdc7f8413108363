// The triangles of a scene: one indexed mesh in world space, in structure-of-arrays form.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/box.h"
#include "core/rgb.h"
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

/// All triangles of a scene. The importers expand instances: everything is in world space, metres.
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

  std::size_t triangle_count() const { return triangles.size(); }
  /// Index into `objects` of a triangle's object; kNone if it has none.
  std::uint32_t object_of(std::uint32_t triangle) const;
  /// Starts an object with the next triangle, or continues the current one if the name is the same.
  void begin_object(const std::string& name);
  /// Twice the area times the unit normal (m^2), by the winding.
  Vec3 scaled_normal(std::uint32_t triangle) const {
    const auto& [a, b, c] = triangles[triangle];
    return cross(positions[b] - positions[a], positions[c] - positions[a]);
  }
  /// Twice the area in m^2; infinite or 0 only if float cannot represent it.
  float doubled_area(std::uint32_t triangle) const {
    const Vec3 n = scaled_normal(triangle);
    // The square of an area exceeds the range of float in scenes of micrometres and of billions of metres.
    const double x = n.x, y = n.y, z = n.z;
    return static_cast<float>(std::sqrt(x * x + y * y + z * z));
  }
  /// Area in m^2.
  float area(std::uint32_t triangle) const { return 0.5f * doubled_area(triangle); }
  /// Unit normal by the winding; (0,0,0) for a triangle without area.
  Vec3 normal(std::uint32_t triangle) const {
    const Vec3 n = scaled_normal(triangle);
    const float l = doubled_area(triangle);
    return l > 0 ? n / l : Vec3{0, 0, 0};
  }
  Box3 bounds() const {
    Box3 box;
    for (const Vec3& p : positions) box.grow(p);
    return box;
  }
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
