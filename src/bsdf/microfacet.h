// The GGX (Trowbridge-Reitz) distribution of microfacet normals. Internal to the BSDFs. Directions and normals are in
// shading coordinates; w is on the side z > 0 unless stated otherwise.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/vec.h"

namespace glowworm::bsdf_detail {

inline Vec3 reflect(Vec3 w, Vec3 normal) { return normal * (2 * dot(w, normal)) - w; }

/// The refracted direction on the far side; false for total reflection.
/// @param w on the side of `normal`; @param eta index of refraction of the far side over the near side's
inline bool refract(Vec3 w, Vec3 normal, float eta, Vec3& refracted) {
  const float cos_i = dot(w, normal);
  const float sin2_t = std::max(0.0f, 1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return false;
  const float cos_t = std::sqrt(1 - sin2_t);
  refracted = normalize(w * (-1 / eta) + normal * (cos_i / eta - cos_t));
  return true;
}

/// GGX with roughness alpha_x along x and alpha_y along y, and Smith's shadowing, height-correlated (Heitz,
/// "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014).
struct Microfacet {
  float alpha_x, alpha_y;

  /// Density of microfacet area by normal, per steradian (Heitz 2014, eq. 85).
  float distribution(Vec3 h) const {
    const float x = h.x / alpha_x, y = h.y / alpha_y;
    const float e = x * x + y * y + h.z * h.z;
    return 1 / (kPi * alpha_x * alpha_y * e * e);
  }
  /// Smith's Lambda (Heitz 2014, eq. 72 and 80); of either side.
  float lambda(Vec3 w) const {
    const float x = alpha_x * w.x, y = alpha_y * w.y;
    return 0.5f * (std::sqrt(1 + (x * x + y * y) / (w.z * w.z)) - 1);
  }
  float masking(Vec3 w) const { return 1 / (1 + lambda(w)); }
  float masking_shadowing(Vec3 wo, Vec3 wi) const { return 1 / (1 + lambda(wo) + lambda(wi)); }

  /// Density of the normals seen from w (Heitz 2014, eq. 16), per steradian of the normal.
  float visible_normal_pdf(Vec3 w, Vec3 h) const {
    return masking(w) * std::max(0.0f, dot(w, h)) * distribution(h) / w.z;
  }
  /// A normal with that density (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
  Vec3 sample_visible_normal(Vec3 w, Vec2 u) const {
    const Vec3 stretched = normalize({alpha_x * w.x, alpha_y * w.y, w.z});
    const float phi = 2 * kPi * u.x;
    const float z = (1 - u.y) * (1 + stretched.z) - stretched.z;
    const float r = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f));
    const Vec3 h = Vec3{r * std::cos(phi), r * std::sin(phi), z} + stretched;
    // A minimum z keeps the normal off the horizon, where its length could round to zero.
    return normalize({alpha_x * h.x, alpha_y * h.y, std::max(1e-6f, h.z)});
  }
};

}  // namespace glowworm::bsdf_detail
