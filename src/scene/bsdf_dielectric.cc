#include "scene/bsdf_component.h"
#include "scene/bsdf_fresnel.h"

namespace glowworm::bsdf_detail {
namespace {

/// Index of the far side over that of the viewer's side. An index of exactly 1 is moved by so little that nothing is
/// seen of it, since microfacet normals of straight transmission are not defined.
float relative_eta(const Bsdf& bsdf, bool inside) {
  const float eta = std::abs(bsdf.eta.r - 1) < 1e-3f ? 1.001f : bsdf.eta.r;
  return inside ? 1 / eta : eta;
}

}  // namespace

RGB evaluate_dielectric(const Bsdf& bsdf, bool inside, Vec3 wo, Vec3 wi) {
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || wi.z == 0) return RGB(0.0f);
  const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
  const float eta = relative_eta(bsdf, inside);
  if (wi.z > 0) {
    const Vec3 h = reflection_half(wo, wi);
    return bsdf.specular * (fresnel_dielectric(dot(wo, h), eta) * microfacet_reflection(m, wo, wi, h));
  }
  const Vec3 h = refraction_half(wo, wi, eta);
  if (h.z <= 0) return RGB(0.0f);
  return bsdf.transmission * ((1 - fresnel_dielectric(dot(wo, h), eta)) * microfacet_refraction(m, wo, wi, h, eta));
}

void dielectric_components(const Bsdf& bsdf, bool inside, Vec3 wo, Components& out) {
  Component c;
  c.lobe = lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
  c.eta = relative_eta(bsdf, inside);
  c.microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
  const float f = fresnel_dielectric(wo.z, c.eta);
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y)) {
    c.shape = Shape::mirror;
    c.albedo = bsdf.specular * f;
    out.add(c);
    c.shape = Shape::refraction;
    c.albedo = bsdf.transmission * (1 - f);
    out.add(c);
    return;
  }
  c.shape = Shape::rough_dielectric;
  c.reflect = mean(bsdf.specular);
  c.transmit = mean(bsdf.transmission);
  c.albedo = bsdf.specular * f + bsdf.transmission * (1 - f);
  out.add(c);
}

void thin_dielectric_components(const Bsdf& bsdf, Vec3 wo, Components& out) {
  // Between the two faces light goes to and fro: R + T R T + T R R R T + … with T = 1 - R (Pharr, Jakob and Humphreys,
  // "Physically Based Rendering", 4th edition, section 9.5.2), which adds up to R + T^2 R / (1 - R^2) = 2 R / (1 + R).
  const float r = fresnel_dielectric(wo.z, bsdf.eta.r), reflected = 2 * r / (1 + r);
  Component c;
  c.lobe = kSharp;
  c.shape = Shape::mirror;
  c.albedo = bsdf.specular * reflected;
  out.add(c);
  c.shape = Shape::straight;
  c.albedo = bsdf.transmission * (1 - reflected);
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
