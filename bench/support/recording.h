// Photons and query points as a render of a scene makes them, for benchmarks of what looks them up.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "density/engine.h"
#include "points/photon_batch.h"
#include "points/query_points.h"
#include "trace/tracer.h"

namespace glowworm::bench {

/// A scene and what rays are traced against.
struct Stage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;

  /// Loads "builtin:NAME" or a file.
  explicit Stage(const std::string& path);
};

/// What is recorded.
struct RecordingSettings {
  std::uint64_t photons = 500'000;
  int width = 256, height = 256;  ///< pixels, of one camera sample each
  std::uint32_t gather = 16;      ///< final gather rays of each; 0: the gather points themselves are the query points
  bool guided = false;            ///< guide photons and gather rays, and continue short ones, as renders do
};

/// The photons of one pass and the query points of one camera sample of each pixel, in the order in which a render
/// makes them.
struct Recording {
  PhotonBatch photons;
  QueryPoints points;
};

/// Records the first camera of the stage, on all threads.
Recording record(const Stage& stage, const RecordingSettings& settings);

/// The query points whose place in an order falls into every `step`th run of `run` places, as they are recorded.
/// Lookups of these are as coherent as those of all.
/// @param order the index of each place's point; empty: as recorded
QueryPoints runs_of(const QueryPoints& points, const std::vector<std::uint32_t>& order, std::size_t run,
                    std::size_t step);

/// Query points' estimates by an engine, which are not kept.
void look_up(const DensityEngine& engine, const QueryPoints& points, Statistics& statistics);

/// Photons that a query point saw in the mean.
double mean_k(const Statistics& statistics);

/// One radius for all photons, as [SF07] has it, with which a query point sees k photons in the mean (to a percent).
/// On a surface the mean grows with the square of the radius.
RadiusPolicy fixed_radius_for(const Recording& recording, double k);

/// The scenes of [SF07]'s tables that are there: builtin:cornell, builtin:atrium, and Sponza if it is found.
std::vector<std::string> table_scenes();

/// How a table calls a scene: "cornell", "atrium", "sponza".
std::string short_name(const std::string& path);

}  // namespace glowworm::bench
