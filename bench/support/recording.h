// Photons and query points as a render of a scene makes them, for benchmarks of what looks them up.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

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

/// The scenes of [SF07]'s tables that are there: builtin:cornell, builtin:atrium, and Sponza if it is found.
std::vector<std::string> table_scenes();

/// How a table calls a scene: "cornell", "atrium", "sponza".
std::string short_name(const std::string& path);

}  // namespace glowworm::bench
