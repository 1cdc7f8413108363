// glTF 2.0's metallic-roughness material (Khronos, "glTF 2.0 Specification", appendix B) with KHR_materials_ior,
// specular, clearcoat, transmission, sheen, iridescence and diffuse_transmission.
//
// The appendix does not define an energy-conserving coupling of layers (B.2.3, "fresnel_mix"; its own sample does not
// conserve energy at grazing angles). Here:
// - Diffuse under the specular layer of directional albedo E: c / pi (1 - E(wo)) (1 - E(wi)) / (1 - mean E), which is
//   reciprocal and has exactly the albedo c (1 - E(wo)) (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled
//   Specular-Matte BRDF Model with Importance Sampling", 2001, eq. 5).
// - Layers under the clearcoat are weakened at both directions by 1 - coat E_coat.
// - Transmission passes through each facet that does not reflect. Thin: straight through, spread by the same lobe
//   mirrored. Not thin: refracted; the surface then has an inside, which sees neither coat nor diffuse reflection.
// - Diffuse light is reflected or transmitted, by KHR_materials_diffuse_transmission; not on refracting surfaces.
// - Sheen is on top of all layers except the coat (not on refracting surfaces). It reduces the layers below it by the
//   larger of its albedos at the two directions (KHR_materials_sheen, "Albedo-scaling technique").
// - A coat with another normal n has f = f_n min(1, n.wo / z_o) min(1, n.wi / z_i), which is reciprocal and reflects at
//   most as much as about its own normal.
#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/sheen.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {
namespace {

float square(float x) { return x * x; }

/// The material for one viewer.
struct Layers {
  bool refracts, inside, smooth, coat_smooth;
  Lobes lobe, coat_lobe;
  Microfacet microfacet, coat_microfacet;
  float eta;    // far side over near side
  float dense;  // inside over outside
  RGB f0;       // of the specular layer, a mix of dielectric and metal
  float f90;
  RGB dielectric_f0;
  float dielectric_f90;
  RGB diffuse, transmitted;  // shares of base colour that are reflected diffusely and transmitted
  RGB diffuse_through;       // share of the diffuse light that leaves on the other side
  float coat, coat_f0;
  bool tilted;  // the coat has another normal
  Frame coat_frame;
  SchlickCurves curves, dielectric_curves, coat_curves;
  RGB sheen;
  Sheen sheen_lobe;
  float iridescence, film_eta, film_thickness;
  RGB film_mean;  // mean over directions of film_albedo() of the dielectric
  RGB metal_f0;
  float metallic;

