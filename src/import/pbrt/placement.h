// Shapes into the world: transforms, which side is outside, emission, texture coordinates.
#pragma once
#include <memory>

#include "core/transform.h"
#include "import/pbrt/context.h"
#include "import/pbrt/lights.h"
#include "import/pbrt/tessellation.h"

namespace glowworm {

/// A shape as the file gives it, with the attributes that were in force.
struct PbrtShape {
  PbrtMesh mesh;         ///< in its own space
  Transform to_outer;    ///< to the space that the shape was given in: the world's, or an object's
  bool reverse = false;  ///< ReverseOrientation was in force
  std::uint32_t material = 0;
  bool textured = true;                  ///< texture coordinates matter
  std::shared_ptr<PbrtAreaLight> light;  ///< null where it is none
  PbrtPlace place;
  std::string kind;
};

/// The shape's mesh in world space. Its outside is, as in pbrt, the side of its own normals where it has them, else
/// that which its winding gives in its own space, so mirroring does not turn it inside out; ReverseOrientation does.
/// Triangles of a mesh without texture coordinates get (0,0), (1,0), (1,1) where the material is textured.
/// @param to_world applied after shape.to_outer
Geometry to_world_space(const PbrtShape& shape, const Transform& to_world);

/// Adds a shape to the context's scene. Triangles without area or with infinite corners are left out and noted.
void place_shape(PbrtContext& context, const PbrtShape& shape, const Transform& to_world);

}  // namespace glowworm
