// Light that meets more than one facet of a rough surface. Internal to the BSDFs.
//
// Facets scatter a share 1 - M(w) of the light from w at once. The rest returns as a lobe f = M(wo) M(wi) / (pi mean M)
// (Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course): it is reciprocal, and
// with facets that absorb nothing the surface scatters all light.
#pragma once
#include <algorithm>

#include "bsdf/tables.h"
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm::bsdf_detail {

/// M / mean M, which is 0 where nothing is lost.
inline float over_mean(float lost, float mean_lost) { return mean_lost > 0 ? lost / mean_lost : 0.0f; }

/// Share of the lost light that a metal reflects in the end. Light meets at least two facets, and each further one with
/// the chance mean_lost: the sum of F^2 (1 - L) (F L)^n.
/// @param mean_fresnel Fresnel reflectance averaged over directions, weighted by the cosine
inline RGB multiple_color(RGB mean_fresnel, float mean_lost) {
  const auto channel = [&](float f) { return f < 1 ? f * f * (1 - mean_lost) / (1 - f * mean_lost) : 1.0f; };
  return {channel(mean_fresnel.r), channel(mean_fresnel.g), channel(mean_fresnel.b)};
}

/// Calls f(direction, weight) for points of a mean over directions, weighted by the cosine: Gauss's five cosines, at
/// `azimuths` azimuths of a part of the circle.
template <class F>
void for_mean_directions(int azimuths, float part, F f) {
  constexpr float kCosines[5] = {0.0469101f, 0.2307653f, 0.5f, 0.7692347f, 0.9530899f};
  constexpr float kWeights[5] = {0.1184634f, 0.2393143f, 0.2844444f, 0.2393143f, 0.1184634f};
  for (int a = 0; a < azimuths; ++a) {
    const float azimuth = (a + 0.5f) / azimuths * part, x = std::cos(azimuth), y = std::sin(azimuth);
    for (int i = 0; i < 5; ++i) {
      const float z = kCosines[i], sine = std::sqrt(1 - z * z);
      f(Vec3{sine * x, sine * y, z}, 2 * z * kWeights[i] / azimuths);
    }
  }
}
/// The same for a surface that is alike in all quarters of the circle.
template <class F>
void for_mean_directions(const Microfacet& m, F f) {
  if (m.alpha_x == m.alpha_y) return for_mean_directions(1, 0, f);
  for_mean_directions(4, kPi / 2, f);
}

/// The lobe of facets that reflect by a Fresnel term and transmit nothing.
struct MultipleReflection {
  Curve all;  ///< of MirrorCurve
  float mean_lost = 0;
  RGB color{0.0f};  ///< multiple_color()

  MultipleReflection() = default;
  MultipleReflection(const MirrorCurve& mirror, RGB mean_fresnel)
      : all(mirror.all), mean_lost(std::max(0.0f, 1 - mirror.mean)), color(multiple_color(mean_fresnel, mean_lost)) {}
  /// M, of facets that absorb nothing.
  float lost(Place at) const { return std::max(0.0f, 1 - all(at)); }
  /// f over M(wi).
  RGB factor(Place at) const { return color * (kInversePi * over_mean(lost(at), mean_lost)); }
};

/// The mean of Schlick's Fresnel term over directions, weighted by the cosine.
inline RGB mean_schlick(RGB f0, float f90) { return f0 * (20.0f / 21) + RGB(f90 / 21); }

/// Of the diffuse light from outside that a rough boundary loses, the share of all light that leaves inside: as much as
/// would pass a smooth boundary. By reciprocity, this share over the squared index passes from inside; the smaller loss
/// is taken, so that no side passes more than it loses.
/// @param transmitted share of diffuse light from outside that a smooth boundary transmits
/// @param lost_outside, lost_inside means over directions
inline float multiple_passing(float transmitted, float lost_outside, float lost_inside) {
  return transmitted * std::min(lost_outside, lost_inside);
}

}  // namespace glowworm::bsdf_detail
