// Final gathering: stratified, BRDF-sampled rays from the gather points, and query points at their ends.
#pragma once
#include <cstdint>
#include <span>

#include "core/statistics.h"
#include "gather/bright_patches.h"
#include "gather/radius_grid.h"
#include "points/gather_points.h"
#include "points/query_points.h"
#include "points/volume_segments.h"
#include "trace/tracer.h"

namespace glowworm {

struct FinalGatherSettings {
  std::uint32_t rays = 64;  ///< final gather rays of each gather point
  std::uint32_t seed = 0;
  std::uint32_t light_samples = 0;        ///< light samples of each gather point; 0: rays that hit lights are ignored
  const RadiusGrid* radii = nullptr;      ///< photon radii; null: no secondary gather from short rays
  const GatherGuide* guide = nullptr;     ///< of diffuse gather points; null: none
  const BrightPatches* bright = nullptr;  ///< patches to sample directly; null: none
  std::uint32_t patch_samples = 0;        ///< rays of each gather point to bright patches, in addition to `rays`
  /// Whether rays that meet lights through specular bounces add them to `radiance.caustic`. Use it for points without
  /// photons around them.
  bool adds_caustics = false;
  /// Gather again from ends of secondary rays that are short, too. Most rays are short in corners, where the photons'
  /// factors near edges (maps/boundary.h) keep the flux, but not the density; it costs a tenth of a picture's time.
  bool gathers_on = false;
  bool photons_alone = false;  ///< no light of lights, also where rays make a secondary gather: only query points

  bool looks_at_patches() const { return bright && patch_samples > 0 && !bright->empty(); }
};

/// Results of final gathering. Old content of the query points is replaced; their memory is reused.
struct GatherQueries {
  /// The query points. Neighbours in their order are close together in space. Weights include the throughput of the
  /// camera path and 1/N; gather_point is the slot.
  QueryPoints& queries;
  /// Query points of the secondary gather, for the caustic map. Null: there is no caustic map, and such rays add lights
  /// that they reach through specular bounces, which is rare and noisy.
  QueryPoints* caustic_queries = nullptr;
  VolumeSegments* segments = nullptr;  ///< the ways of rays through media, by slot; null: no media
};

/// Gathers from points [first, last): traces their rays on all threads. Adds to `radiance.direct` the light of rays
/// that hit lights, weighted against light_samples light samples, and to `radiance.indirect` the direct light at the
/// ends of rays that make a secondary gather. The result is the same for any number of threads. Adds to
/// Phase::gather_rays; counts gather_rays and occlusion_rays.
void final_gather(const Tracer& tracer, const GatherPoints& points, std::size_t first, std::size_t last,
                  const FinalGatherSettings& settings, SlotRadiance& radiance, const GatherQueries& found,
                  Statistics& statistics);

/// Completion: adds weight * queried * factor to `target` at each query point's slot, in the order of the query points
/// ([HHS05] section 4: sequentially, because scattered writes miss the cache).
void complete(const QueryPoints& queries, std::span<const RGB> queried, std::span<RGB> target, Statistics& statistics,
              float factor = 1);

}  // namespace glowworm
