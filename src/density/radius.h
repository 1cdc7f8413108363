// Radii for the sample-point estimator, from the density of the photons. The user sets nothing.
#pragma once
#include <cstdint>
#include <vector>

#include "points/photon_batch.h"

namespace glowworm {

/// Radii of photons in metres, and a by-product:
/// the photons in a spatially coherent order (RadiusPolicy::order).
struct PhotonRadii {
  std::vector<float> radii;
  std::vector<std::uint32_t> order;
};

/// Returns a radius for each photon that holds about k photons ([HHS05] section 6.1). The extents and counts of the
/// leaves of a sliding-midpoint kd-tree give the density, smoothed so that neighbours have similar radii. Does not
/// depend on the number of threads. Metres; always positive and finite.
PhotonRadii measured_radii(const PhotonBatch& photons, std::uint32_t k);
/// The radii only.
std::vector<float> per_photon_radii(const PhotonBatch& photons, std::uint32_t k);

/// One radius for all photons, metres ([SF07], width h): the root mean square of measured_radii(), with which points
/// evenly spread over the surface that has photons find k on average.
float fixed_radius(const PhotonBatch& photons, std::uint32_t k);

}  // namespace glowworm
