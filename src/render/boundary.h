// Boundary correction for kernels that extend over the edge of a surface.
#pragma once
#include <string>
#include <vector>

#include "core/shared_work.h"
#include "density/engine.h"
#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// A photon's kernel is normalised over a whole disc. At an edge or on a small surface, part of the disc is empty or
/// cannot contain query points (a floor continues beneath a carpet, a cupboard, a wall), and that part of the flux is
/// lost ("boundary bias": Jensen, Realistic Image Synthesis Using Photon Mapping, 2001, section 7.3); between close
/// parallel surfaces flux counts more than once. Returns for each photon the factor on its flux that corrects this: one
/// over the kernel's integral over all surface where query points count the photon, estimated with lines along its
/// normal. Between 1/4 and 8; 1 on plain surfaces. Uses all threads; deterministic.
/// @param shared processes that divide the work; null: none @param name of the work, for SharedWork::divide()
std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy,
                                    SharedWork* shared = nullptr, const std::string& name = "");

}  // namespace glowworm
