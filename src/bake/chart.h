// Charts: connected faces, projected to a plane.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/face.h"

namespace glowworm {

/// Faces projected to a plane, without overlaps.
struct Chart {
  std::vector<std::uint32_t> faces;          ///< indices into the list of faces
  std::vector<std::array<Vec2, 3>> corners;  ///< of each face: metres from the lower corner of the chart's rectangle
  Vec2 size;                                 ///< sides of the rectangle, metres
};

/// Where a face lies: its chart, and its index there.
struct FacePlace {
  std::uint32_t chart = kNone, index = 0;
};

/// The place of each face. @param faces number of faces in all
std::vector<FacePlace> places_of_faces(std::span<const Chart> charts, std::size_t faces);

/// Cuts faces into charts: connected faces of one object and one material whose normals lie within 45 degrees of a
/// common direction, projected along it, so that lengths shrink by 30% at most. Each chart lies in its rectangle of
/// least area. Every face is in exactly one chart.
std::vector<Chart> make_charts(const Geometry& geometry, std::span<const BakeFace> faces);

/// The charts that a file's own texture coordinates make: one for each object, in proportion to its area in space.
struct OwnCharts {
  std::vector<Chart> charts;
  std::vector<std::uint32_t> rest;   ///< indices of faces without usable coordinates
  std::vector<std::string> reasons;  ///< why, one for each object that cannot use its own
};

/// Uses geometry.second_uvs where an object's coordinates lie in [0, 1], do not overlap and have area.
OwnCharts own_charts(const Geometry& geometry, std::span<const BakeFace> faces);

}  // namespace glowworm
