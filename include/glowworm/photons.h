// Photons of a scene as arrays, and their sums at points.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "glowworm/density.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Photons on surfaces, as arrays of one length. This object owns them; copies share them.
class Photons {
 public:
  std::size_t size() const;
  std::span<const Vec3> positions() const;   ///< metres
  std::span<const Vec3> directions() const;  ///< unit, back along the photon's path
  std::span<const Rgb> flux() const;         ///< W, already divided by the number of paths
  std::span<const Vec3> normals() const;     ///< unit, on the side where the photon arrived
  /// Number of emitted light paths.
  std::uint64_t emitted() const;
  /// Positions, flux and normals for a DensityIndex.
  PhotonArrays arrays() const { return {positions(), flux(), normals()}; }

  struct Implementation;  ///< private
  /// Private.
  explicit Photons(std::shared_ptr<const Implementation> implementation);

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// Which photons to trace.
struct PhotonOptions {
  std::uint64_t photons = 500'000;  ///< the least number to store, if the lights reach surfaces
  std::uint32_t seed = 0;
  bool caustic = false;  ///< only photons with at least one bounce and only sharp bounces
};

/// Traces photons from all lights of the scene, on all threads. The result does not depend on the number of threads.
Photons trace_photons(const Scene& scene, const PhotonOptions& options = {});

}  // namespace glowworm::api
