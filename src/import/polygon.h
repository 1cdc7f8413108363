// Polygons to triangles.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// Cuts a polygon of three corners or more into two triangles less than it has corners, wound as it is, and appends
/// them. A convex one becomes a fan around its first corner; of others ears are cut off (Meisters, "Polygons Have
/// Ears", 1975). The work is in proportion to the number of corners, so that a polygon of thousands of reflex corners,
/// or one that crosses itself, may end in a fan.
/// @param triangles takes indices into `corners`
/// @return whether the polygon was convex or all of it was cut into ears
bool cut_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace glowworm
