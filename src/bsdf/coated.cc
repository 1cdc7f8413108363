// Surfaces under a dielectric coat: closed forms for a random walk between the two boundaries.
//
// Let A(w) be the share of the flux from w that reaches the base through the coat's boundary and its absorption. By
// reciprocity, the boundary turns a uniform radiance L inside into L A(w) / eta^2 outside.
//
// Diffuse base of albedo rho: directions are lost at the base, so each round trip returns the same share R of the light
// that leaves the base (R: internal reflectance of the boundary for diffuse light, with absorption), and
//   f = rho / (pi eta^2) A(wo) A(wi) (1 + rho R + (rho R)^2 + ...).
// This is exact, for smooth and rough coats, as far as A and R are. They are tabulated for isotropic roughness, and
// their absorption is that of a smooth boundary.
//
// Conductor: f = A(wo) A(wi) / eta^2 [F D G / (4 cos cos)](wo', wi'), with directions refracted by the smooth boundary,
// is exact for a smooth coat and one reflection at the base. A rough coat spreads light on entry and exit, and light
// that the boundary returns meets the base again with a wider spread. Both are modelled by larger roughnesses of the
// base (variances of slope add up, as in Belcour, "Efficient Rendering of Layered Materials using an Atomic
// Decomposition with Statistical Operators", 2018).
#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {
namespace {

/// 1 + x + x^2 + ..., with `terms` terms; 0: an infinite sum.
float geometric_sum(float x, int terms) {
  if (terms == 0) return 1 / std::max(1 - x, 1e-6f);
  float sum = 1;
  for (int i = 1; i < terms; ++i) sum = 1 + x * sum;
  return sum;
}
RGB geometric_sum(RGB x, int terms) {
  return {geometric_sum(x.r, terms), geometric_sum(x.g, terms), geometric_sum(x.b, terms)};
}

float coat_index(const Bsdf& bsdf) { return std::clamp(bsdf.coat_eta, 1.001f, 3.0f); }
/// Cosine under the boundary for a direction above it.
float inner_cosine(float cosine, float eta) {
  return std::sqrt(std::max(0.0f, 1 - (1 - cosine * cosine) / (eta * eta)));
}
Vec3 inner_direction(Vec3 w, float eta) { return {w.x / eta, w.y / eta, inner_cosine(w.z, eta)}; }

/// The boundary of a coat.
struct Coat {
  bool smooth;
  Lobes lobe;
  Microfacet microfacet;
  float eta, thickness;
  Curve reflected, transmitted, transmitted_inside;

  Coat(const Bsdf& bsdf, float alpha_x, float alpha_y)
      : smooth(is_smooth(alpha_x, alpha_y)),
        lobe(lobe_of_alpha(alpha_x, alpha_y)),
        microfacet(rough(alpha_x, alpha_y)),
        eta(coat_index(bsdf)),
        thickness(bsdf.coat_thickness) {
    if (smooth) return;
    reflected = boundary_curve(Boundary::reflect_outside, table_alpha(alpha_x, alpha_y), eta);
    transmitted = boundary_curve(Boundary::transmit_outside, table_alpha(alpha_x, alpha_y), eta);
    transmitted_inside = boundary_curve(Boundary::transmit_inside, table_alpha(alpha_x, alpha_y), eta);
  }
  /// A(w) above.
  float passed(float cosine) const {
    const float t = smooth ? 1 - fresnel_dielectric(cosine, eta) : transmitted(cosine);
    return thickness > 0 ? t * std::exp(-thickness / inner_cosine(cosine, eta)) : t;
  }
  /// The same for light that returns in a narrow lobe. The steep facets of a rough boundary reflect from inside light
  /// that they transmit from outside, so this is the mean of both directions.
  float passed_narrow(float cosine) const {
    if (smooth) return passed(cosine);
    const float inner = inner_cosine(cosine, eta);
    const float t = std::sqrt(transmitted(cosine) * transmitted_inside(inner));
    return thickness > 0 ? t * std::exp(-thickness / inner) : t;
  }
  /// f of the reflection at the boundary.
  float reflection(Vec3 wo, Vec3 wi) const {
    const Vec3 h = reflection_half(wo, wi);
    return fresnel_dielectric(dot(wo, h), eta) * microfacet_reflection(microfacet, wo, wi, h);
  }
  Component component(Vec3 wo) const {
    Component c;
    c.lobe = lobe;
    c.shape = smooth ? Shape::mirror : Shape::rough_reflection;
    c.microfacet = microfacet;
    c.albedo = RGB(smooth ? fresnel_dielectric(wo.z, eta) : reflected(wo.z));
    return c;
  }
};

/// f of the diffuse base over A(wo) A(wi), and the mean of A over directions.
struct DiffuseBase {
  RGB factor;
  float mean_passed;

