// Shapes of pbrt scenes, as triangles in their own space.
#pragma once
#include <optional>
#include <string>

#include "import/pbrt/context.h"
#include "import/pbrt/tessellation.h"

namespace glowworm {

/// The mesh of a Shape directive; none where it is not supported, which is noted, or wrong, which is an error.
/// @param emissive whether it is a light: spheres that only emit need no fine outline
std::optional<PbrtMesh> make_shape(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                                   bool emissive);

/// Loop subdivision (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987) with boundaries, vertices moved to
/// the limit surface, and its normals. A mesh with an edge of more than two triangles comes back as it is.
/// @param levels each makes four triangles of one
Geometry loop_subdivide(const Geometry& control, int levels);

}  // namespace glowworm
