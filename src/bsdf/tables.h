// Directional albedos of GGX surfaces, from tables that are integrated on first use. Internal to the BSDFs.
//
// Tables of reflection and transmission are for light that meets one facet. What such a surface loses is light that
// meets more: multiple.h gives it back.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/vec.h"

namespace glowworm::bsdf_detail {

inline constexpr int kCosineNodes = 32;

/// A function of the cosine in [0, 1] at one roughness and index: a weighted sum of four rows of a table.
struct Curve {
  const float* rows[4] = {};
  float weights[4] = {};

  float operator()(float cosine) const {
    // Nodes are the squares of equal steps: denser towards grazing angles, where the functions are more curved.
    const float x = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kCosineNodes - 1);
    const int i = std::min(static_cast<int>(x), kCosineNodes - 2);
    const float t = (cosine * (kCosineNodes - 1) * (kCosineNodes - 1) - i * i) / (2 * i + 1);
    float low = 0, high = 0;
    for (int row = 0; row < 4; ++row) {
      low += weights[row] * rows[row][i];
      high += weights[row] * rows[row][i + 1];
    }
    return low + (high - low) * t;
  }
};

/// Fate of light at the boundary of a rough dielectric, by direction; shares of its flux. "Outside" is for light from
/// the side of lower index.
enum class Boundary {
  reflect_outside,
  transmit_outside,
  lost_outside,  ///< the rest: meets a second facet
  reflect_inside,
  transmit_inside,
  lost_inside,
  trapped,  ///< the share of light that an ideal GGX mirror under a SMOOTH boundary reflects and the boundary reflects
            ///< back inside; light from outside, by its cosine there
  // Facets with Schlick's Fresnel term, of the angle outside, lose schlick_lost + f0 * schlick_lost_f0 + f90 *
  // schlick_lost_f90.
  schlick_lost_outside,
  schlick_lost_f0_outside,
  schlick_lost_f90_outside,
  schlick_lost_inside,
  schlick_lost_f0_inside,
  schlick_lost_f90_inside,
};
/// @param eta index of the denser side over that of the other, >= 1 (clamped to 3)
Curve boundary_curve(Boundary what, float alpha, float eta);

/// Mean of boundary_curve() over directions, weighted by the cosine.
float boundary_mean(Boundary what, float alpha, float eta);

/// exp(-2 depth / cos), averaged over the diffuse light that a smooth boundary reflects inwards: the factor of an
/// absorbing coat of this optical depth on light that goes to the boundary and back.
float internal_transmittance(float eta, float depth);

/// Directional albedo of a GGX reflection with Schlick's Fresnel term, f0 * scale + f90 * bias (Karis, "Real Shading in
/// Unreal Engine 4", 2013), and means weighted by the cosine. `scale_out` and `bias_out` are the same for reflected
/// light weighted by Schlick's term of the direction in which it leaves.
struct SchlickCurves {
  Curve scale, bias, scale_out, bias_out;
  float mean_scale = 0, mean_bias = 0;
};
SchlickCurves schlick_curves(float alpha);

}  // namespace glowworm::bsdf_detail
