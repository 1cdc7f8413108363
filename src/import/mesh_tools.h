// Operations on a mesh that all importers share.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/transform.h"
#include "import/notes.h"
#include "scene/geometry.h"

namespace glowworm {

/// The bits of n floats, as a key of hash tables.
template <std::size_t n>
using FloatBits = std::array<std::uint32_t, n>;

struct FloatBitsHash {
  template <std::size_t n>
  std::size_t operator()(const FloatBits<n>& bits) const {
    std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a, a word at a time
    for (const std::uint32_t word : bits) {
      hash = (hash ^ word) * 0x100000001b3ull;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// Albedo of surfaces without a material.
inline constexpr float kDefaultAlbedo = 0.8f;

/// Bytes of memory that the arrays of a mesh take.
std::uint64_t mesh_bytes(const Geometry& mesh);

/// Bytes that a mesh takes in a scene: its tables, and what rays are traced against.
std::uint64_t scene_bytes(const Geometry& mesh);
/// The same by numbers. @param vertices of which no more than three for each triangle count
std::uint64_t scene_bytes(std::uint64_t triangles, std::uint64_t vertices);

/// Moves a mesh to world space. Normals stay unit; where the map mirrors, triangles are wound the other way round, so
/// that their outside stays outside (glTF 2.0, section 3.7.4).
void transform_mesh(Geometry& mesh, const Transform& to_world);

/// Joins vertices whose position, normal and texture coordinates have the same bits.
void merge_identical_vertices(Geometry& mesh);

/// Winds triangles so that they agree with their vertex normals, which say where the outside is; returns how many were
/// turned round. Triangles whose vertices have no normals, or normals on both sides, stay as they are.
std::size_t wind_by_normals(Geometry& mesh);

/// append_mesh() with what was dropped counted in the notes.
void append_counted(Geometry& geometry, const Geometry& mesh, const std::string& name, std::uint32_t material,
                    std::uint32_t emission, NoteCounter& notes);

}  // namespace glowworm
