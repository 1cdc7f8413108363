// Common parts of all BSDFs: each is a sum of components, with one lobe and one sampling method each. Internal to the
// BSDFs. Here wo.z > 0 always: bsdf.cc mirrors both directions for a viewer below the surface.
#pragma once
#include <algorithm>
#include <span>

#include "bsdf/bsdf.h"
#include "bsdf/microfacet.h"
#include "bsdf/reflection.h"
#include "core/frame.h"

namespace glowworm::bsdf_detail {

/// Arguments of an evaluation. Only dielectrics distinguish the sides, by `inside`.
struct View {
  const Bsdf& bsdf;
  bool inside;  ///< the viewer is below
  Vec3 wo;      ///< above
  Lobes lobes;  ///< the given lobes
};

/// out[i] = f(wi[i]), with wi mirrored as wo was; black in the plane of the surface.
template <class F>
void for_each_direction(const View& view, std::span<const Vec3> wi, std::span<RGB> out, F f) {
  const float side = view.inside ? -1.0f : 1.0f;
  for (std::size_t i = 0; i < wi.size(); ++i)
    out[i] = wi[i].z != 0 ? f(Vec3{wi[i].x, wi[i].y, side * wi[i].z}) : RGB(0.0f);
}
inline void fill_black(std::span<RGB> out) { std::fill(out.begin(), out.end(), RGB(0.0f)); }

/// How a component's directions are sampled.
enum class Shape : std::uint8_t {
  cosine_reflection,      ///< cos / pi above
  cosine_transmission,    ///< cos / pi below
  uniform_reflection,     ///< 1 / (2 pi) above
  rough_reflection,       ///< reflection at a visible microfacet normal
  rough_dielectric,       ///< reflection or refraction at a visible normal, by the Fresnel reflectance there
  rough_refraction,       ///< refraction at a visible normal
  coated_reflection,      ///< rough_reflection under a smooth boundary: refracted in and out
  rough_straight,         ///< rough_reflection mirrored to the other side
  measured_reflection,    ///< by a matrix, above
  measured_transmission,  ///< by a matrix, below
  mirror,                 ///< delta
  refraction,             ///< delta
  straight,               ///< delta: onwards without bending
};
inline bool is_delta(Shape shape) { return shape >= Shape::mirror; }

struct Component {
  Shape shape = Shape::cosine_reflection;
  Lobes lobe = 0;                   ///< one bit
  bool inside = false;              ///< measured shapes: wo is behind the surface
  Microfacet microfacet{0, 0};      ///< rough shapes
  float eta = 1;                    ///< index of the side below over the index of the side of wo, where light bends
  float reflect = 1, transmit = 1;  ///< rough_dielectric: mean tints
  RGB albedo;             ///< share of the light scattered, exact for deltas (radiance of `refraction`: unscaled)
  float probability = 0;  ///< of choosing this component among the given lobes' components
  Vec3 normal{0, 0, 1};   ///< rough_reflection and mirror: the normal of reflection
  const MeasuredBsdf* measured = nullptr;  ///< measured shapes
};

/// The components of a BSDF for one wo.
struct Components {
  static constexpr int kMaxCount = 9;
  Component list[kMaxCount];
  int count = 0;
  void add(const Component& component) {
    if (max_component(component.albedo) > 0) list[count++] = component;
  }
};

/// The lobe of a GGX reflection or refraction.
inline Lobes lobe_of_alpha(float alpha_x, float alpha_y) {
  return alpha_x * alpha_y < kSpecularAlpha * kSpecularAlpha ? kSpecular : kGlossy;
}
inline bool is_smooth(float alpha_x, float alpha_y) { return std::max(alpha_x, alpha_y) < kSmoothAlpha; }
/// The alpha of an isotropic broad lobe; 0 for others.
inline float broad_alpha(float alpha) { return lobe_of_alpha(alpha, alpha) == kGlossy ? alpha : 0.0f; }
/// A microfacet distribution unless both alphas are smooth.
inline Microfacet rough(float alpha_x, float alpha_y) { return {std::max(alpha_x, 1e-4f), std::max(alpha_y, 1e-4f)}; }

/// A dielectric's index on the far side over that on the viewer's. An index of almost exactly 1 is moved invisibly,
/// because facet normals of unbent transmission are undefined.
inline float relative_eta(const Bsdf& bsdf, bool inside) {
  const float eta = std::abs(bsdf.eta.r - 1) < 1e-3f ? 1.001f : bsdf.eta.r;
  return inside ? 1 / eta : eta;
}

/// The half vector of reflection from wi to wo, on the side of wo; zero if there is none.
inline Vec3 reflection_half(Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float l2 = length_squared(sum);
  return l2 > 0 ? sum * (1 / std::sqrt(l2)) : Vec3{0, 0, 0};
}
/// The half vector of refraction, wi below (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
/// 2007, eq. 16), turned to z > 0; zero if no facet can refract one into the other.
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

/// A direction in the frame of a component's own normal.
inline Vec3 about_normal(const Component& c, Vec3 w) {
  return c.normal.z == 1 ? w : Frame::from_normal(c.normal).to_local(w);
}

/// Density per steradian of a component's directions; deltas: 0.
float component_pdf(const Component& component, Vec3 wo, Vec3 wi);
/// Samples a direction of a component; false if the sample is lost (it left the correct side).
/// @param u_side in [0, 1), chooses between reflection and refraction
bool component_sample(const Component& component, Vec3 wo, float u_side, Vec2 u, Vec3& wi);

// Two functions for each kind: f for a batch of directions, and its components.
void evaluate_lambertian(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void lambertian_components(const View& view, Components& out);
void evaluate_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void conductor_components(const View& view, Components& out);
void evaluate_dielectric(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void dielectric_components(const View& view, Components& out);
void thin_dielectric_components(const View& view, Components& out);
void evaluate_coated_diffuse(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void coated_diffuse_components(const View& view, Components& out);
void evaluate_coated_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void coated_conductor_components(const View& view, Components& out);
void evaluate_metallic_roughness(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void evaluate_measured(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
void measured_components(const View& view, Components& out);
void metallic_roughness_components(const View& view, Components& out);

// isotropic_reflection() for the kinds that support it.
IsotropicReflection reflection_of_conductor(const Bsdf& bsdf, float cosine_o);
IsotropicReflection reflection_of_coated_diffuse(const Bsdf& bsdf, float cosine_o);
IsotropicReflection reflection_of_metallic_roughness(const Bsdf& bsdf, float cosine_o);

}  // namespace glowworm::bsdf_detail
