// A few photons of a map that stand for all, and what they say of the noise of sums over query points.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rgb.h"
#include "density/engine.h"
#include "points/photon_batch.h"
#include "points/query_points.h"

namespace glowworm {

/// Photons with their kernels, chosen from all.
struct PhotonSample {
  PhotonBatch photons;  ///< with their flux in the map, W
  RadiusPolicy policy;  ///< with their radii and cuts, and without an order
  float each = 1;       ///< for how many of all photons each of them stands
};

/// The photons of these indices. @param whole policy of all photons
PhotonSample sample_of(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& whole,
                       const std::vector<std::uint32_t>& indices);

/// The variance by photons of the light of targets (QueryPoints::gather_point), by channel, W^2 sr^-2 m^-4. Light is a
/// sum over photons, and the variance of a Poisson process is the sum of the squares of what each photon adds. Two
/// independent sets of query points see each photon: the products of what it adds to both have the square as their
/// expectation, without the noise of the sets. Every photon has the radius of its own, also under RadiusKind::nearest.
/// Uses all threads; the result does not depend on their number.
std::vector<RGB> variance_by_photons(const PhotonSample& sample, const QueryPoints& first, const QueryPoints& second,
                                     std::size_t targets);

/// The index of one photon of each run of `run` photons, chosen at random; a last run that is shorter has none.
std::vector<std::uint32_t> one_of_each_run(std::size_t count, std::size_t run);

}  // namespace glowworm
