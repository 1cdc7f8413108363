// Surfaces under a dielectric coat: closed forms for a random walk between the two boundaries.
//
// Let A(w) be the share of the flux from w that reaches the base through the coat's boundary and its absorption. By
// reciprocity, the boundary turns a uniform radiance L inside into L A(w) / eta^2 outside.
//
// Diffuse base of albedo rho: directions are lost at the base, so each round trip returns the same share R of the light
// that leaves the base (R: internal reflectance of the boundary for diffuse light, with absorption), and
//   f = rho / (pi eta^2) A(wo) A(wi) (1 + rho R + (rho R)^2 + ...).
// This is exact, for smooth and rough coats, as far as A and R are. They are tabulated, and their absorption is
// the value of a smooth boundary.
//
// Conductor: f = A(wo) A(wi) / eta^2 [F D G / (4 cos cos)](wo', wi'), with directions refracted by the smooth boundary,
// is exact for a smooth coat and one reflection at the base. A rough coat spreads light on entry and exit, which is
// modelled by a larger roughness of the base (variances of slope add up, as in Belcour, "Efficient Rendering of Layered
// Materials using an Atomic Decomposition with Statistical Operators", 2018). Light that the boundary returns as it
// would at normal incidence meets the base again with a wider spread. All other light leaves as a diffuse lobe: what
// enters from w and does not leave by the lobes above, as multiple.h treats the light of several facets.
#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/multiple.h"
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
  Curve reflected, transmitted, lost;  // rough coats only
  float mean_lost = 0;
  float through = 0;  // share of the light lost between facets that reaches the base
  float mean_passed;  // mean of A without absorption

  Coat(const Bsdf& bsdf, float alpha_x, float alpha_y)
      : smooth(is_smooth(alpha_x, alpha_y)),
        lobe(lobe_of_alpha(alpha_x, alpha_y)),
        microfacet(rough(alpha_x, alpha_y)),
        eta(coat_index(bsdf)),
        thickness(bsdf.coat_thickness) {
    const float transmitted_smooth = smooth_transmittance(eta);
    mean_passed = transmitted_smooth;
    if (smooth) return;
    const BoundaryTable table(microfacet, eta);
    mean_passed = table.mean(Boundary::transmit_outside);
    reflected = table.curve(Boundary::reflect_outside);
    transmitted = table.curve(Boundary::transmit_outside);
    lost = table.curve(Boundary::lost_outside);
    mean_lost = table.mean(Boundary::lost_outside);
    const float passing = multiple_passing(transmitted_smooth, mean_lost, table.mean(Boundary::lost_inside));
    through = over_mean(passing, mean_lost);
    mean_passed += passing;
  }
  Place place(Vec3 w) const { return place_of(microfacet, w); }
  /// A(w) above.
  float passed(Place at) const { return entered(at) * absorption(inner_cosine(at.cosine, eta)); }
  /// A(w) without absorption.
  float entered(Place at) const {
    return smooth ? 1 - fresnel_dielectric(at.cosine, eta) : transmitted(at) + through * lost(at);
  }
  /// Transmittance of a passage of the coat.
  float absorption(float inner) const { return thickness > 0 ? std::exp(-thickness / inner) : 1.0f; }
  /// f of the reflection after several facets of the boundary, over lost(wi).
  float multiple(Place at) const { return smooth ? 0 : kInversePi * (1 - through) * over_mean(lost(at), mean_lost); }
  /// f of the reflection at the boundary.
  /// @param multiple multiple() of wo
  float reflection(Vec3 wo, Vec3 wi, float multiple) const {
    const Vec3 h = reflection_half(wo, wi);
    return fresnel_dielectric(dot(wo, h), eta) * microfacet_reflection(microfacet, wo, wi, h) +
           multiple * lost(place(wi));
  }
  /// Share that the boundary reflects.
  float reflectance(Place at) const {
    return smooth ? fresnel_dielectric(at.cosine, eta) : reflected(at) + (1 - through) * lost(at);
  }
  void add_components(Vec3 wo, Components& out) const {
    Component c;
    c.lobe = lobe;
    c.shape = smooth ? Shape::mirror : Shape::rough_reflection;
    c.microfacet = microfacet;
    c.albedo = RGB(smooth ? fresnel_dielectric(wo.z, eta) : reflected(place(wo)));
    out.add(c);
    if (smooth) return;
    c.shape = Shape::cosine_reflection;
    c.albedo = RGB((1 - through) * lost(place(wo)));
    out.add(c);
  }
};

/// f of the diffuse base over A(wo) A(wi), and the mean of A over directions.
struct DiffuseBase {
  RGB factor;
  float mean_passed;

  DiffuseBase(const Bsdf& bsdf, const Coat& coat) {
    // By reciprocity, light from inside passes the boundary with the mean of A over the squared index.
    const float returned =
        (1 - coat.mean_passed / (coat.eta * coat.eta)) * internal_transmittance(coat.eta, coat.thickness);
    factor =
        bsdf.diffuse * geometric_sum(bsdf.diffuse * returned, bsdf.coat_bounces) * (kInversePi / (coat.eta * coat.eta));
    // The mean of 1 / cos' under the boundary, weighted by cos above it.
    const float eta2 = coat.eta * coat.eta, mean_secant = 2 * eta2 * (1 - std::sqrt(1 - 1 / eta2));
    mean_passed = coat.mean_passed * std::exp(-coat.thickness * mean_secant);
  }
};

