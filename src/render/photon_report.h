// Fate of the photons, by light.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "photon/photon_tracer.h"
#include "scene/scene.h"

namespace glowworm {

/// Photons of the light sources of one name.
struct LightPhotons {
  std::string name;
  std::uint64_t sources = 0;  ///< light sources of this name: the triangles of a lamp, for example
  std::uint64_t emitted = 0;  ///< paths
  std::uint64_t stored = 0;   ///< photons of the global map
  std::uint64_t used = 0;     ///< those at places that the image needs; the others are wasted
  std::uint64_t wasted() const { return stored - used; }
};

/// Sums over the sources of each name, in the order of the scene; "others" sums up names beyond the hundredth.
std::vector<LightPhotons> photons_by_light(const Scene& scene, const PhotonPass& pass);

/// Adds the photons of a further pass of the same scene to `sum`, which may be empty.
void add(std::vector<LightPhotons>& sum, const std::vector<LightPhotons>& pass);

}  // namespace glowworm
