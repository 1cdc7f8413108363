// The bounces of light paths on surfaces.
#pragma once
#include "photon/light_paths.h"
#include "scene/scene.h"

namespace glowworm {

/// What becomes of a path at a surface.
struct PhotonBounce {
  bool leaves_photon = false, goes_on = false;
  Vec3 position, normal, back;  ///< of the photon: metres; unit, where it arrived; towards its origin
  RGB photon_flux{0.0f};        ///< W, with the arrival_factor() of the shading normal
  Ray next;                     ///< of the path that goes on
  RGB flux{0.0f};               ///< of it, W
  std::uint8_t bits = 0;        ///< of the bounce, for with_bounce()
};

/// Scatters a path at its hit, which must be one, and plays Russian roulette. Takes two pairs of the path's random
/// numbers. @param bounce surfaces before
PhotonBounce scatter_photon(const Scene& scene, const PhotonPassSettings& pass, LightPath& path, const Hit& hit,
                            int bounce);

}  // namespace glowworm
