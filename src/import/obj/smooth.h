// Vertex normals of smoothing groups.
#pragma once
#include <cstdint>
#include <span>

#include "scene/geometry.h"

namespace glowworm {

/// Gives normals to vertices that have none: the mean of the triangles' unit normals around the place of the vertex,
/// over edges of less than 60 degrees. The work is in proportion to the number of triangles.
/// @param mesh triangles whose vertices belong to no other triangle; all arrays are full
/// @param chosen triangles that are smoothed with one another, in ascending order
void smooth_normals(Geometry& mesh, std::span<const std::uint32_t> chosen);

}  // namespace glowworm
