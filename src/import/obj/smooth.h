// Vertex normals of smoothing groups.
#pragma once
#include <cstdint>
#include <span>

#include "scene/geometry.h"

namespace glowworm {

/// Computes normals of vertices without one: the mean of the unit normals of triangles at the same position, across
/// edges of less than 60 degrees. The work is linear in the number of triangles.
/// @param mesh triangles share no vertices; all arrays have full length
/// @param chosen triangles to smooth together, in ascending order
void smooth_normals(Geometry& mesh, std::span<const std::uint32_t> chosen);

}  // namespace glowworm
