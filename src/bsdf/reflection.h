// The broad reflection of isotropic surfaces in numbers that vector code can evaluate for many points at once, without
// knowing the kinds of BSDF.
#pragma once
#include <cstdint>
#include <optional>

#include "bsdf/bsdf.h"
#include "bsdf/tables.h"
#include "core/rgb.h"

namespace glowworm {

/// How the numbers of an IsotropicReflection are put together. With c the cosine of wi, i of one side with wo, f is
/// black where c <= 0, and else a diffuse part and F D G / (4 c_o c), GGX of one alpha as in bsdf_microfacet.h:
/// - coated:    diffuse A(c), A(c) = T(c) exp(-thickness / c'), with c' refracted by eta, T = curve[0], or where that
///              has no rows 1 - F(c) of a dielectric; F of a dielectric of index eta.
/// - conductor: no diffuse part; F of a conductor of index first + i second.
/// - schlick:   diffuse (1 - second curve[0](c) - second_grazing curve[1](c)); F Schlick's of first at normal and
///              first_grazing at grazing incidence.
enum class ReflectionModel : std::uint8_t { coated, conductor, schlick };

/// f of the broad lobes of a BSDF for one wo.
struct IsotropicReflection {
  float alpha = 0;    ///< GGX; 0: the lobe is not there, or not broad
  RGB diffuse{0.0f};  ///< everything of the diffuse part that does not depend on wi
  RGB first{0.0f}, second{0.0f};
  float first_grazing = 1, second_grazing = 0;
  float eta = 1.5f, thickness = 0;
  bsdf_detail::Curve curve[2];  ///< without rows where there is none
};

/// The model that the numbers of isotropic_reflection() are for; none for the BSDFs that are not of this form
/// (anisotropic, transmitting, of two coats), which evaluate() is for.
std::optional<ReflectionModel> reflection_model(const Bsdf& bsdf);

/// The numbers of a BSDF that has a reflection_model().
/// @param cosine_o cosine of wo, > 0: surfaces of this form are alike on both sides
IsotropicReflection isotropic_reflection(const Bsdf& bsdf, float cosine_o);

}  // namespace glowworm
