// Boundary correction: kernels that reach over the edge of a surface.
#pragma once
#include <vector>

#include "density/engine.h"
#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// A photon's kernel is normalised over a whole disc, but at an edge or on a small surface part of the disc lies where
/// there is nothing, or what no query point reaches (a floor goes on beneath a carpet, a cupboard, a wall): that part
/// of its flux would be lost ("boundary bias": Jensen, Realistic Image Synthesis Using Photon Mapping, 2001,
/// section 7.3); between close parallel surfaces it would count more than once. Returns for each photon the factor on
/// its flux that makes up for it: one over its kernel's integral over all surface on which query points would count the
/// photon, estimated by lines along its normal. Between 1/4 and 8; 1 on plain surfaces. On all threads; deterministic.
std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy);

}  // namespace glowworm
