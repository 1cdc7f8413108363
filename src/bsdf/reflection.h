// Broad reflection of isotropic surfaces as numbers, which vector code evaluates for many points at once without
// distinguishing the kinds of BSDF.
#pragma once
#include <cstdint>
#include <optional>

#include "bsdf/bsdf.h"
#include "bsdf/tables.h"
#include "core/rgb.h"

namespace glowworm {

/// How the numbers of an IsotropicReflection are combined. With c the cosine of wi, and wi on the same side as wo, f is
/// black if c <= 0. Otherwise it is a diffuse part plus F D G / (4 c_o c), with GGX of one alpha as in microfacet.h:
/// A part of light that meets several facets, multiple M(c), is added.
/// - coated:    diffuse A(c) = (T(c) + through M(c)) exp(-thickness / c'), with c' refracted by eta. T is curve[0] and
/// M
///              curve[1] or, if these have no rows, T is 1 - F(c) and M 0. F is a dielectric's, of index eta.
/// - conductor: no diffuse part; F is a conductor's, of index first + i second. M is 1 - curve[0] - curve[1].
/// - schlick:   diffuse (1 - second curve[0](c) - second_grazing curve[1](c)); F is Schlick's, with `first` at normal
///              and `first_grazing` at grazing incidence. M is 1 - curve[0] - curve[1].
enum class ReflectionModel : std::uint8_t { coated, conductor, schlick };

/// f of the broad lobes of a BSDF for one wo.
struct IsotropicReflection {
  float alpha = 0;     ///< GGX; 0: no lobe, or not a broad one
  RGB diffuse{0.0f};   ///< the factors of the diffuse part that do not depend on wi
  RGB multiple{0.0f};  ///< the same for light that meets several facets
  RGB first{0.0f}, second{0.0f};
  float first_grazing = 1, second_grazing = 0;
  float eta = 1.5f, thickness = 0, through = 0;
  bsdf_detail::Curve curve[2];  ///< without rows if there is none
};

/// The model for the numbers of isotropic_reflection(). Empty for BSDFs without this form (anisotropic, transmitting,
/// two coats), which need evaluate().
std::optional<ReflectionModel> reflection_model(const Bsdf& bsdf);

/// The numbers of a BSDF that has a reflection_model().
/// @param cosine_o cosine of wo, > 0: surfaces of this form are the same on both sides
IsotropicReflection isotropic_reflection(const Bsdf& bsdf, float cosine_o);

}  // namespace glowworm
