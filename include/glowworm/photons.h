// Photons of a scene as arrays, and their sums at points.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "glowworm/density.h"
#include "glowworm/interrupt.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Photons on surfaces of all materials, black and transparent ones, too, as arrays of one length. This object owns
/// them; copies share them.
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
  /// The least number to store. Tracing ends without it after 200 light paths for each, or after one for each if no
  /// photon is stored by then.
  std::uint64_t photons = 500'000;
  std::uint32_t seed = 0;
  /// Only photons with at least one bounce and only sharp ones. To pass straight through a pane is not a bounce.
  bool caustic = false;
  const Interrupt* interrupt = nullptr;  ///< if requested, the function throws Cancelled
};

/// Traces photons from all lights of the scene, on all threads. The result does not depend on the number of threads.
Photons trace_photons(const Scene& scene, const PhotonOptions& options = {});

/// Settings of a PhotonMap.
struct PhotonMapOptions {
  std::uint64_t photons = 500'000;  ///< the least number to store, if the lights reach surfaces
  std::uint32_t seed = 0;
  std::uint32_t nearest = 50;  ///< photons that an estimate should catch; they set the radii
  Kernel kernel = Kernel::epanechnikov;
  Engine engine = Engine::automatic;
  /// Correct estimates at points where a kernel extends over the edge of a surface.
  bool boundary_correction = true;
  const Interrupt* interrupt = nullptr;  ///< if requested, the constructor throws Cancelled
};

/// The photon map of all light of a scene. Copies share it; several threads may use it.
class PhotonMap {
 public:
  /// Traces the photons and indexes them, on all threads. The result does not depend on their number.
  explicit PhotonMap(const Scene& scene, const PhotonMapOptions& options = {});

  /// Irradiance at points, W m^-2, direct and indirect: the density of the photons around each. Points lie on surfaces
  /// of the scene; a point in space has no photons around it. Several threads may call it at once.
  /// @param position m points, metres
  /// @param normal   m unit normals, on the side whose light is wanted
  /// Throws Error for arrays of different lengths, numbers that are not finite, and normals that are not unit.
  std::vector<Rgb> irradiance(std::span<const Vec3> position, std::span<const Vec3> normal) const;
  /// Radiance, W sr^-1 m^-2, that the surface at each point reflects along its normal, by its material. Emitted light
  /// and mirror images are not part of it. Throws as irradiance(), and for a point that is not on a surface.
  std::vector<Rgb> radiance(std::span<const Vec3> position, std::span<const Vec3> normal) const;

  /// Photons in the map.
  std::size_t size() const;
  /// Number of emitted light paths.
  std::uint64_t emitted() const;

 private:
  struct Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

}  // namespace glowworm::api
