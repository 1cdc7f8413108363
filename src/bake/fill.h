// Values for texels that have none of their own, and seams without steps.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bake/texels.h"
#include "core/rgb.h"
#include "scene/scene.h"

namespace glowworm {

/// Gives every texel that is not known the mean of its nearest known neighbours of the same chart, outwards to the end
/// of the chart's gutter, and all others the colours around them, for mipmaps. Charts without a known texel count as
/// space between charts.
/// @param known one a texel: whether it has a value
void fill_gaps(const TexelMap& map, std::vector<std::uint8_t> known, std::vector<RGB>& texels);

/// Where two charts meet in space without a crease, and the texture must show the same on both sides.
struct Seams {
  /// A place that two charts share: four texels with their weights on each side.
  struct Place {
    std::uint32_t texel[8];
    float weight[8];  ///< of the second side: negative
  };
  std::vector<Place> places;  ///< at least two for each texel along a seam
};

/// Finds the seams between charts: shared edges of faces of one material whose shading normals agree at both ends.
Seams find_seams(const Geometry& geometry, std::span<const BakeFace> faces, std::span<const Chart> charts,
                 const Atlas& atlas);

/// Changes texels along seams as little as possible, in the sense of least squares, so that bilinear filtering shows
/// the same on both sides: conjugate gradients over the normal equations of each group of seams that share texels,
/// channel by channel.
void close_seams(Seams seams, std::vector<RGB>& texels);

}  // namespace glowworm
