// Fate of the photons, by light.
#pragma once
#include <vector>

#include "glowworm/statistics.h"
#include "photon/photon_tracer.h"
#include "scene/scene.h"

namespace glowworm {

using api::LightPhotons;

/// Sums over the sources of each name, in the order of the scene; "others" sums up names beyond the hundredth.
std::vector<LightPhotons> photons_by_light(const Scene& scene, const PhotonPass& pass);

/// Adds the photons of a further pass of the same scene to `sum`, which may be empty.
void add(std::vector<LightPhotons>& sum, const std::vector<LightPhotons>& pass);

}  // namespace glowworm
