// Photons and query points on the surfaces of simple rooms, for the tests of the density engines.
#pragma once
#include <string>
#include <vector>

#include "density/engine.h"
#include "points/photon_batch.h"
#include "points/query_points.h"

namespace glowworm::density_tests {

/// Photons spread evenly over the six inner walls of the unit cube, and over the sides of a small box in it.
PhotonBatch room_photons(std::size_t count, std::uint32_t seed = 1);

/// Lambertian query points on the same surfaces, each with its own reflectance.
QueryPoints room_queries(std::size_t count, std::uint32_t seed = 2);

/// All arrays of one photon or query point, at a place, with a normal.
void add_photon(PhotonBatch& photons, Vec3 position, Vec3 normal, RGB flux = RGB(1.0f));
void add_query(QueryPoints& points, Vec3 position, Vec3 normal, RGB reflectance = RGB(0.5f));

/// What an engine says: build, then estimate into zeros.
std::vector<RGB> run(const std::string& engine, const PhotonBatch& photons, const RadiusPolicy& policy,
                     const QueryPoints& points, Statistics* statistics = nullptr);

/// The largest relative difference of a channel; values under a hundredth of the largest one count as that, since a
/// kernel that is near zero at the rim has no relative precision there. Infinite where a value is not a number.
double largest_difference(const std::vector<RGB>& values, const std::vector<RGB>& expected);

}  // namespace glowworm::density_tests
