// Shapes of pbrt scenes, as triangles in their own space.
#pragma once
#include <optional>
#include <string>

#include "import/pbrt/context.h"
#include "import/pbrt/tessellation.h"

namespace glowworm {

/// The mesh of a Shape directive. Empty if it is not supported, which is noted, or invalid, which is an error.
/// @param emissive whether it is a light: emitting spheres need no fine tessellation
std::optional<PbrtMesh> make_shape(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                                   bool emissive);

/// Loop subdivision (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987) with boundaries. Vertices are moved
/// to the limit surface, and take its normals. A mesh with an edge of more than two triangles is returned
/// unchanged.
/// @param levels each level divides every triangle into four
Geometry loop_subdivide(const Geometry& control, int levels);

}  // namespace glowworm
