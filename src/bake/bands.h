// Bakes whose film does not fit into memory, as several Jobs one after another.
#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/light.h"
#include "control/job.h"
#include "gather/point_pass.h"
#include "settings/options.h"

namespace glowworm {

/// Rows of texels that one Job computes.
struct BakeBand {
  int first = 0, end = 0;  ///< rows whose light is kept
  PixelBounds rendered;    ///< these, and as many around them as the filter reads
};

/// The settings of the Jobs of a bake, which has the tables of its points beside them. Throws Error where memory is too
/// small for these.
RenderSettings bake_settings(RenderSettings settings, const PointGrid& points);

/// Cuts the rows of a grid into bands of which one at a time fits into memory, with photons and query points. The light
/// does not depend on the cut. One band where all fits.
/// @param memory bytes for the Job of a band
/// @param first  the first row: a multiple of 32
std::vector<BakeBand> cut_into_bands(const PointGrid& grid, const RenderSettings& settings, std::uint64_t memory,
                                     int first = 0);

/// What the Jobs of a bake computed.
struct Baked {
  TexelIrradiance irradiance{0};
  std::uint32_t passes = 0;  ///< that every point has
  double seconds = 0;
  Ending ending = Ending::samples_done;
  std::exception_ptr failure;  ///< of a Job, or null
};

/// The Job of a band.
struct BandRun {
  Job& job;
  BakeBand band;
  std::size_t number = 0, count = 0;  ///< of the bands from now on
  const std::vector<RGB>& light;      ///< of all points; set in the rows above the band

  /// The state of the whole bake to continue from.
  Checkpoint checkpoint() const;
};

/// Waits for the Job of a band and returns its failure, or null.
using AttendBand = std::function<std::exception_ptr(const BandRun&)>;

/// Computes the irradiance of points by one Job for each band, until one does not end. All have the same photons.
/// @param settings with the memory and the time of the whole bake
/// @param resume   BandRun::checkpoint() of a bake with any memory; throws Error if it is of another one
Baked bake_points(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                  const std::shared_ptr<const PointGrid>& points, RenderSettings settings,
                  std::optional<Checkpoint> resume, const AttendBand& attend);

/// The irradiance of points in the file of a part. Throws Error if it is not of these, or if memory is too small.
/// @param given options that the part must have been computed with
Baked points_of_part(const std::string& path, const Scene& scene, const PointGrid& points,
                     const RenderSettings& settings, const std::vector<const Option*>& given);

}  // namespace glowworm
