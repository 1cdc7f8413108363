// Where open surfaces end without another surface to go on.
#pragma once
#include <cstdint>
#include <vector>

#include "core/vec.h"
#include "scene/geometry.h"

namespace glowworm {

/// An edge that only one triangle of a surface has.
struct BorderEdge {
  Vec3 a, b;
  std::uint32_t triangle;  ///< of the geometry
  std::uint32_t surface;
  float reach;  ///< another surface nearer to the middle than this goes on from the edge, m
};

/// Lengths of the edges of each surface that are free: no other surface is within reach, and no other triangle of their
/// own lies at them, as at a seam whose two sides have different vertices.
/// @param surface_of by triangle of the geometry; any number for those that are no part of a surface
/// @param surfaces number of surfaces
std::vector<double> free_border_lengths(const Geometry& geometry, std::vector<BorderEdge> edges,
                                        const std::vector<std::uint32_t>& surface_of, std::size_t surfaces);

}  // namespace glowworm
