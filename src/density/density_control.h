// Density control: removes photons where there are more than the estimate needs ([HHS05], section 6.2).
#pragma once
#include <cstdint>

#include "points/photon_batch.h"

namespace glowworm {

struct DensityControlSettings {
  /// Number of photons to keep. The batch is thinned where it is densest, by the threshold that gives this number.
  std::size_t wanted = 500000;
  std::uint32_t seed = 0;  ///< of the order in which photons are visited
};

/// Thins a batch after Suykens and Willems, "Density Control for Photon Maps" (2000). Visits photons in random order;
/// if the density of the nearest photons is above a threshold, gives the photon's flux to neighbours with similar
/// normal and incoming direction, and drops the photon. The sum of all flux is preserved to single-precision rounding.
/// Photons without a neighbour on their surface are kept, so a few more than wanted may be left. Keeps the order of the
/// remaining photons. Uses all threads; the result does not depend on their number.
PhotonBatch control_density(const PhotonBatch& photons, const DensityControlSettings& settings);

}  // namespace glowworm
