// Over which radii photons count: what renders and sessions have in common.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "density/engine.h"
#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// Photons that an estimate of the caustic map should catch, where one of the global map catches `nearest`: caustics
/// are sharp. At least 1.
std::uint32_t caustic_nearest(std::uint32_t nearest);

/// The policy of an engine: each photon's own radius, or the k nearest (EngineTraits::takes_nearest).
/// @param radii metres, one for each photon
RadiusPolicy photon_policy(std::vector<float> radii, const std::string& engine, KernelShape kernel, std::uint32_t k);

/// boundary_factors() (render/boundary.h) over the policy's radii, of whatever kind it is; nothing for no photons.
std::vector<float> edge_factors(const Tracer& tracer, const PhotonBatch& photons, RadiusPolicy policy);

}  // namespace glowworm
