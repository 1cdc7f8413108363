// The photon pass: light paths from the lights, and the photons they leave on surfaces.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/statistics.h"
#include "photon/emission_guide.h"
#include "photon/importance.h"
#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// The places at which the image asks for photons.
struct PhotonDemand {
  ImportanceGrid gathered;  ///< of the global map
  ImportanceGrid seen;      ///< of the caustic map, which is looked up where camera paths end
};

/// What a photon pass is to do.
struct PhotonPassSettings {
  std::uint64_t photons = 500'000;  ///< photons wanted in the global map; paths are emitted until it has as many
  std::uint64_t max_emitted = 0;    ///< paths at most, however few were stored; 0: 200 times `photons`
  std::uint32_t seed = 0;
  std::uint32_t pass = 0;                ///< passes of one seed have photons of their own
  int max_bounces = 64;                  ///< Russian roulette ends nearly all paths earlier
  const EmissionGuide* guide = nullptr;  ///< how emission is guided; null: by power alone
  const PhotonDemand* demand = nullptr;  ///< tells photons that are used from those that are not; null: all are
};

/// Flux of a pass, in W. Emitted light is counted where it goes, so that
/// emitted + scattered = arrived + escaped + cut, and absorbed = arrived - scattered.
struct FluxBalance {
  std::array<double, 3> emitted{}, arrived{}, scattered{}, escaped{}, cut{};
  std::array<double, 3> stored{};  ///< flux of the photons of the global map, before correction by shading normals
};

/// Photons of one pass. Fluxes are divided by the number of paths emitted already.
struct PhotonPass {
  PhotonBatch global;   ///< photons at every surface with a broad lobe, after any path
  PhotonBatch caustic;  ///< those whose bounces so far were all sharp, at least one; part of `global` too
  std::uint64_t emitted = 0;
  FluxBalance balance;
  /// By light source, as Scene::light_power() counts. `used`: of those stored, the photons at places that the image
  /// asks for.
  std::vector<std::uint64_t> emitted_by_light, stored_by_light, used_by_light;
};

/// Traces photons until the global map has the number wanted, on all threads; the same photons for any number of
/// threads. Adds to Phase::trace_photons and counts photons_emitted and photons_stored.
PhotonPass trace_photons(const Tracer& tracer, const PhotonPassSettings& settings, Statistics& statistics);

/// Traces `count` paths of a pilot pass, beginning with path `first`, by settings.guide; their scores are what they
/// bring to settings.demand (which must not be null), as a multiple of one photon's share of all power, without the
/// factor of the guide. PilotPath::density is that of the guide alone. The same for any number of threads.
std::vector<PilotPath> trace_pilot(const Tracer& tracer, const PhotonPassSettings& settings, std::uint64_t first,
                                   std::size_t count);

}  // namespace glowworm
