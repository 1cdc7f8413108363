// What the kinds of BSDF have in common: each is a sum of components, each of one lobe and one way of sampling.
// Internal to the BSDFs. Here wo.z > 0 always: bsdf.cc mirrors both directions for a viewer below the surface.
#pragma once
#include "scene/bsdf.h"
#include "scene/bsdf_microfacet.h"

namespace glowworm::bsdf_detail {

/// How a component's directions are sampled.
enum class Shape : std::uint8_t {
  cosine_reflection,    ///< cos / pi above
  cosine_transmission,  ///< cos / pi below
  rough_reflection,     ///< reflection at a visible microfacet normal
  rough_dielectric,     ///< reflection or refraction at a visible normal, by the Fresnel reflectance there
  rough_refraction,     ///< refraction at a visible normal
  rough_straight,       ///< rough_reflection mirrored to the other side
  mirror,               ///< delta
  refraction,           ///< delta
  straight,             ///< delta: onwards without bending
};
inline bool is_delta(Shape shape) { return shape >= Shape::mirror; }

struct Component {
  Shape shape = Shape::cosine_reflection;
  Lobes lobe = 0;                   ///< one bit
  Microfacet microfacet{0, 0};      ///< rough shapes
  float eta = 1;                    ///< bending shapes: index of the side below over that of the side of wo
  float reflect = 1, transmit = 1;  ///< rough_dielectric: mean tints
  RGB albedo;             ///< share of the light scattered, exact for deltas (radiance of `refraction`: unscaled)
  float probability = 0;  ///< of choosing this component among those asked for
};

/// The components of a BSDF for one wo.
struct Components {
  static constexpr int kMost = 4;
  Component list[kMost];
  int count = 0;
  void add(const Component& component) {
    if (max_component(component.albedo) > 0) list[count++] = component;
  }
};

/// The lobe of a GGX reflection or refraction.
inline Lobes lobe_of_alpha(float alpha_x, float alpha_y) {
  return alpha_x * alpha_y < kSharpAlpha * kSharpAlpha ? kSharp : kGlossy;
}
inline bool is_smooth(float alpha_x, float alpha_y) { return std::max(alpha_x, alpha_y) < kSmoothAlpha; }
/// A microfacet distribution of alphas that are not both smooth.
inline Microfacet rough(float alpha_x, float alpha_y) { return {std::max(alpha_x, 1e-4f), std::max(alpha_y, 1e-4f)}; }

/// The half vector of reflection from wi to wo, on the side of wo; zero where there is none.
inline Vec3 reflection_half(Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float l2 = length_squared(sum);
  return l2 > 0 ? sum * (1 / std::sqrt(l2)) : Vec3{0, 0, 0};
}
/// The half vector of refraction, wi below (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
/// 2007, eq. 16), turned to z > 0; zero where no facet can refract the one into the other.
inline Vec3 refraction_half(Vec3 wo, Vec3 wi, float eta) {
  Vec3 h = wo + wi * eta;
  const float l2 = length_squared(h);
  if (!(l2 > 0)) return {0, 0, 0};
  h = h * (1 / std::sqrt(l2));
  if (h.z < 0) h = -h;
  return dot(wo, h) > 0 && dot(wi, h) < 0 ? h : Vec3{0, 0, 0};
}

/// D G / (4 cos cos): reflection without Fresnel (Walter et al. 2007, eq. 20), sr^-1; both directions above.
inline float microfacet_reflection(const Microfacet& m, Vec3 wo, Vec3 wi, Vec3 h) {
  return m.distribution(h) * m.masking_shadowing(wo, wi) / (4 * wo.z * wi.z);
}
/// Radiance refracted, without Fresnel (Walter et al. 2007, eq. 21), sr^-1; wi below, h by refraction_half().
inline float microfacet_refraction(const Microfacet& m, Vec3 wo, Vec3 wi, Vec3 h, float eta) {
  const float o = dot(wo, h), i = dot(wi, h), denominator = eta * i + o;
  if (denominator == 0) return 0;
  return m.distribution(h) * m.masking_shadowing(wo, wi) * std::abs(o * i) / (wo.z * -wi.z * denominator * denominator);
}

/// Density per steradian of a component's directions; deltas: 0.
float component_pdf(const Component& component, Vec3 wo, Vec3 wi);
/// A direction of a component; false where the sample is lost (it left the side it belongs to).
/// @param u_side in [0, 1), chooses between reflection and refraction
bool component_sample(const Component& component, Vec3 wo, float u_side, Vec2 u, Vec3& wi);

// One pair of functions for each kind. `inside`: the viewer is where z < 0 was.
RGB evaluate_lambertian(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes);
void lambertian_components(const Bsdf& bsdf, Components& out);
RGB evaluate_conductor(const Bsdf& bsdf, Vec3 wo, Vec3 wi);
void conductor_components(const Bsdf& bsdf, Vec3 wo, Components& out);
RGB evaluate_dielectric(const Bsdf& bsdf, bool inside, Vec3 wo, Vec3 wi);
void dielectric_components(const Bsdf& bsdf, bool inside, Vec3 wo, Components& out);
void thin_dielectric_components(const Bsdf& bsdf, Vec3 wo, Components& out);

}  // namespace glowworm::bsdf_detail
