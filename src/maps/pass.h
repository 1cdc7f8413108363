// One pass over a task, from the camera to radiance. Renders and sessions share it.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "core/memory_budget.h"
#include "core/statistics.h"
#include "density/query_store.h"
#include "gather/point_pass.h"
#include "maps/photon_maps.h"
#include "points/query_points.h"
#include "trace/tracer.h"

namespace glowworm {

/// Output of a pass for its slots.
enum class PassKind : std::uint8_t {
  gather,          ///< light by final gathering
  photons,         ///< the photon map shown directly
  surfaces,        ///< FirstHit only
  count_seen,      ///< photons around the gather points: PhotonMaps::diagnosis()
  count_gathered,  ///< photons around the ends of gather rays
  gather_rays,     ///< light that gather rays find, without light samples and the caustic map at gather points
};

/// Settings of a pass.
struct PassSettings {
  PassKind kind = PassKind::gather;
  int width = 0, height = 0;        ///< of the whole picture or grid of points
  std::uint32_t gather = 16;        ///< final gather rays of each camera sample
  std::uint32_t light_samples = 0;  ///< light samples of each gather point
  std::uint32_t seed = 0;
  bool places = false;                                  ///< fill FirstHit::triangle and barycentric, too
  SlotValues values;                                    ///< kinds gather and photons: fill these of FirstHit, too
  bool surface_samples = false;                         ///< of camera views: CameraPassSettings::surface_samples
  KnownLightEdges* edges = nullptr;                     ///< of camera views: CameraPassSettings::edges
  bool direct = true, indirect = true, caustic = true;  ///< which parts of gathered light to compute
  bool secondary_gather = true;                         ///< FinalGatherSettings::radii
  /// Fill PassResult::global_points and caustic_points, and find no light but PhotonMaps::signed_media().
  bool query_points_alone = false;
  /// Kind gather: extrapolate estimates of the global map to kernels without area, by PhotonMaps::narrow(). Their bias
  /// falls with the square of the area then, and the variance of one is about four times as large.
  bool extrapolates = false;
  bool patches = true;                                 ///< send some gather rays to bright patches
  const GatherGuide* guide = nullptr;                  ///< of gather rays; null: none
  std::size_t queries_at_once = std::size_t{1} << 21;  ///< query points of a portion, if the budget allows
  const LightGroups* light_groups = nullptr;  ///< fill SlotRadiance::groups; null: none. As in PhotonMapSettings
  bool by_disk = false;                       ///< kind gather: query points go through a file (density/query_store.h)
};

/// Results of a pass; one entry a slot.
struct PassResult {
  SlotRadiance radiance;  ///< W sr^-1 m^-2; of kinds that show light
  FirstHit first_hit;
  QueryPoints global_points, caustic_points;  ///< with PassSettings::query_points_alone; their targets are slots
  std::vector<RGB> diagnosis;  ///< of kinds that count: as photon_diagnosis() takes it, summed over query points
};

/// Working memory of passes, one after another. Its arrays grow and are reused, because the system need not clear
/// memory that is reused.
struct PassMemory {
  GatherPoints points;
  QueryPoints queries;
  QueryPoints secondary_queries;       ///< of the secondary gather, for the caustic map
  VolumeSegments segments;             ///< of rays in media
  LargeVector<RGB> found;              ///< radiance of the query points
  std::uint64_t most_query_bytes = 0;  ///< peak size of query points
  DiskTraffic disk;                    ///< of query points

  /// Frees the arrays; keeps the counts.
  void clear();
  /// Between passes: reserves the arrays' size in the budget; frees them if that is more than half of the remaining
  /// budget.
  void keep(MemoryBudget& budget);
  std::unique_ptr<Reservation> reservation;  ///< of what is kept
};

/// Makes room in `radiance` for the light of each group. `groups` must outlive it.
void name_groups(const LightGroups& groups, SlotRadiance& radiance);

/// Renders the tasks over pixels or points on all threads. The same bits for any number of threads. Throws Cancelled
/// within a CancellationScope that is interrupted, and Error where the budget is too small.
/// @param maps up to date; not used by PassKind::surfaces
PassResult render_pass(const Tracer& tracer, const PhotonMaps& maps, const View& view, CameraTasks tasks,
                       const PassSettings& settings, MemoryBudget& budget, PassMemory& memory, Statistics& statistics);

}  // namespace glowworm
