// Layers of glTF's materials that are not plain facets: sheen of cloth, and thin films. Internal to the BSDFs.
#pragma once
#include "bsdf/tables.h"
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm::bsdf_detail {

/// Sheen of colour 1: the Charlie distribution with its shadowing term (Estevez and Kulla, "Production Friendly
/// Microfacet Sheen BRDF", SIGGRAPH 2017 course; KHR_materials_sheen), divided by its albedo if that is above 1.
class Sheen {
 public:
  Sheen() = default;
  /// @param alpha the square of glTF's sheenRoughness, at least 0.01
  explicit Sheen(float alpha);
  /// f in sr^-1; both directions above.
  float evaluate(Vec3 wo, Vec3 wi) const;
  /// Directional albedo, at most 1.
  float albedo(float cosine) const;
  /// The same for reflected light weighted by Schlick's term of the direction in which it leaves.
  float albedo_out(float cosine) const;

 private:
  float alpha_ = 0;
  const float* rows_[2] = {};      // of the table of albedos
  const float* rows_out_[2] = {};  // of albedo_out()
  float mix_ = 0;
};

/// Reflectance of a thin film between air and a base, for linear RGB (Belcour and Barla, "A Practical Extension to
/// Microfacet Theory for the Modeling of Varying Iridescence", SIGGRAPH 2017; KHR_materials_iridescence): Airy's sum
/// with Fresnel terms of unpolarised light, Schlick's for the base, with two orders of interference.
/// @param cosine on the side of the air; @param eta index of the film; @param thickness nm, > 0
/// @param base reflectance of the base at normal incidence
RGB film_reflectance(float cosine, float eta, float thickness, RGB base);

}  // namespace glowworm::bsdf_detail
