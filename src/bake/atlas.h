// Places of charts in atlases.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bake/chart.h"

namespace glowworm {

/// Largest side of an atlas, in texels; what all graphics cards of the last ten years can show.
inline constexpr int kMaxAtlasSide = 16384;

/// Wanted properties of atlases; 0 means automatic, except for memory.
struct AtlasRequest {
  int side = 0;                 ///< of an atlas, texels
  double texels_per_metre = 0;  ///< automatic: what one atlas holds
  /// For the tables of texels.
  std::uint64_t memory_bytes = std::numeric_limits<std::uint64_t>::max();
};

/// Where a chart lies. A point p of the chart (metres) is at texel coordinates origin + scale * p, in which the texel
/// in column i has its centre at i + 0.5. The sides of the chart's rectangle run through centres of texels.
struct ChartPlace {
  int atlas = 0;
  Vec2 origin, scale;                         ///< texels; texels per metre
  int x0 = 0, y0 = 0, width = 0, height = 0;  ///< the texels that are the chart's, with its gutter

  Vec2 texel(Vec2 p) const { return {origin.x + scale.x * p.x, origin.y + scale.y * p.y}; }
};

/// Charts in one or several square atlases of one size.
struct Atlas {
  int side = 0, count = 0;
  double texels_per_metre = 0;
  std::size_t shrunk = 0;          ///< charts that got fewer texels than asked for, since an atlas holds no more
  std::vector<ChartPlace> places;  ///< one a chart
};

/// Texels of gutter around each chart, so that bilinear filtering of the texture and of its first mipmap reads nothing
/// of another. The second mipmap would need 5, the third 11.
inline constexpr int kGutter = 2;

/// Packs charts (stb_rect_pack). Throws Error where so many charts do not fit into any number of atlases of that side.
Atlas pack(std::span<const Chart> charts, const AtlasRequest& request);

}  // namespace glowworm
