// Fresnel reflectances. Internal to the BSDFs. All cosines are on the side of the incoming light, and not negative.
#pragma once
#include <algorithm>
#include <cmath>

#include "bsdf/bsdf.h"
#include "core/rgb.h"

namespace glowworm::bsdf_detail {

/// Reflectance of a dielectric boundary for unpolarised light (Born and Wolf, "Principles of Optics", section 1.5.2).
/// @param eta index of the far side over the index of the near side
inline float fresnel_dielectric(float cos_i, float eta) {
  cos_i = std::clamp(cos_i, 0.0f, 1.0f);
  const float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const float cos_t = std::sqrt(1 - sin2_t);
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/// Reflectance of a conductor of complex index eta + ik, relative to the near side, for unpolarised light (Born and
/// Wolf, section 14.4.1).
inline float fresnel_conductor(float cos_i, float eta, float k) {
  cos_i = std::clamp(cos_i, 0.0f, 1.0f);
  const float cos2 = cos_i * cos_i, sin2 = 1 - cos2;
  const float t0 = eta * eta - k * k - sin2;
  const float a2_plus_b2 = std::sqrt(std::max(0.0f, t0 * t0 + 4 * eta * eta * k * k));
  const float t1 = a2_plus_b2 + cos2;
  const float a = std::sqrt(std::max(0.0f, 0.5f * (a2_plus_b2 + t0)));
  const float t2 = 2 * cos_i * a;
  if (t1 + t2 <= 0) return 1;
  const float perpendicular = (t1 - t2) / (t1 + t2);
  const float t3 = cos2 * a2_plus_b2 + sin2 * sin2;
  const float t4 = t2 * sin2;
  if (t3 + t4 <= 0) return perpendicular;
  const float parallel = perpendicular * (t3 - t4) / (t3 + t4);
  return std::clamp(0.5f * (parallel + perpendicular), 0.0f, 1.0f);
}
inline RGB fresnel_conductor(float cos_i, RGB eta, RGB k) {
  return {fresnel_conductor(cos_i, eta.r, k.r), fresnel_conductor(cos_i, eta.g, k.g),
          fresnel_conductor(cos_i, eta.b, k.b)};
}

/// (1 - cos)^5, the angular term of Schlick's approximation ("An Inexpensive BRDF Model for Physically-based
/// Rendering", 1994, eq. 15).
inline float schlick_term(float cos_i) {
  const float m = std::clamp(1 - cos_i, 0.0f, 1.0f), m2 = m * m;
  return m2 * m2 * m;
}
inline RGB fresnel_schlick(float cos_i, RGB f0, float f90) {
  const float t = schlick_term(cos_i);
  return f0 * (1 - t) + RGB(f90 * t);
}

/// Reflectance of a BSDF's conductor, seen through a medium. Schlick's F0 is not changed.
/// @param medium its index of refraction over the outside's
inline RGB fresnel_of_base(const Bsdf& bsdf, float cos_i, float medium) {
  return bsdf.use_reflectance ? fresnel_schlick(cos_i, bsdf.specular, 1)
                              : fresnel_conductor(cos_i, bsdf.eta / medium, bsdf.k / medium);
}

}  // namespace glowworm::bsdf_detail
