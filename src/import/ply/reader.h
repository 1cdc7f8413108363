// Meshes from PLY files.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "scene/geometry.h"

namespace glowworm {

/// The mesh of a PLY file: vertices and triangles. Quadrilaterals are split along their shorter diagonal, or at a
/// reflex corner; larger faces by cut_polygon(). There is one normal and one texture vertex per vertex, or none. Faces
/// with texture coordinates at their corners have vertices of their own, after the file's, which they leave
/// unused.
struct PlyMesh : Geometry {
  std::size_t quads = 0;               ///< number of faces with four corners
  std::size_t larger_faces = 0;        ///< number of faces with more corners
  std::size_t smaller_faces = 0;       ///< number of faces with fewer than three corners, which are left out
  std::vector<std::uint32_t> face_of;  ///< for each triangle, the number of its face, from 0
  bool has_colors = false;             ///< vertices have colours, which are not supported
  std::string texture;                 ///< image name from the last comment "TextureFile", or empty
  int textures = 0;                    ///< number of these comments
};

/// Reads a PLY file: ASCII or binary of either byte order, gzipped or not. Vertices have x, y, z and optionally nx, ny,
/// nz and u, v (or s, t; tx, ty; texture_u, texture_v); faces have "vertex_indices" or "vertex_index" and, where the
/// header names a texture, optionally "texcoord"; or there are triangle strips ("tristrips"). Other elements and
/// properties are skipped. Memory is proportional to the file's size, whatever its header declares.
/// @param budget limits memory of file and mesh while reading
/// @param origin is subtracted from all positions; read_near() finds it
/// Throws Error with file (and line) and remedy, and MemoryError.
PlyMesh read_ply(const std::string& path, MemoryBudget& budget, CoordinateOrigin& origin);

/// Reads a PLY file from memory. @param file for messages
PlyMesh parse_ply(std::string_view bytes, const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin);

}  // namespace glowworm
