// Photons of a scene as arrays, and their sums at points.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "glowworm/density.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Photons on surfaces: arrays of one length, which belong to this object. Copies share them.
class Photons {
 public:
  std::size_t size() const;
  std::span<const Vec3> positions() const;   ///< metres
  std::span<const Vec3> directions() const;  ///< unit, back along the way the photon came
  std::span<const Rgb> flux() const;         ///< W, divided by the number of paths already
  std::span<const Vec3> normals() const;     ///< unit, on the side where the photon arrived
  /// Light paths that were emitted for them.
  std::uint64_t emitted() const;
  /// Positions, flux and normals for a DensityIndex.
  PhotonArrays arrays() const { return {positions(), flux(), normals()}; }

  struct Implementation;  ///< of the library
  /// For the library itself.
  explicit Photons(std::shared_ptr<const Implementation> implementation);

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// Which photons are wanted.
struct PhotonOptions {
  std::uint64_t photons = 500'000;  ///< at least so many are stored, where the lights reach surfaces
  std::uint32_t seed = 0;
  bool caustic = false;  ///< those alone whose bounces were all sharp, and at least one
};

/// Traces photons from all lights of the scene, on all threads; the same for any number of threads.
Photons trace_photons(const Scene& scene, const PhotonOptions& options = {});

}  // namespace glowworm::api
