#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {

void evaluate_dielectric(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Vec3 wo = view.wo;
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || !(view.lobes & kSharp)) return fill_black(out);
  const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
  const float eta = relative_eta(bsdf, view.inside);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z > 0) {
      const Vec3 h = reflection_half(wo, w);
      return bsdf.specular * (fresnel_dielectric(dot(wo, h), eta) * microfacet_reflection(m, wo, w, h));
    }
    const Vec3 h = refraction_half(wo, w, eta);
    if (h.z <= 0) return RGB(0.0f);
    return bsdf.transmission * ((1 - fresnel_dielectric(dot(wo, h), eta)) * microfacet_refraction(m, wo, w, h, eta));
  });
}

void dielectric_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  Component c;
  c.lobe = kSharp;
  c.eta = relative_eta(bsdf, view.inside);
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y)) {
    const float f = fresnel_dielectric(view.wo.z, c.eta);
    c.shape = Shape::mirror;
    c.albedo = bsdf.specular * f;
    out.add(c);
    c.shape = Shape::refraction;
    c.albedo = bsdf.transmission * (1 - f);
    out.add(c);
    return;
  }
  c.shape = Shape::rough_dielectric;
  c.microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
  c.reflect = mean(bsdf.specular);
  c.transmit = mean(bsdf.transmission);
  const float alpha = table_alpha(bsdf.alpha_x, bsdf.alpha_y), dense = std::max(c.eta, 1 / c.eta);
  const bool from_dense = c.eta < 1;
  const Curve reflected =
      boundary_curve(from_dense ? Boundary::reflect_inside : Boundary::reflect_outside, alpha, dense);
  const Curve passed =
      boundary_curve(from_dense ? Boundary::transmit_inside : Boundary::transmit_outside, alpha, dense);
  c.albedo = bsdf.specular * reflected(view.wo.z) + bsdf.transmission * passed(view.wo.z);
  out.add(c);
}

void thin_dielectric_components(const View& view, Components& out) {
  // Reflections between the two faces: R + T R T + T R R R T + … with T = 1 - R (Pharr, Jakob and Humphreys,
  // "Physically Based Rendering", 4th edition, section 9.5.2), which sums to R + T^2 R / (1 - R^2) = 2 R / (1 + R).
  const float r = fresnel_dielectric(view.wo.z, view.bsdf.eta.r), reflected = 2 * r / (1 + r);
  Component c;
  c.lobe = kSharp;
  c.shape = Shape::mirror;
  c.albedo = view.bsdf.specular * reflected;
  out.add(c);
  c.shape = Shape::straight;
  c.albedo = view.bsdf.transmission * (1 - reflected);
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
