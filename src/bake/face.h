// Sides of triangles that get texels.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "scene/geometry.h"

namespace glowworm {

/// One side of a triangle: its front by the winding, or its back.
struct BakeFace {
  std::uint32_t triangle = kNone;
  bool back = false;

  bool operator==(const BakeFace&) const = default;
};

/// Unit normal on the side of the face; (0,0,0) for a triangle without area.
inline Vec3 face_normal(const Geometry& geometry, BakeFace face) {
  const Vec3 n = geometry.normal(face.triangle);
  return face.back ? -n : n;
}

/// An edge that two faces share: corner `corner` and the next one of each. The corners of the two faces run in opposite
/// directions.
struct SharedEdge {
  std::uint32_t face[2] = {kNone, kNone};  ///< indices into the list of faces
  std::uint8_t corner[2] = {0, 0};         ///< where the edge begins in each
};

/// All edges that exactly two faces share, by the bits of the positions of their ends, in a fixed order. Faces on
/// opposite sides share none, nor do more than two faces at one edge (a surface that is no manifold).
std::vector<SharedEdge> shared_edges(const Geometry& geometry, std::span<const BakeFace> faces);

}  // namespace glowworm