/// The lobes of a conductor under a coat. Shares are of flux, for a base that absorbs nothing, without absorption in
/// the coat.
struct ConductorBase {
  const Bsdf& bsdf;
  const Coat& coat;
  bool smooth;
  Lobes lobe;
  Microfacet once, again;     ///< one reflection at the base, and more
  float at_normal;            ///< reflectance of a smooth boundary at normal incidence
  float direct;               ///< share that a rough boundary passes as narrowly as a smooth one, on entry and exit
  Curve all_once, all_again;  ///< of MirrorCurve
  Curve trapped_once, trapped_again;
  float mean_spread = 0;   ///< of spread() over directions
  RGB color_spread{0.0f};  ///< of the light that leaves as a diffuse lobe

  ConductorBase(const Bsdf& material, const Coat& boundary) : bsdf(material), coat(boundary) {
    // A slope of the coat's facet turns a passing ray by (1 - 1 / eta) of the slope, as would a base facet of half
    // that; light passes twice.
    const float turn = coat.smooth ? 0 : 0.5f * (1 - 1 / coat.eta) * coat.microfacet.alpha_x;
    const float added = 2 * turn * turn;
    const float x = std::sqrt(bsdf.alpha_x * bsdf.alpha_x + added), y = std::sqrt(bsdf.alpha_y * bsdf.alpha_y + added);
    smooth = is_smooth(x, y);
    lobe = lobe_of_alpha(x, y);
    at_normal = fresnel_dielectric(1, coat.eta);
    direct = 1;
    if (!coat.smooth) direct = std::min(1.0f, coat.transmitted({1}) / (1 - at_normal));
    direct *= direct;
    if (smooth) return;
    once = rough(x, y);
    again = {widened(once.alpha_x), widened(once.alpha_y)};
    all_once = mirror_curve(once).all;
    all_again = mirror_curve(again).all;
    trapped_once = BoundaryTable(once, coat.eta).curve(Boundary::trapped);
    trapped_again = BoundaryTable(again, coat.eta).curve(Boundary::trapped);
    set_spread();
  }
  /// Doubles the variance, unless GGX would then lose much more energy between facets.
  static float widened(float alpha) { return std::min(alpha * std::sqrt(2.0f), std::max(alpha, 0.5f)); }

  /// Share of the light that has entered from this direction that leaves after one reflection at the base.
  float leaves_once(Vec3 w) const { return leaves(all_once, trapped_once, place_of(once, w)); }
  float leaves_again(Vec3 w) const { return leaves(all_again, trapped_again, place_of(again, w)); }
  /// f of the narrow lobes over A(wi), without the facets' part.
  float narrow(float cosine) const { return (1 - fresnel_dielectric(cosine, coat.eta)) / coat.eta; }
  /// Of light that has met the base once, what meets it again in the lobe `again`.
  RGB repeated(RGB fresnel, float to_and_fro) const {
    return geometric_sum(fresnel * (at_normal * to_and_fro), bsdf.coat_bounces) - RGB(1.0f);
  }
  /// Share of the light from outside that enters and does not leave in the narrow lobes.
  float spread(Vec3 w) const {
    const float more = at_normal / (1 - at_normal), left = leaves_once(w) + more * leaves_again(w);
    return std::max(0.0f, coat.entered(coat.place(w)) - direct * (1 - fresnel_dielectric(w.z, coat.eta)) * left);
  }
  /// f of the diffuse lobe over spread() and absorption of wi.
  RGB factor_spread(Vec3 w) const {
    return color_spread *
           (kInversePi * over_mean(spread(w), mean_spread) * coat.absorption(inner_cosine(w.z, coat.eta)));
  }

 private:
  float leaves(const Curve& all, const Curve& trapped, Place at) const {
    const Place inner{inner_cosine(at.cosine, coat.eta), at.along};
    return std::max(0.0f, all(inner) - trapped(at));
  }
  void set_spread() {
    for_mean_directions(once, [&](Vec3 w, float weight) { mean_spread += weight * spread(w); });
    // Light that enters diffusely has met the base once; other light has met it twice, and each time the share
    // `returned` of it meets it again.
    const RGB mean = mean_schlick(fresnel_of_base(bsdf, 1, coat.eta), 1);
    const float returned = std::min(1.0f, over_mean(mean_spread, coat.mean_passed));
    const RGB again = mean * (returned * internal_transmittance(coat.eta, coat.thickness));
    const int bounces = bsdf.coat_bounces == 0 ? 0 : std::max(1, bsdf.coat_bounces - 1);
    const RGB met_before = RGB(1 - direct) + mean * direct;
    color_spread = mean * met_before * geometric_sum(again, bounces) * (1 - returned);
  }
};

}  // namespace

