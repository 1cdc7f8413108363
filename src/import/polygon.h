// Triangulation of polygons.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// Triangulates a polygon of n >= 3 corners into n - 2 triangles with the same winding, and appends them. A convex
/// polygon becomes a fan around its first corner; others are cut by ears (Meisters, "Polygons Have Ears", 1975). The
/// work is linear in n. To keep it so, a polygon with thousands of reflex corners, or one that intersects itself, may
/// end in a fan.
/// @param triangles receives indices into `corners`
/// @return whether the polygon was convex or was cut into ears completely
bool cut_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace glowworm
