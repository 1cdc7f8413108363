// Places shapes in the world: transforms, orientation, emission and texture coordinates.
#pragma once
#include <memory>
#include <vector>

#include "core/transform_double.h"
#include "import/instance_keeper.h"
#include "import/pbrt/context.h"
#include "import/pbrt/lights.h"
#include "import/pbrt/tessellation.h"

namespace glowworm {

/// A shape with the attributes at its directive.
struct PbrtShape {
  PbrtMesh mesh;             ///< in its own space
  TransformDouble to_outer;  ///< from the shape's space to the space of its directive: the world's, or an object's
  bool reverse = false;      ///< ReverseOrientation applies
  std::uint32_t material = 0;
  bool textured = true;                  ///< texture coordinates are needed
  std::shared_ptr<PbrtAreaLight> light;  ///< null if it does not emit
  PbrtPlace place;
  std::string kind;
  std::string name;  ///< of the object; empty: its kind and a number
};

/// The shape's mesh in world space. As in pbrt, the outside is the side of the shape's normals or, without normals, the
/// side given by the winding in its own space. Mirroring transforms do not turn the shape inside out;
/// ReverseOrientation does. If the material is textured, triangles without texture coordinates get (0,0), (1,0), (1,1),
/// and quads also (0,1).
/// @param to_world applied after shape.to_outer
/// @param origin   is subtracted from the positions
Geometry to_world_space(const PbrtShape& shape, const TransformDouble& to_world, CoordinateOrigin& origin);

/// The shapes of an object as one mesh in the object's space; none of them emits light. Throws Error for a bad mesh.
SharedMesh shared_mesh(const std::vector<PbrtShape>& shapes);

/// Adds a shape to the context's scene. Triangles without area or with infinite corners are left out, with a note.
void place_shape(PbrtContext& context, const PbrtShape& shape, const TransformDouble& to_world);

}  // namespace glowworm
