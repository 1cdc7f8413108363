// Meshes from PLY files, as pbrt scenes use them.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/memory_budget.h"
#include "core/vec.h"

namespace glowworm {

/// The mesh of a PLY file: vertices and triangles; four-sided faces are cut along their shorter diagonal, larger ones
/// as cut_polygon() does.
struct PlyMesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< one a vertex, or empty
  std::vector<Vec2> uvs;      ///< one a vertex, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::size_t quads = 0;         ///< how many faces had four corners
  std::size_t larger_faces = 0;  ///< how many had more
  bool has_colors = false;       ///< the vertices have colours, which are not read
  std::string texture;           ///< name of the image that a comment "TextureFile" gives, or empty
};

/// Reads a PLY file: ASCII or binary of either byte order, gzipped or not; vertices with x, y, z and, where given,
/// nx, ny, nz and u, v (or s, t; texture_u, texture_v); faces by "vertex_indices" or "vertex_index". Other elements
/// and properties are skipped. Memory stays in proportion to the file's size, whatever its header promises.
/// @param budget that file and mesh are reserved in while they are read
/// Throws Error with file (and line) and remedy, and MemoryError.
PlyMesh read_ply(const std::string& path, MemoryBudget& budget);

/// The same from bytes in memory. @param file for messages
PlyMesh parse_ply(std::string_view bytes, const std::string& file, MemoryBudget& budget);

}  // namespace glowworm
