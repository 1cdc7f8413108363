// Directional albedos of GGX surfaces, from tables that are integrated on first use. Internal to the BSDFs.
//
// Tables of reflection and transmission are for light that meets one facet. What such a surface loses is light that
// meets more: multiple.h gives it back.
//
// The albedo of a brushed surface, of two alphas, also depends on the azimuth. Its tables have a row for each of a few
// projected alphas (Heitz 2014, eq. 80), in which it is nearly linear.
#pragma once
#include <algorithm>
#include <cmath>

#include "bsdf/microfacet.h"
#include "core/vec.h"

namespace glowworm::bsdf_detail {

inline constexpr int kCosineNodes = 32;
inline constexpr int kAlongNodes = 5;

/// A direction as tables take it.
struct Place {
  float cosine;
  float along = 0;  ///< of brushed surfaces: 0 across the rougher axis, 1 along it
};
/// The place of a direction above a surface.
inline Place place_of(const Microfacet& m, Vec3 w) {
  if (m.alpha_x == m.alpha_y) return {w.z};
  const float x = m.alpha_x * w.x, y = m.alpha_y * w.y, sin2 = w.x * w.x + w.y * w.y;
  const float least = std::min(m.alpha_x, m.alpha_y), most = std::max(m.alpha_x, m.alpha_y);
  const float projected = sin2 > 0 ? std::sqrt((x * x + y * y) / sin2) : most;
  return {w.z, std::clamp((projected - least) / (most - least), 0.0f, 1.0f)};
}

/// A function of the direction for one surface: a weighted sum of rows of tables.
struct Curve {
  static constexpr int kMost = 8;
  const float* rows[kMost];
  float weights[kMost];
  int count = 0;         ///< even
  bool brushed = false;  ///< each row is followed by the rows of the other nodes of Place::along

  float operator()(Place at) const {
    if (!brushed) return read(at.cosine, 0);
    const float x = at.along * (kAlongNodes - 1);
    const int i = std::min(static_cast<int>(x), kAlongNodes - 2);
    const float low = read(at.cosine, i * kCosineNodes), high = read(at.cosine, (i + 1) * kCosineNodes);
    return low + (high - low) * (x - i);
  }

 private:
  float read(float cosine, int offset) const {
    // Nodes are the squares of equal steps: denser towards grazing angles, where the functions are more curved.
    const float x = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kCosineNodes - 1);
    const int i = std::min(static_cast<int>(x), kCosineNodes - 2);
    const float t = (cosine * (kCosineNodes - 1) * (kCosineNodes - 1) - i * i) / (2 * i + 1);
    float low = 0, high = 0;
    // Rows come in pairs.
    for (int row = 0; row < count; row += 2) {
      const float *a = rows[row] + offset + i, *b = rows[row + 1] + offset + i;
      low += weights[row] * a[0] + weights[row + 1] * b[0];
      high += weights[row] * a[1] + weights[row + 1] * b[1];
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
            ///< back inside; light from outside, by its direction there
  // Facets with Schlick's Fresnel term, of the angle outside, lose schlick_lost + f0 * schlick_lost_f0 + f90 *
  // schlick_lost_f90.
  schlick_lost_outside,
  schlick_lost_f0_outside,
  schlick_lost_f90_outside,
  schlick_lost_inside,
  schlick_lost_f0_inside,
  schlick_lost_f90_inside,
  // Light that they pass from inside is schlick_passed - f0 * schlick_passed_f0 - f90 * schlick_passed_f90, and the
  // same with "_out" weighted by Schlick's term of the direction in which it leaves.
  schlick_passed,
  schlick_passed_f0,
  schlick_passed_f90,
  schlick_passed_out,
  schlick_passed_f0_out,
  schlick_passed_f90_out,
  count
};
/// The functions of one surface.
class BoundaryTable {
 public:
  /// @param eta index of refraction of the denser side over the other's, >= 1 (clamped to 3)
  BoundaryTable(const Microfacet& m, float eta);
  Curve curve(Boundary what) const {
    Curve out;
    out.count = count_;
    out.brushed = brushed_;
    for (int i = 0; i < count_; ++i) {
      out.rows[i] = rows_[i] + static_cast<std::size_t>(what) * row_size_;
      out.weights[i] = weights_[i];
    }
    return out;
  }
  /// Mean over directions, weighted by the cosine.
  float mean(Boundary what) const {
    float sum = 0;
    for (int i = 0; i < count_; ++i) sum += weights_[i] * means_[i][static_cast<std::size_t>(what)];
    return sum;
  }

 private:
  const float *rows_[Curve::kMost], *means_[Curve::kMost];  // by node; rows by function
  float weights_[Curve::kMost];
  int count_ = 0;
  bool brushed_;
  std::size_t row_size_ = 0;
};

/// Share of diffuse light from outside that a smooth boundary transmits.
float smooth_transmittance(float eta);

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
/// @param m both alphas 0: smooth
SchlickCurves schlick_curves(const Microfacet& m);

/// Directional albedo of facets that reflect all light, scale + bias, and its mean.
struct MirrorCurve {
  Curve all;
  float mean = 0;
};
MirrorCurve mirror_curve(const Microfacet& m);

/// Directional albedo of a GGX reflection with any smooth Fresnel term, as the sum of curve[i] times the term at
/// kFresnelCosines[i]: the term is interpolated by a polynomial.
inline constexpr int kFresnelNodes = 6;
extern const float kFresnelCosines[kFresnelNodes];
struct FresnelCurves {
  Curve curve[kFresnelNodes];
};
FresnelCurves fresnel_curves(const Microfacet& m);

}  // namespace glowworm::bsdf_detail
