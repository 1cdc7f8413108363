// Curved shapes as triangles.
#pragma once
#include <cstdint>
#include <vector>

#include "core/vec.h"
#include "scene/geometry.h"

namespace glowworm {

/// A shape's mesh in its own space, wound counter-clockwise seen from outside. `patch` gives the number of the pbrt
/// shape that each triangle belongs to, from 0; empty: all belong to one shape.
struct PbrtMesh {
  Geometry geometry;  ///< without materials and emissions; normals and uvs may be empty
  std::vector<std::uint32_t> patch;
  Vec3 origin{0, 0, 0};  ///< in the shape's space, the place that the positions are relative to
};

/// A part of a sphere around the origin, as in pbrt: cut off below z_min and above z_max, and after phi_max (radians,
/// in (0, 2 pi]) around z from +x towards +y. Normals are the sphere's and point outwards; u runs with phi, v
/// from z_min to z_max. The vertices lie on a slightly larger sphere, so that the triangles have the area of the true
/// surface.
/// @param fine 4 times as many triangles
PbrtMesh tessellate_sphere(float radius, float z_min, float z_max, float phi_max, bool fine);

/// A disk with a hole, at height z, seen from above. u runs with phi, v inwards. It has the area of the true surface.
PbrtMesh tessellate_disk(float height, float radius, float inner_radius, float phi_max);

/// The side of a cylinder around z. u runs with phi, v with z. It has the area of the true surface.
PbrtMesh tessellate_cylinder(float radius, float z_min, float z_max, float phi_max);

/// Appends to `mesh` a bilinear patch with corners p(0,0), p(1,0), p(0,1), p(1,1): two triangles if it is flat,
/// otherwise a grid of 16 x 16 x 2. `normals` and `uvs` of the corners, in this order, are empty or four. A curved
/// patch without given normals gets the surface's.
void append_bilinear_patch(const Vec3 (&corner)[4], const std::vector<Vec3>& normals, const std::vector<Vec2>& uvs,
                           PbrtMesh& mesh);

}  // namespace glowworm
