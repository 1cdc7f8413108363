// Pilot passes that find where the image needs photons, and which light paths reach those places.
#pragma once
#include "core/shared_work.h"
#include "gather/point_pass.h"
#include "photon/photon_tracer.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// The guide of a render's photons.
struct PhotonGuiding {
  PhotonImportance importance;
  EmissionGuide guide;  ///< uniform if guiding does not pay
};

/// How learn_emission() learns.
struct EmissionLearning {
  std::size_t count = 0;                ///< pilot paths of a round
  std::size_t most_in_first = 32;       ///< the first round has up to this many times `count`, until enough contribute
  int most_rounds = 10;                 ///< more than 4 are made while few paths contribute
  float floor = EmissionGuide::kFloor;  ///< least density, as in EmissionGuide::learn()
};

/// Learns where to emit photons in a few rounds of pilot paths, each guided by those before. The uniform guide if that
/// does not pay. The result does not depend on the number of threads.
/// @param pilot settings of the paths, which say what counts; their guide is not used
EmissionGuide learn_emission(const Tracer& tracer, PhotonPassSettings pilot, const EmissionLearning& learning);

/// Number of paths in a round of guide_photons(). Settings that differ in `photons`, but not in this number, have the
/// same guide.
std::size_t guiding_paths(const RenderSettings& settings);

/// Traces a coarse picture's camera and gather rays to find where photons are needed, then learn_emission(). If photons
/// reach those places easily, emission stays unguided, bit for bit. Takes about half as long as the photons, and an
/// eighth in the easy case. The result does not depend on the number of threads.
/// @param settings resolved @param shared processes of which one makes the guide for all; null: none
PhotonGuiding guide_photons(const Tracer& tracer, const View& view, const RenderSettings& settings,
                            SharedWork* shared = nullptr);

}  // namespace glowworm