  DiffuseBase(const Bsdf& bsdf, const Coat& coat) {
    // A smooth boundary is the first node of the tables.
    const float alpha = coat.smooth ? 0 : table_alpha(coat.microfacet.alpha_x, coat.microfacet.alpha_y);
    const BoundaryMeans means = boundary_means(alpha, coat.eta);
    const float returned = means.reflect_inside * internal_transmittance(coat.eta, coat.thickness);
    factor =
        bsdf.diffuse * geometric_sum(bsdf.diffuse * returned, bsdf.coat_bounces) * (kInversePi / (coat.eta * coat.eta));
    // The mean of 1 / cos' under the boundary, weighted by cos above it.
    const float eta2 = coat.eta * coat.eta, mean_secant = 2 * eta2 * (1 - std::sqrt(1 - 1 / eta2));
    mean_passed = means.transmit_outside * std::exp(-coat.thickness * mean_secant);
  }
};

/// The two lobes of a conductor under a coat.
struct ConductorBase {
  bool smooth;
  Lobes lobe;
  Microfacet once, again;  ///< one reflection at the base, and more
  Curve trapped;

  ConductorBase(const Bsdf& bsdf, const Coat& coat) {
    // A slope of the coat's facet turns a passing ray by (1 - 1 / eta) of the slope, as would a base facet of half
    // that; light passes twice.
    const float turn = coat.smooth ? 0 : 0.5f * (1 - 1 / coat.eta) * coat.microfacet.alpha_x;
    const float added = 2 * turn * turn;
    const float x = std::sqrt(bsdf.alpha_x * bsdf.alpha_x + added), y = std::sqrt(bsdf.alpha_y * bsdf.alpha_y + added);
    smooth = is_smooth(x, y);
    lobe = lobe_of_alpha(x, y);
    once = rough(x, y);
    again = {widened(once.alpha_x), widened(once.alpha_y)};
    trapped = boundary_curve(Boundary::trapped, smooth ? 0 : table_alpha(x, y), coat.eta);
  }
  /// Doubles the variance, unless GGX would then lose much more energy between facets.
  static float widened(float alpha) { return std::min(alpha * std::sqrt(2.0f), std::max(alpha, 0.5f)); }
};

}  // namespace

void evaluate_coated_diffuse(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Coat coat(view.bsdf, view.bsdf.alpha_x, view.bsdf.alpha_y);
  const bool glossy = !coat.smooth && (view.lobes & coat.lobe);
  const bool diffuse = view.lobes & kDiffuseReflection;
  if (!glossy && !diffuse) return fill_black(out);
  const RGB base = diffuse ? DiffuseBase(view.bsdf, coat).factor * coat.passed(view.wo.z) : RGB(0.0f);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    RGB f = diffuse ? base * coat.passed(w.z) : RGB(0.0f);
    if (glossy) f += RGB(coat.reflection(view.wo, w));
    return f;
  });
}

IsotropicReflection reflection_of_coated_diffuse(const Bsdf& bsdf, float cosine_o) {
  const Coat coat(bsdf, bsdf.alpha_x, bsdf.alpha_y);
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.diffuse = DiffuseBase(bsdf, coat).factor * coat.passed(cosine_o);
  out.eta = coat.eta;
  out.thickness = coat.thickness;
  if (!coat.smooth) out.curve[0] = coat.transmitted;
  return out;
}

