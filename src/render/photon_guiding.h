// Pilot passes that find where the image needs photons, and which light paths reach those places.
#pragma once
#include "core/shared_work.h"
#include "gather/point_pass.h"
#include "photon/photon_tracer.h"
#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// The guide of a render's photons.
struct PhotonGuiding {
  PhotonDemand demand;
  EmissionGuide guide;  ///< uniform if guiding does not pay
};

/// Number of paths in a round of guide_photons(). Settings that differ in `photons`, but not in this number, have the
/// same guide.
std::size_t guiding_paths(const RenderSettings& settings);

/// Traces a coarse picture's camera and gather rays to find where photons are needed, then photons in a few rounds,
/// each guided by those before. If photons reach those places easily, emission stays unguided, bit for bit. Takes about
/// half as long as the photons, and an eighth in the easy case. The result does not depend on the number of threads.
/// @param settings resolved @param shared processes of which one makes the guide for all; null: none
PhotonGuiding guide_photons(const Tracer& tracer, const View& view, const RenderSettings& settings,
                            SharedWork* shared = nullptr);

}  // namespace glowworm
