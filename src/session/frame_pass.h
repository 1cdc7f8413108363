// One camera sample of every pixel of a view, from the camera to radiance.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "core/memory_budget.h"
#include "core/statistics.h"
#include "gather/camera_pass.h"
#include "points/query_points.h"
#include "session/interrupt.h"
#include "session/photon_maps.h"
#include "session/view_state.h"
#include "trace/tracer.h"

namespace glowworm {

/// Query points that are looked up at once: the more, the closer together they lie, and the more share their searches.
inline constexpr std::size_t kQueriesAtOnce = std::size_t{1} << 21;

/// What one pass renders.
struct FramePassSettings {
  int width = 0, height = 0;  ///< pixels
  std::uint32_t sample = 0;   ///< number of the camera sample
  std::uint32_t gather = 16;  ///< final gather rays of each camera sample
  std::uint32_t seed = 0;
  ViewMode mode = ViewMode::gather;
  LightPart part = LightPart::all;  ///< of gathered light: nothing else is computed
  bool corners = true;              ///< short gather rays gather again (FinalGatherSettings::radii)
};

/// What a pass found, one entry a pixel.
struct FramePass {
  SlotRadiance radiance;  ///< W sr^-1 m^-2; of modes that show light
  FirstHit first_hit;
  std::vector<RGB>
      diagnosis;  ///< of false colours: as PhotonDiagnosis; of cost, b summed over the pixel's query points
};

/// What passes work in, one after another: it grows, and memory that was used before need not be cleared by the system.
struct FramePassMemory {
  GatherPoints points;
  QueryPoints queries, caustic_queries;
  LargeVector<RGB> found;  ///< radiance of the query points

  /// Between passes: stays within the budget, where there is plenty, or else goes.
  void keep(MemoryBudget& budget);
  std::unique_ptr<Reservation> reservation;  ///< of what is kept
};

/// Renders a pass. Throws Cancelled soon after the interrupt was requested. The same bits for any number of threads.
/// @param maps up to date; not looked at where the mode shows surfaces alone
FramePass render_frame_pass(const Tracer& tracer, const PhotonMaps& maps, const Camera& camera,
                            const FramePassSettings& settings, MemoryBudget& budget, const Interrupt& interrupt,
                            Statistics& statistics, FramePassMemory& memory);

/// Whether a mode shows light, or else surfaces and counts.
bool shows_light(ViewMode mode);
/// Whether a mode needs photons.
bool needs_photons(ViewMode mode);
/// Whether a mode needs PhotonMapSettings::diagnosed.
bool needs_diagnosis(ViewMode mode);

}  // namespace glowworm