void coated_diffuse_components(const View& view, Components& out) {
  const Coat coat(view.bsdf, view.bsdf.alpha_x, view.bsdf.alpha_y);
  out.add(coat.component(view.wo));
  const DiffuseBase base(view.bsdf, coat);
  Component c;
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = base.factor * (kPi * coat.passed(view.wo.z) * base.mean_passed);
  out.add(c);
}

void evaluate_coated_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Coat coat(bsdf, bsdf.coat_alpha, bsdf.coat_alpha);
  const ConductorBase base(bsdf, coat);
  const bool upper = !coat.smooth && (view.lobes & coat.lobe), lower = !base.smooth && (view.lobes & base.lobe);
  if (!upper && !lower) return fill_black(out);
  const Vec3 o = inner_direction(view.wo, coat.eta);
  const float passed = coat.passed_narrow(view.wo.z) / (coat.eta * coat.eta), trapped = base.trapped(o.z);
  const float fro = coat.thickness > 0 ? std::exp(-coat.thickness / o.z) : 1.0f;
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    RGB f(0.0f);
    if (lower) {
      const Vec3 i = inner_direction(w, coat.eta), h = reflection_half(o, i);
      const RGB fresnel = fresnel_of_base(bsdf, dot(o, h), coat.eta);
      // The shares returned at either direction are averaged, so that f stays reciprocal.
      const float to = coat.thickness > 0 ? std::exp(-coat.thickness / i.z) : 1.0f;
      const float returned = std::sqrt(trapped * base.trapped(i.z)) * fro * to;
      const RGB more = geometric_sum(fresnel * returned, bsdf.coat_bounces) - RGB(1.0f);
      f = fresnel * (passed * coat.passed_narrow(w.z)) *
          (RGB(microfacet_reflection(base.once, o, i, h)) + more * microfacet_reflection(base.again, o, i, h));
    }
    if (upper) f += RGB(coat.reflection(view.wo, w));
    return f;
  });
}

void coated_conductor_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  const Coat coat(bsdf, bsdf.coat_alpha, bsdf.coat_alpha);
  const ConductorBase base(bsdf, coat);
  Component upper = coat.component(view.wo);
  const float inner = inner_cosine(view.wo.z, coat.eta), passed = coat.passed_narrow(view.wo.z);
  const RGB fresnel = fresnel_of_base(bsdf, inner, coat.eta);
  const float to_and_fro = coat.thickness > 0 ? std::exp(-2 * coat.thickness / inner) : 1.0f;
  const float trapped = base.smooth ? fresnel_dielectric(inner, 1 / coat.eta) : base.trapped(inner);
  const float returned = trapped * to_and_fro;
  if (base.smooth) {
    // All light takes the same direction: R + T^2 F / (1 - R F).
    const RGB mirrored = clamp(fresnel * geometric_sum(fresnel * returned, bsdf.coat_bounces) * (passed * passed), 0,
                               std::max(0.0f, 1 - upper.albedo.r));
    if (coat.smooth) upper.albedo += mirrored;
    out.add(upper);
    if (coat.smooth) return;
    Component mirror;
    mirror.lobe = base.lobe;
    mirror.shape = Shape::mirror;
    mirror.albedo = mirrored;
    out.add(mirror);
    return;
  }
  out.add(upper);
  Component c;
  c.lobe = base.lobe;
  c.shape = Shape::coated_reflection;
  c.microfacet = base.once;
  c.eta = coat.eta;
  // Shares that leave after one and after two reflections at the base.
  const float wide = table_alpha(base.again.alpha_x, base.again.alpha_y);
  const float trapped_again = boundary_curve(Boundary::trapped, wide, coat.eta)(inner);
  const SchlickCurves narrow_lobe = schlick_curves(table_alpha(base.once.alpha_x, base.once.alpha_y));
  const SchlickCurves wide_lobe = schlick_curves(wide);
  const float out_once = std::max(1e-3f, narrow_lobe.scale(inner) + narrow_lobe.bias(inner) - trapped);
  const float out_again = std::max(0.0f, wide_lobe.scale(inner) + wide_lobe.bias(inner) - trapped_again);
  const RGB estimate = fresnel * passed * (RGB(out_once) + fresnel * (returned * out_again));
  c.albedo = clamp(estimate, 0, std::max(1e-3f, 1 - upper.albedo.r));
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
