// Radii for the sample-point estimator, found from the photons' own density: nothing for the user to set.
#pragma once
#include <cstdint>
#include <vector>

#include "points/photon_batch.h"

namespace glowworm {

/// Radii of photons, metres, and what comes with finding them: the photons in an order in which neighbours lie together
/// (RadiusPolicy::order).
struct PhotonRadii {
  std::vector<float> radii;
  std::vector<std::uint32_t> order;
};

/// A radius for each photon such that about k photons lie within it ([HHS05] section 6.1): from the leaves of a
/// sliding-midpoint kd-tree, whose cells' extents and counts give the density, smoothed so that neighbours have alike
/// radii. Deterministic for any number of threads. Metres, one for each photon; never 0, never not finite.
PhotonRadii measured_radii(const PhotonBatch& photons, std::uint32_t k);
/// The radii alone.
std::vector<float> per_photon_radii(const PhotonBatch& photons, std::uint32_t k);

/// One radius for all: the median of a coarse density estimate of the same kind ([SF07], kernel width h). Metres.
float fixed_radius(const PhotonBatch& photons, std::uint32_t k);

}  // namespace glowworm