void evaluate_coated_diffuse(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Coat coat(view.bsdf, view.bsdf.alpha_x, view.bsdf.alpha_y);
  const bool glossy = !coat.smooth && (view.lobes & coat.lobe);
  const bool diffuse = view.lobes & kDiffuseReflection;
  if (!glossy && !diffuse) return fill_black(out);
  const RGB base = diffuse ? DiffuseBase(view.bsdf, coat).factor * coat.passed(coat.place(view.wo)) : RGB(0.0f);
  const float multiple = coat.multiple(coat.place(view.wo));
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    RGB f = diffuse ? base * coat.passed(coat.place(w)) : RGB(0.0f);
    if (glossy) f += RGB(coat.reflection(view.wo, w, multiple));
    return f;
  });
}

IsotropicReflection reflection_of_coated_diffuse(const Bsdf& bsdf, float cosine_o) {
  const Coat coat(bsdf, bsdf.alpha_x, bsdf.alpha_y);
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.diffuse = DiffuseBase(bsdf, coat).factor * coat.passed({cosine_o});
  out.eta = coat.eta;
  out.thickness = coat.thickness;
  if (coat.smooth) return out;
  out.curve[0] = coat.transmitted;
  out.curve[1] = coat.lost;
  out.through = coat.through;
  if (out.alpha > 0) out.multiple = RGB(coat.multiple({cosine_o}));
  return out;
}

void coated_diffuse_components(const View& view, Components& out) {
  const Coat coat(view.bsdf, view.bsdf.alpha_x, view.bsdf.alpha_y);
  coat.add_components(view.wo, out);
  const DiffuseBase base(view.bsdf, coat);
  Component c;
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = base.factor * (kPi * coat.passed(coat.place(view.wo)) * base.mean_passed);
  out.add(c);
}

void evaluate_coated_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Coat coat(bsdf, bsdf.coat_alpha, bsdf.coat_alpha);
  const float multiple = coat.multiple(coat.place(view.wo));
  const ConductorBase base(bsdf, coat);
  const bool upper = !coat.smooth && (view.lobes & coat.lobe), lower = !base.smooth && (view.lobes & base.lobe);
  if (!upper && !lower) return fill_black(out);
  const Vec3 o = inner_direction(view.wo, coat.eta);
  const float narrow = lower ? base.direct * base.narrow(view.wo.z) : 0, fro = coat.absorption(o.z);
  const RGB spread = lower ? base.factor_spread(view.wo) : RGB(0.0f);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    RGB f(0.0f);
    if (lower) {
      const Vec3 i = inner_direction(w, coat.eta), h = reflection_half(o, i);
      const RGB fresnel = fresnel_of_base(bsdf, dot(o, h), coat.eta);
      const float to = coat.absorption(i.z);
      f = fresnel * (narrow * base.narrow(w.z) * fro * to) *
          (RGB(microfacet_reflection(base.once, o, i, h)) +
           base.repeated(fresnel, fro * to) * microfacet_reflection(base.again, o, i, h));
      f += spread * (base.spread(w) * to);
    }
    if (upper) f += RGB(coat.reflection(view.wo, w, multiple));
    return f;
  });
}

void coated_conductor_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  const Coat coat(bsdf, bsdf.coat_alpha, bsdf.coat_alpha);
  const ConductorBase base(bsdf, coat);
  coat.add_components(view.wo, out);
  const float inner = inner_cosine(view.wo.z, coat.eta), passed = 1 - fresnel_dielectric(view.wo.z, coat.eta);
  const RGB fresnel = fresnel_of_base(bsdf, inner, coat.eta);
  const float fro = coat.absorption(inner), to_and_fro = fro * fro;
  if (base.smooth) {
    // All light takes the same direction: R + T^2 F / (1 - R F).
    const float returned = fresnel_dielectric(inner, 1 / coat.eta) * to_and_fro;
    const RGB mirrored =
        fresnel * geometric_sum(fresnel * returned, bsdf.coat_bounces) * (passed * passed * to_and_fro * base.direct);
    if (coat.smooth) {
      out.list[0].albedo += mirrored;
      return;
    }
    Component mirror;
    mirror.lobe = base.lobe;
    mirror.shape = Shape::mirror;
    mirror.albedo = clamp(mirrored, 0, std::max(0.0f, 1 - coat.reflectance(coat.place(view.wo))));
    out.add(mirror);
    return;
  }
  Component c;
  c.lobe = base.lobe;
  c.shape = Shape::coated_reflection;
  c.microfacet = base.once;
  c.eta = coat.eta;
  const float out_once = std::max(1e-3f, base.leaves_once(view.wo));
  const float out_again = base.leaves_again(view.wo);
  c.albedo =
      fresnel * (passed * base.direct * to_and_fro) * (RGB(out_once) + base.repeated(fresnel, to_and_fro) * out_again);
  out.add(c);
  c.shape = Shape::cosine_reflection;
  c.eta = 1;
  // The absorption of light that leaves is about the absorption at a cosine of 2/3 outside.
  c.albedo = base.color_spread * (base.spread(view.wo) * fro * coat.absorption(inner_cosine(2.0f / 3, coat.eta)));
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
