// Photons in participating media, in structure-of-arrays form: points where they scatter, and beams between these.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/rgb.h"
#include "core/vec.h"
#include "points/batch.h"

namespace glowworm {

/// Photons that scatter in a medium. Index i is one photon. Radiance along a segment is the sum of K2 T p flux, with a
/// kernel K2 (m^-2), the transmittance T to the photon and the phase function p (sr^-1): Jarosz, Zwicker and Jensen,
/// "The Beam Radiance Estimate for Volumetric Photon Mapping", 2008.
struct VolumePhotons : Batch<VolumePhotons> {
  LargeVector<Vec3> position;         ///< metres
  LargeVector<Vec3> direction;        ///< unit, of travel before the photon scatters
  LargeVector<RGB> flux;              ///< W, that is scattered: of the photon that arrives, times sigma_s / sigma_t
  LargeVector<std::uint32_t> medium;  ///< index; photons count only in segments of the same medium
  LargeVector<std::uint32_t> source;  ///< light source, counted as in Scene::light_power()

  template <class Any>
  static auto arrays(Any& batch) {
    return std::tie(batch.position, batch.direction, batch.flux, batch.medium, batch.source);
  }
  void push_back(Vec3 p, Vec3 d, RGB f, std::uint32_t m, std::uint32_t s) { add(p, d, f, m, s); }
};

/// Most planes that bound a kernel.
inline constexpr std::size_t kWallsOfKernel = 2;

/// Where the flux of photons that scatter is blurred: over the disc across each segment. Index i is one photon.
struct PhotonKernels : Batch<PhotonKernels> {
  LargeVector<float> radii;  ///< metres
  /// Planes at which the medium ends, as in a corner or a gap: the unit vector from the photon towards each, over the
  /// distance (m^-1). Segments behind a plane do not meet the photon, and the part of each disc there is folded back
  /// over the plane, as for densities on a half-line (Silverman, "Density Estimation for Statistics and Data Analysis",
  /// 1986, section 2.10). 0: none; the first is 0 only if both are.
  LargeVector<std::array<Vec3, kWallsOfKernel>> walls;

  template <class Any>
  static auto arrays(Any& batch) {
    return std::tie(batch.radii, batch.walls);
  }
};

/// Short photon beams: straight parts of photons' paths, from where a photon enters a medium or scatters to where it
/// next scatters, is absorbed, or leaves the medium. Index i is one beam. A photon travels as far as the medium lets
/// it, so no transmittance is applied along a beam, and its flux is the same everywhere on it. In a medium that
/// absorbs some colours more than others, a path whose flux changes on its way takes several beams, one behind the
/// other. Radiance along a segment is the sum of K1 / sin(theta) T sigma_s p flux: Jarosz, Nowrouzezahrai, Sadeghi and
/// Jensen, "A Comprehensive Theory of Volumetric Radiance Estimation", 2011.
struct VolumeBeams : Batch<VolumeBeams> {
  LargeVector<Vec3> origin;           ///< metres
  LargeVector<Vec3> direction;        ///< unit, of travel
  LargeVector<float> length;          ///< metres, finite
  LargeVector<RGB> flux;              ///< W, of the photon on the way
  LargeVector<std::uint32_t> medium;  ///< index; beams count only in segments of the same medium
  LargeVector<std::uint32_t> source;  ///< light source, counted as in Scene::light_power()

  template <class Any>
  static auto arrays(Any& batch) {
    return std::tie(batch.origin, batch.direction, batch.length, batch.flux, batch.medium, batch.source);
  }
  void push_back(Vec3 o, Vec3 d, float l, RGB f, std::uint32_t m, std::uint32_t s) { add(o, d, l, f, m, s); }
};

}  // namespace glowworm
