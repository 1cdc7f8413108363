// Bakes whose film does not fit into memory, as several Jobs one after another.
#pragma once
#include <cstdint>
#include <vector>

#include "gather/point_pass.h"
#include "render/settings.h"

namespace glowworm {

/// Rows of texels that one Job computes.
struct BakeBand {
  int first = 0, end = 0;  ///< rows whose light is kept
  PixelBounds rendered;    ///< these, and as many around them as the filter reads
};

/// Bytes that a bake holds for each texel beside its Job: place, point and light.
inline constexpr std::uint64_t kTexelTableBytes = 57;

/// Cuts the rows of a grid into bands of which one at a time fits into memory, with photons and query points. The light
/// does not depend on the cut. One band where all fits.
/// @param memory bytes for the Job of a band
std::vector<BakeBand> cut_into_bands(const PointGrid& grid, const RenderSettings& settings, std::uint64_t memory);

}  // namespace glowworm
