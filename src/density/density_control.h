// Density control: fewer photons where there are more than the estimate needs ([HHS05], section 6.2).
#pragma once
#include <cstdint>

#include "points/photon_batch.h"

namespace glowworm {

struct DensityControlSettings {
  /// Photons to keep. The batch is thinned where it is densest, at the density that gives this count.
  std::size_t wanted = 500000;
  /// Photons per square metre up to which the batch is not thinned, whatever `wanted` says; 0: no such density.
  float always_kept = 0;
  std::uint32_t seed = 0;  ///< of the order in which photons are looked at
};

/// Thins a batch after Suykens and Willems, "Density Control for Photon Maps" (2000): photons are looked at in random
/// order; where the density of the nearest photons is above a threshold, a photon's flux is handed to neighbours of
/// like normal and incoming direction, and the photon is dropped. The sum of all flux stays, to the rounding of single
/// precision. Photons without a neighbour on their surface are kept, so a few more than wanted may be left. What is
/// left keeps its order. On all threads; the same for any number of them.
PhotonBatch control_density(const PhotonBatch& photons, const DensityControlSettings& settings);

}  // namespace glowworm
