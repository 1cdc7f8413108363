// Pilot passes that find out where the image needs photons, and which light paths bring them there.
#pragma once
#include "photon/photon_tracer.h"
#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// What guides the photons of a render.
struct PhotonGuiding {
  PhotonDemand demand;
  EmissionGuide guide;  ///< uniform where guiding would not pay
};

/// Sends a coarse picture's camera and gather rays to see where photons will be asked for, then photons in a few
/// rounds, each guided by those before. Where photons reach those places easily, emission stays as it is, bit for bit.
/// Takes about as long as half of the photons do, and an eighth where they reach those places easily. The same for any
/// number of threads.
/// @param settings resolved
PhotonGuiding guide_photons(const Tracer& tracer, const RenderSettings& settings);
/// The same for a camera that is none of the scene's.
PhotonGuiding guide_photons(const Tracer& tracer, const Camera& camera, const RenderSettings& settings);

}  // namespace glowworm
