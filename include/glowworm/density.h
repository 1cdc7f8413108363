// Density estimation without a scene or a ray tracer: sums over photons around points. Link glowworm::density.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "glowworm/error.h"
#include "glowworm/types.h"

namespace glowworm::api {

/// Kernels K(d) over the unit disc, where d is distance / radius. Each integrates to 1 over the disc.
enum class Kernel : std::uint8_t {
  box,           ///< 1 / pi
  cone,          ///< 3 / pi (1 - d)
  epanechnikov,  ///< 2 / pi (1 - d^2)
  gaussian,      ///< exp(-d^2 / (2 s^2)) with s = 1/3, cut at d = 1 and normalised
};
/// Names of the kernels, in the order of Kernel: "box" and so on.
std::vector<std::string> kernel_names();

/// Density engines: ways to look photons up. Given the same radii they agree to rounding.
enum class Engine : std::uint8_t {
  automatic,  ///< blocked, the fastest
  blocked,    ///< blocks of photons in a tree of boxes
  forward,    ///< packets of points walk a kd-tree of photons (Singh and Faloutsos 2007)
  reverse,    ///< photons search a kd-tree of the points of a call (Havran, Herzog, Seidel 2005)
  knn,        ///< each point searches for its k nearest photons; it takes no radii, so not for a DensityIndex
  brute,      ///< every pair, in double precision; for tests
};
/// Names of the engines, in the order of Engine: "auto", "blocked" and so on.
std::vector<std::string> engine_names();

/// Photons as arrays of one length n. They are copied.
struct PhotonArrays {
  std::span<const Vec3> position;  ///< n, metres
  std::span<const Rgb> flux;       ///< n, W, or any other quantity to sum
  /// n, unit, on the side where the photon arrived. Empty: every photon counts.
  std::span<const Vec3> normal;
};

/// Returns one radius in metres for each photon, so that about k photons lie within it (Havran, Herzog, Seidel 2005,
/// section 6.1). Uses all threads; the result does not depend on their number. Throws Error for k = 0 and
/// positions that are not finite.
std::vector<float> photon_radii(std::span<const Vec3> position, std::uint32_t k = 50);

/// An index over photons. It serves any number of batches of points. The constructors throw Error if lengths differ,
/// for numbers that are not finite, radii that are not above 0, normals that are not unit, values that are no
/// Kernel or Engine, and Engine::knn.
class DensityIndex {
 public:
  /// One radius for all photons (Singh and Faloutsos 2007, equation 2).
  /// @param radius metres, > 0
  DensityIndex(const PhotonArrays& photons, float radius, Kernel kernel = Kernel::epanechnikov,
               Engine engine = Engine::automatic);
  /// A radius for each photon (Havran, Herzog, Seidel 2005, equation 3).
  /// @param radii n, metres, > 0
  DensityIndex(const PhotonArrays& photons, std::span<const float> radii, Kernel kernel = Kernel::epanechnikov,
               Engine engine = Engine::automatic);
  ~DensityIndex();
  DensityIndex(DensityIndex&&) noexcept;
  DensityIndex& operator=(DensityIndex&&) noexcept;

  /// Returns for each point x the sum over photons j with |x - y_j| < h_j of K(|x - y_j| / h_j) / h_j^2 times flux_j.
  /// With flux in W this is the irradiance in W m^-2. Uses all threads; the result is the same, bit for bit, for any
  /// number of them. Large batches cost less per point. Several threads may call it at once.
  /// @param position m points, metres
  /// @param normal   m unit normals if the photons have normals: a photon counts if its normal is less than 45 degrees
  /// away. Empty if the photons have none.
  /// Throws Error if the lengths differ, for positions that are not finite, and for normals that are not unit.
  std::vector<Rgb> sum(std::span<const Vec3> position, std::span<const Vec3> normal = {}) const;
  /// As above, into memory of the caller. Throws Error if `out` has another length than `position`, too.
  void sum(std::span<const Vec3> position, std::span<const Vec3> normal, std::span<Rgb> out) const;

  std::size_t photon_count() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Sets the number of threads that the library uses, 1 to 1024; 0: one for each hardware thread. Throws Error for other
/// numbers.
void set_threads(int threads);

}  // namespace glowworm::api
