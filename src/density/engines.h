// Functions that make engines; each is in the file of its engine.
#pragma once
#include <memory>

#include "density/engine.h"

namespace glowworm {

/// Forward SIMD photon mapping [SF07]: packets of query points walk a kd-tree of one photon a node. Fixed and
/// per-photon radii. Options of its own are in forward.h.
std::unique_ptr<DensityEngine> make_forward_engine();
/// Normal photon mapping, the baseline of [SF07] and [HHS05]: each query point searches a kd-tree for its k nearest
/// photons. Supports nearest and fixed.
std::unique_ptr<DensityEngine> make_knn_engine();
/// Every photon against every query point in double precision: the reference for the other engines. Supports every
/// RadiusKind.
std::unique_ptr<DensityEngine> make_brute_engine();

/// Blocks of query points against blocks of photons, both sorted in space. Supports fixed and per_photon.
std::unique_ptr<DensityEngine> make_blocked_engine();
/// Reverse photon mapping [HHS05]: photons search a kd-tree over the query points. Fixed and per-photon radii. Options
/// of its own are in reverse.h.
std::unique_ptr<DensityEngine> make_reverse_engine();

}  // namespace glowworm
