// Triangles that lie exactly upon others.
#pragma once
#include <vector>

#include "scene/geometry.h"

namespace glowworm {

/// For each triangle that is not of an instance, whether an earlier one has the same corners, winding, material and
/// emission; empty if none has. A ray-tracing structure cannot separate such triangles: each ray that meets one is
/// tested against all of them. Runs on all threads.
/// @param ignored materials whose triangles never repeat another
std::vector<bool> repeated_triangles(const Geometry& geometry, const std::vector<bool>& ignored);

}  // namespace glowworm
