// Radii that make the mean number of shader operations of a query point what a table asks for: k of the papers.
#pragma once
#include "density/engine.h"
#include "support/recording.h"

namespace glowworm::bench {

/// One radius for all photons, as [SF07] has it, with which a query point sees k photons in the mean (to a few
/// percent).
RadiusPolicy fixed_radius_for(const Recording& recording, double k);

/// Radii of per_photon_radii(), times one factor with which a query point sees k photons in the mean. Boundaries and
/// normals take away photons that the density estimate counted on, so the factor is above 1.
RadiusPolicy own_radii_for(const Recording& recording, double k);

/// The query points whose place in an order falls into every `step`th run of `run` places, in the order in which they
/// are recorded. Lookups of these are as coherent as those of all, so that a long measurement may be cut short.
/// @param order the index of each place's point; empty: as recorded
QueryPoints runs_of(const QueryPoints& points, const std::vector<std::uint32_t>& order, std::size_t run,
                    std::size_t step);

/// The query points in another order: element i is point order[i].
QueryPoints in_order(const QueryPoints& points, const std::vector<std::uint32_t>& order);

}  // namespace glowworm::bench
