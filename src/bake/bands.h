// Bakes whose film does not fit into memory, as several Jobs one after another.
#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "bake/light.h"
#include "gather/point_pass.h"
#include "render/job.h"

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

/// What the Jobs of a bake computed.
struct Baked {
  TexelIrradiance irradiance{0};
  std::uint32_t passes = 0;  ///< that every point has
  double seconds = 0;
  Ending ending = Ending::samples_done;
  std::exception_ptr failure;  ///< of a Job, or null
};

/// Waits for the Job of a band, of so many, and returns its failure, or null.
using AttendBand = std::function<std::exception_ptr(Job&, const BakeBand&, std::size_t bands)>;

/// Computes the irradiance of points by one Job for each band, until one does not end. Throws Error where memory is too
/// small for the points themselves.
/// @param settings with the memory and the time of the whole bake
/// @param resume   for the first Job; null: none
Baked bake_points(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                  const std::shared_ptr<const PointGrid>& points, RenderSettings settings, const Checkpoint* resume,
                  const AttendBand& attend);

}  // namespace glowworm
