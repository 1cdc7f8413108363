// Mesh operations shared by all importers.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/coordinate_origin.h"
#include "core/transform.h"
#include "import/notes.h"
#include "scene/geometry.h"

namespace glowworm {

/// The bits of n floats, as a key for hash tables.
template <std::size_t n>
using FloatBits = std::array<std::uint32_t, n>;

struct FloatBitsHash {
  template <std::size_t n>
  std::size_t operator()(const FloatBits<n>& bits) const {
    std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a, one word at a time
    for (const std::uint32_t word : bits) {
      hash = (hash ^ word) * 0x100000001b3ull;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// Albedo of surfaces without a material.
inline constexpr float kDefaultAlbedo = 0.8f;

/// Memory of a mesh's arrays, bytes.
std::uint64_t mesh_bytes(const Geometry& mesh);

/// Memory of a material of a scene while materials are added, bytes: an array that grows exists twice.
std::uint64_t material_bytes();

/// Memory of a mesh in a scene, bytes: its tables and its ray-tracing structure.
std::uint64_t scene_bytes(const Geometry& mesh);
/// The same from counts. @param vertices at most three per triangle are counted
std::uint64_t scene_bytes(std::uint64_t triangles, std::uint64_t vertices);

/// Transforms a mesh to world space. Normals stay unit vectors. If the transform mirrors, the winding of triangles is
/// reversed, so that their outside stays outside (glTF 2.0, section 3.7.4).
void transform_mesh(Geometry& mesh, const Transform& to_world);

/// The same in double precision, to places relative to the origin. A mesh whose own coordinates lie far from (0, 0, 0)
/// was rounded before.
void place_mesh(Geometry& mesh, const TransformDouble& to_world, CoordinateOrigin& origin);

/// Winds all triangles the other way.
void reverse_winding(Geometry& mesh);

/// Merges vertices whose position, normal and texture coordinates have the same bits.
void merge_identical_vertices(Geometry& mesh);

/// Reverses triangles whose winding contradicts their vertex normals, which point outside. Returns how many were
/// reversed. Triangles without vertex normals, or with normals on both sides, are unchanged.
std::size_t wind_by_normals(Geometry& mesh);

/// append_mesh() that counts dropped triangles in the notes.
void append_counted(Geometry& geometry, const Geometry& mesh, const std::string& name, std::uint32_t material,
                    std::uint32_t emission, NoteCounter& notes);

}  // namespace glowworm
