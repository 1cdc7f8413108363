// The media in which photons start.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/light_sampling.h"
#include "transport/medium.h"

namespace glowworm {

/// The media around light sources.
class StartMedia {
 public:
  explicit StartMedia(const Tracer& tracer);
  /// Around a photon that leaves a source, counted as in Scene::light_power(), in a direction.
  PathMedium of(const Scene& scene, std::uint32_t source, Vec3 direction) const {
    if (source == kNone) return {};
    if (source >= sides_.size()) return around_;
    const std::vector<std::uint32_t>& lamps = scene.emissive_triangles();
    return source < lamps.size() ? sides_[source].towards(direction, scene.diffuse_triangle(lamps[source]).normal)
                                 : sides_[source].front;
  }

 private:
  std::vector<MediumSides> sides_;  // of emissive triangles, lights and media; none in scenes without media
  PathMedium around_;
};

/// Whether a photon that a medium emits starts where surfaces leave this medium out.
bool is_outside_of_medium(const Tracer& tracer, const EmittedPhoton& photon);

}  // namespace glowworm
