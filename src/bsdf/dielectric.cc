#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/multiple.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {
namespace {

/// Light that meets more than one facet of rough glass, for a viewer on one side: lobes of shares of the lost light.
struct MultipleGlass {
  Curve near, far;                 ///< lost from the viewer's side, and from the other
  float mean_near, mean_far;       ///< over directions
  float reflected, passed;         ///< shares of the light lost from the viewer's side
  float reflection, transmission;  ///< factors of f

  /// @param eta far side over near side
  MultipleGlass(const Bsdf& bsdf, float eta) {
    const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
    const float dense = std::max(eta, 1 / eta);
    const bool from_dense = eta < 1;
    const Boundary sides[2] = {Boundary::lost_outside, Boundary::lost_inside};
    const BoundaryTable table(m, dense);
    near = table.curve(sides[from_dense]);
    far = table.curve(sides[!from_dense]);
    mean_near = table.mean(sides[from_dense]);
    mean_far = table.mean(sides[!from_dense]);
    const float outside = multiple_passing(smooth_transmittance(dense), mean_near, mean_far);
    const float passing = from_dense ? outside / (dense * dense) : outside;
    passed = over_mean(passing, mean_near);
    reflected = 1 - passed;
    reflection = kInversePi * reflected;
    // Radiance is scaled by the squared relative index of the viewer's side.
    transmission = kInversePi * passing / (eta * eta);
  }
};

}  // namespace

void evaluate_dielectric(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Vec3 wo = view.wo;
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || !(view.lobes & kSpecular)) return fill_black(out);
  const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
  const float eta = relative_eta(bsdf, view.inside);
  const MultipleGlass multiple(bsdf, eta);
  const float lost = over_mean(multiple.near(place_of(m, wo)), multiple.mean_near);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z > 0) {
      const Vec3 h = reflection_half(wo, w);
      return bsdf.specular * (fresnel_dielectric(dot(wo, h), eta) * microfacet_reflection(m, wo, w, h) +
                              multiple.reflection * lost * multiple.near(place_of(m, w)));
    }
    const Vec3 h = refraction_half(wo, w, eta);
    float f = multiple.transmission * lost * over_mean(multiple.far(place_of(m, {w.x, w.y, -w.z})), multiple.mean_far);
    if (h.z > 0) f += (1 - fresnel_dielectric(dot(wo, h), eta)) * microfacet_refraction(m, wo, w, h, eta);
    return bsdf.transmission * f;
  });
}

void dielectric_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  Component c;
  c.lobe = kSpecular;
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
  const float dense = std::max(c.eta, 1 / c.eta);
  const bool from_dense = c.eta < 1;
  const BoundaryTable table(c.microfacet, dense);
  const Curve reflected = table.curve(from_dense ? Boundary::reflect_inside : Boundary::reflect_outside);
  const Curve passed = table.curve(from_dense ? Boundary::transmit_inside : Boundary::transmit_outside);
  const Place at = place_of(c.microfacet, view.wo);
  c.albedo = bsdf.specular * reflected(at) + bsdf.transmission * passed(at);
  out.add(c);
  const MultipleGlass multiple(bsdf, c.eta);
  const float lost = multiple.near(at);
  c.shape = Shape::cosine_reflection;
  c.albedo = bsdf.specular * (lost * multiple.reflected);
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.albedo = bsdf.transmission * (lost * multiple.passed);
  out.add(c);
}

void thin_dielectric_components(const View& view, Components& out) {
  // Reflections between the two faces: R + T R T + T R R R T + ... with T = 1 - R (Pharr, Jakob and
  // Humphreys, "Physically Based Rendering", 4th edition, section 9.5.2), for each polarisation. Each passage transmits
  // t, which is `transmission` at normal incidence and falls with the length of the path. The sums are R + T^2 t^2 R /
  // (1 - R^2 t^2) and T^2 t / (1 - R^2 t^2).
  const float eta = view.bsdf.eta.r, cos_i = std::min(view.wo.z, 1.0f);
  // Without a step of the index nothing is bent, not even by rounding.
  const float cos_t = eta == 1 ? cos_i : std::sqrt(std::max(1 - (1 - cos_i * cos_i) / (eta * eta), 0.0f));
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  RGB reflected{0.0f}, transmitted{0.0f};
  for (int k = 0; k < 3; ++k) {
    const float normal = view.bsdf.transmission[k];
    // Total reflection has no path through the pane.
    const float t = normal >= 1 ? 1 : cos_t > 0 && normal > 0 ? std::pow(normal, 1 / cos_t) : 0;
    for (const float amplitude : {parallel, perpendicular}) {
      const float r = std::min(amplitude * amplitude, 1.0f);
      const float passed = r < 1 ? (1 - r) * (1 - r) * t / (1 - r * r * t * t) : 0;
      reflected[k] += 0.5f * (r + r * t * passed);
      transmitted[k] += 0.5f * passed;
    }
  }
  Component c;
  c.lobe = kSpecular;
  c.shape = Shape::mirror;
  c.albedo = view.bsdf.specular * reflected;
  out.add(c);
  c.shape = Shape::straight;
  c.albedo = transmitted;
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
