// From charts in atlases to the place of each texel.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bake/atlas.h"

namespace glowworm {

/// The place of every texel of all atlases, which stand on top of each other: row y of atlas a is row a * side + y.
struct TexelMap {
  int width = 0, height = 0;
  std::vector<std::uint32_t> face;   ///< index into the list of faces; kNone: the texel belongs to no chart
  std::vector<Vec2> barycentric;     ///< weights of the second and third corner
  std::vector<std::uint32_t> chart;  ///< whose rectangle the texel lies in, with its gutter; kNone: none

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  std::size_t covered() const;
};

/// Finds the point of its chart that is nearest to the centre of each texel which bilinear filtering of a point of the
/// chart reads. Points at the rim of a face lie a twentieth of a texel inside of it, so that none lies in the corner of
/// two walls.
TexelMap map_texels(std::span<const Chart> charts, const Atlas& atlas);

}  // namespace glowworm