  explicit Layers(const View& view) {
    const Bsdf& bsdf = view.bsdf;
    refracts = bsdf.transmission_weight > 0 && bsdf.metallic < 1 && !bsdf.thin;
    inside = refracts && view.inside;
    smooth = is_smooth(bsdf.alpha_x, bsdf.alpha_y);
    lobe = bsdf.transmission_weight > 0 ? kSharp : lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
    microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
    dense = std::max(relative_eta(bsdf, false), 1.001f);  // glTF has no index below 1
    eta = inside ? 1 / dense : dense;
    const RGB tinted = bsdf.specular * square((dense - 1) / (dense + 1));
    dielectric_f0 = clamp(tinted, 0, 1) * bsdf.specular_weight;
    dielectric_f90 = bsdf.specular_weight;
    metal_f0 = bsdf.diffuse;
    metallic = bsdf.metallic;
    f0 = lerp(dielectric_f0, metal_f0, metallic);
    f90 = dielectric_f90 * (1 - bsdf.metallic) + bsdf.metallic;
    const RGB dielectric = bsdf.diffuse * (1 - bsdf.metallic);
    const float through = refracts ? 0 : bsdf.diffuse_transmission;
    const float scattered = inside ? 0 : 1 - bsdf.transmission_weight;
    diffuse = dielectric * (scattered * (1 - through));
    diffuse_through = bsdf.transmission * ((1 - bsdf.metallic) * scattered * through);
    transmitted = dielectric * bsdf.transmission_weight;
    curves = schlick_curves(smooth ? 0 : table_alpha(bsdf.alpha_x, bsdf.alpha_y));

    coat = inside ? 0 : bsdf.coat;
    coat_smooth = is_smooth(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_lobe = lobe_of_alpha(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_microfacet = rough(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_f0 = square((bsdf.coat_eta - 1) / (bsdf.coat_eta + 1));
    if (bsdf.coat > 0) coat_curves = schlick_curves(coat_smooth ? 0 : bsdf.coat_alpha);
    tilted = bsdf.coat_normal.z != 1;
    if (tilted) coat_frame = Frame::from_normal(bsdf.coat_normal);
    sheen = refracts ? RGB(0.0f) : clamp(bsdf.sheen, 0, 1);
    if (!is_black(sheen)) sheen_lobe = Sheen(bsdf.sheen_alpha);
    film_eta = bsdf.film_eta;
    film_thickness = bsdf.film_thickness;
    iridescence = film_thickness > 0 ? bsdf.iridescence : 0;
    if (iridescence > 0) film_mean = mean_film_albedo();
  }

  /// Reflectance of the film on a base of this reflectance at normal incidence, seen from the thinner side.
  RGB film(float cosine, RGB base) const { return film_reflectance(cosine, film_eta, film_thickness, base); }
  /// Directional albedo of facets under the film: Schlick's term with the film's reflectance at this angle.
  RGB film_albedo(float cosine, RGB base) const {
    const RGB f = film(cosine, base);
    const float t = schlick_term(cosine), kept = std::max(1e-4f, 1 - t);
    return clamp((f - RGB(t)) / kept, 0, 1) * curves.scale(cosine) + RGB(curves.bias(cosine));
  }
  RGB mean_film_albedo() const {
    RGB sum(0.0f);  // three-point Gauss quadrature over the squared cosine
    constexpr float kNodes[3][2] = {{0.1127017f, 0.2777778f}, {0.5f, 0.4444444f}, {0.8872983f, 0.2777778f}};
    for (const auto& [square_of_cosine, weight] : kNodes)
      sum += film_albedo(std::sqrt(square_of_cosine), dielectric_f0) * weight;
    return sum;
  }
  /// The direction relative to the coat's normal; z <= 0 if the coat is not visible.
  Vec3 about_coat(Vec3 w) const { return tilted ? coat_frame.to_local(w) : w; }
  /// The cosine that determines how much the coat weakens light to or from a direction above.
  float coat_cosine(Vec3 w) const {
    const float own = about_coat(w).z;
    return own > 0 ? own : w.z;
  }

  /// Converts to the cosine on the thinner side, for Schlick's term, so that both sides agree. Returns true at total
  /// reflection.
  bool totally_reflects(float& cosine) const {
    if (eta >= 1) return false;
    const float sin2 = (1 - cosine * cosine) / (eta * eta);
    cosine = std::sqrt(std::max(0.0f, 1 - sin2));
    return sin2 >= 1;
  }
  RGB fresnel(float cosine) const {
    if (totally_reflects(cosine)) return RGB(1.0f);
    const RGB plain = fresnel_schlick(cosine, f0, f90);
    if (!(iridescence > 0)) return plain;
    return lerp(plain, lerp(film(cosine, dielectric_f0), film(cosine, metal_f0), metallic), iridescence);
  }
  RGB dielectric_fresnel(float cosine) const {
    if (totally_reflects(cosine)) return RGB(1.0f);
    const RGB plain = fresnel_schlick(cosine, dielectric_f0, dielectric_f90);
    return iridescence > 0 ? lerp(plain, film(cosine, dielectric_f0), iridescence) : plain;
  }
  /// Share transmitted, not reflected, at a facet.
  RGB passed(float cosine) const { return transmitted * (RGB(1.0f) - dielectric_fresnel(cosine)); }

  /// E of the dielectric part of the specular layer.
  RGB layer_albedo(float cosine) const {
    const RGB plain = dielectric_f0 * curves.scale(cosine) + RGB(dielectric_f90 * curves.bias(cosine));
    return iridescence > 0 ? lerp(plain, film_albedo(cosine, dielectric_f0), iridescence) : plain;
  }
  RGB mean_layer_albedo() const {
    const RGB plain = dielectric_f0 * curves.mean_scale + RGB(dielectric_f90 * curves.mean_bias);
    return iridescence > 0 ? lerp(plain, film_mean, iridescence) : plain;
  }
  /// Share of light between two directions that passes the sheen.
  float under_sheen(float cosine_o, float cosine_i) const {
    if (is_black(sheen)) return 1;
    return 1 - max_component(sheen) * std::max(sheen_lobe.albedo(cosine_o), sheen_lobe.albedo(cosine_i));
  }
  float coat_albedo(float cosine) const { return coat_f0 * coat_curves.scale(cosine) + coat_curves.bias(cosine); }
  /// Share of light to or from an outside direction that passes the clearcoat.
  float under_coat(float weight, float cosine) const { return weight > 0 ? 1 - weight * coat_albedo(cosine) : 1.0f; }

  /// f / (1 - E(wi)) of a diffuse base of this albedo.
  RGB diffuse_factor(float cosine_o, RGB diffuse) const {
    const RGB lost = RGB(1.0f) - mean_layer_albedo();
    const RGB kept = RGB(1.0f) - layer_albedo(cosine_o);
    const auto channel = [](float d, float k, float l) { return l > 1e-6f ? d * kInversePi * k / l : 0.0f; };
    return {channel(diffuse.r, kept.r, lost.r), channel(diffuse.g, kept.g, lost.g), channel(diffuse.b, kept.b, lost.b)};
  }
};

/// Values for a viewer's direction, shared by all directions of light.
struct Viewed {
  RGB diffuse, through;  // diffuse_factor()
  float under;           // under_coat()
  Vec3 about_coat;
  Viewed(const Layers& layers, Vec3 wo)
      : diffuse(layers.diffuse_factor(wo.z, layers.diffuse)),
        through(layers.diffuse_factor(wo.z, layers.diffuse_through)),
        under(layers.under_coat(layers.coat, layers.coat_cosine(wo))),
        about_coat(layers.about_coat(wo)) {}
};

/// min(1, n.w / z) of a coat of normal n.
float coat_share(Vec3 about_coat, Vec3 w) { return std::min(1.0f, about_coat.z / w.z); }

float reflected_by_coat(const Layers& layers, const Viewed& viewed, Vec3 wo, Vec3 wi) {
  const Vec3 o = viewed.about_coat, i = layers.about_coat(wi);
  if (o.z <= 0 || i.z <= 0) return 0;
  const Vec3 h = reflection_half(o, i);
  const float fresnel = fresnel_schlick(dot(o, h), RGB(layers.coat_f0), 1).r;
  return layers.coat * fresnel * microfacet_reflection(layers.coat_microfacet, o, i, h) * coat_share(o, wo) *
         coat_share(i, wi);
}

RGB reflected(const Layers& layers, const View& view, Vec3 wi, const Viewed& viewed) {
  RGB f(0.0f);
  if (view.lobes & kDiffuseReflection) f += viewed.diffuse * (RGB(1.0f) - layers.layer_albedo(wi.z));
  if (!layers.smooth && (view.lobes & layers.lobe)) {
    const Vec3 h = reflection_half(view.wo, wi);
    f += layers.fresnel(dot(view.wo, h)) * microfacet_reflection(layers.microfacet, view.wo, wi, h);
  }
  if (!is_black(layers.sheen)) {
    f *= layers.under_sheen(view.wo.z, wi.z);
    if (view.lobes & kDiffuseReflection) f += layers.sheen * layers.sheen_lobe.evaluate(view.wo, wi);
  }
  if (layers.coat <= 0) return f;
  f *= viewed.under * layers.under_coat(layers.coat, layers.coat_cosine(wi));
  if (!layers.coat_smooth && (view.lobes & layers.coat_lobe)) f += RGB(reflected_by_coat(layers, viewed, view.wo, wi));
  return f;
}

RGB let_through(const Layers& layers, const View& view, Vec3 wi, const Viewed& viewed) {
  RGB f(0.0f);
  const Vec3 wo = view.wo, mirrored{wi.x, wi.y, -wi.z};
  const bool rough = !layers.smooth && (view.lobes & layers.lobe) && !is_black(layers.transmitted);
  if (layers.refracts) {
    const Vec3 h = refraction_half(wo, wi, layers.eta);
    if (!rough || h.z <= 0) return f;
    // Only the outside direction is above coat and sheen.
    const float under = layers.inside ? layers.under_coat(view.bsdf.coat, layers.coat_cosine(mirrored)) : viewed.under;
    return layers.passed(dot(wo, h)) * (under * microfacet_refraction(layers.microfacet, wo, wi, h, layers.eta));
  }
  if (view.lobes & kDiffuseTransmission) f += viewed.through * (RGB(1.0f) - layers.layer_albedo(mirrored.z));
  if (rough) {
    const Vec3 h = reflection_half(wo, mirrored);
    f += layers.passed(dot(wo, h)) * microfacet_reflection(layers.microfacet, wo, mirrored, h);
  }
  return f * (layers.under_sheen(wo.z, mirrored.z) * viewed.under *
              layers.under_coat(layers.coat, layers.coat_cosine(mirrored)));
}

void add_coat(const Layers& layers, const View& view, Components& out) {
  if (layers.coat <= 0) return;
  const Vec3 o = layers.about_coat(view.wo);
  Component c;
  c.shape = layers.coat_smooth ? Shape::mirror : Shape::rough_reflection;
  c.lobe = layers.coat_lobe;
  c.microfacet = layers.coat_microfacet;
  if (layers.tilted) c.normal = layers.coat_frame.n;
  c.albedo = RGB(layers.coat * (o.z > 0 ? layers.coat_albedo(o.z) * coat_share(o, view.wo) : 1e-3f));
  if (layers.coat_smooth && layers.tilted) {
    // Exact, like all albedos of deltas: f times the cosine to the surface's normal over that to the coat's.
    const Vec3 wi = reflect(view.wo, c.normal);
    if (o.z <= 0 || wi.z <= 0) return;
    c.albedo *= coat_share(o, wi) * (wi.z / o.z);
  }
  out.add(c);
}

/// Directional albedos of the specular reflection and transmission without the coat: exact if smooth. Refraction by a
/// rough surface, and all light from inside it, uses a dielectric's exact Fresnel term, because total reflection
/// dominates.
void specular_albedos(const Layers& layers, const View& view, RGB& reflected, RGB& passed) {
  const float cosine = view.wo.z;
  if (layers.smooth) {
    reflected = layers.fresnel(cosine);
    passed = layers.passed(cosine);
    return;
  }
  const float scale = layers.curves.scale(cosine), bias = layers.curves.bias(cosine);
  reflected = layers.f0 * scale + RGB(layers.f90 * bias);
  passed = layers.transmitted * (RGB(scale + bias) - layers.layer_albedo(cosine));
  if (layers.iridescence > 0) {
    const RGB film = lerp(layers.film_albedo(cosine, layers.dielectric_f0), layers.film_albedo(cosine, layers.metal_f0),
                          layers.metallic);
    reflected = lerp(reflected, film, layers.iridescence);
    passed = layers.transmitted * std::max(1e-3f, scale + bias - mean(layers.layer_albedo(cosine)));
  }
  if (!layers.refracts) return;
  const float alpha = table_alpha(view.bsdf.alpha_x, view.bsdf.alpha_y);
  const float t = boundary_curve(layers.inside ? Boundary::transmit_inside : Boundary::transmit_outside, alpha,
                                 layers.dense)(cosine);
  // Schlick's term reflects more than the exact one at grazing angles.
  passed = layers.transmitted *
           (layers.inside ? t : std::min(t, std::max(1e-3f, 1 - max_component(layers.layer_albedo(cosine)))));
  if (!layers.inside) return;
  const float r = boundary_curve(Boundary::reflect_inside, alpha, layers.dense)(cosine);
  reflected = RGB(r) + view.bsdf.diffuse * (view.bsdf.metallic * t);
}

}  // namespace

void evaluate_metallic_roughness(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Layers layers(view);
  const Viewed viewed(layers, view.wo);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    return w.z > 0 ? reflected(layers, view, w, viewed) : let_through(layers, view, w, viewed);
  });
}

IsotropicReflection reflection_of_metallic_roughness(const Bsdf& bsdf, float cosine_o) {
  const Layers layers(View{bsdf, false, {0, 0, cosine_o}, kBroad});
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.diffuse = layers.diffuse_factor(cosine_o, layers.diffuse);
  out.first = layers.f0;
  out.first_grazing = layers.f90;
  out.second = layers.dielectric_f0;
  out.second_grazing = layers.dielectric_f90;
  out.curve[0] = layers.curves.scale;
  out.curve[1] = layers.curves.bias;
  return out;
}

void metallic_roughness_components(const View& view, Components& out) {
  const Layers layers(view);
  const float cosine = view.wo.z, under = layers.under_coat(layers.coat, layers.coat_cosine(view.wo));
  add_coat(layers, view, out);
  Component c;
  c.lobe = layers.lobe;
  c.microfacet = layers.microfacet;
  c.eta = layers.eta;
  RGB reflected, passed;
  specular_albedos(layers, view, reflected, passed);
  c.shape = layers.smooth ? Shape::mirror : Shape::rough_reflection;
  // Coat and sheen also weaken light on the way out.
  const Vec3 mirror{-view.wo.x, -view.wo.y, view.wo.z};
  const float under_mirror =
      under * layers.under_coat(layers.coat, layers.coat_cosine(mirror)) * layers.under_sheen(cosine, cosine);
  c.albedo = reflected * under_mirror;
  out.add(c);
  if (layers.smooth)
    c.shape = layers.refracts ? Shape::refraction : Shape::straight;
  else
    c.shape = layers.refracts ? Shape::rough_refraction : Shape::rough_straight;
  c.albedo = passed * (layers.refracts ? under : under_mirror);
  if (layers.inside) {
    const float sin2 = (1 - cosine * cosine) / (layers.eta * layers.eta);
    Vec3 outside{-view.wo.x / layers.eta, -view.wo.y / layers.eta, std::sqrt(std::max(1e-6f, 1 - sin2))};
    c.albedo *= layers.under_coat(view.bsdf.coat, layers.coat_cosine(outside));
  }
  out.add(c);

  float spread = under * layers.under_sheen(cosine, 2.0f / 3);  // the mean cosine of diffuse light
  if (layers.coat > 0)
    spread *= 1 - layers.coat * (layers.coat_f0 * layers.coat_curves.mean_scale + layers.coat_curves.mean_bias);
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = layers.diffuse * (RGB(1.0f) - layers.layer_albedo(cosine)) * spread;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.lobe = kDiffuseTransmission;
  c.albedo = layers.diffuse_through * (RGB(1.0f) - layers.layer_albedo(cosine)) * spread;
  out.add(c);
  if (is_black(layers.sheen)) return;
  c.shape = Shape::uniform_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = layers.sheen * (under * std::max(layers.sheen_lobe.albedo(cosine), 1e-3f));
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
