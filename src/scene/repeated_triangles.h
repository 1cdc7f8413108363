// Triangles and instances that lie exactly upon others.
#pragma once
#include <vector>

#include "scene/geometry.h"

namespace glowworm {

/// For each triangle that is not of an instance, whether an earlier one has the same corners, winding, material and
/// emission; empty if none has. A ray-tracing structure cannot separate such triangles: each ray that meets one is
/// tested against all of them. Runs on all threads.
/// @param ignored materials whose triangles never repeat another: layers with holes add up
std::vector<bool> repeated_triangles(const Geometry& geometry, const std::vector<bool>& ignored);

/// For each instance, whether an earlier one has the same mesh in the same place; empty if none has.
/// @param ignored as above; instances with one of these materials repeat no other
std::vector<bool> repeated_instances(const Geometry& geometry, const std::vector<bool>& ignored);

}  // namespace glowworm
