// glTF 2.0's metallic-roughness material (Khronos, "glTF 2.0 Specification", appendix B) with KHR_materials_ior,
// specular, clearcoat, transmission, sheen, iridescence and diffuse_transmission.
//
// The appendix does not define an energy-conserving coupling of layers (B.2.3, "fresnel_mix"; its own sample does not
// conserve energy at grazing angles). Here a white material reflects all light, and dark ones look as the appendix has
// them:
// - The diffuse base gets what the layers above it leave: c D(wo) D(wi) / (pi mean D), where D(w) is the share of the
//   light from w that coat, sheen and a dielectric's facets do not reflect. It is reciprocal and has the albedo c D(wo)
//   (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", 2001,
//   eq. 5).
// - A metal gets the same with W for D: what coat, sheen and facets of reflectance 1 do not reflect. It meets the metal
//   more than once, as in multiple.h.
// - Facets under the clearcoat are weakened at both directions by the Fresnel term of a smooth coat. Light that the
// coat
//   returns as it would at normal incidence meets the facets again in the same lobe, other light is part of D and W.
// - Transmission passes through each facet that does not reflect. Thin: straight through, spread by the same lobe
//   mirrored. Not thin: refracted; the surface then has an inside, which sees neither coat nor diffuse reflection.
//   Light that meets several facets leaves on both sides (multiple.h).
// - Diffuse light is reflected or transmitted, by KHR_materials_diffuse_transmission; not on refracting surfaces.
// - Sheen is on top of all layers except the coat (not on refracting surfaces). It weakens facets by the larger of its
//   albedos at the two directions (KHR_materials_sheen, "Albedo-scaling technique").
// - A coat with another normal n has f = f_n min(1, n.wo / z_o) min(1, n.wi / z_i), which is reciprocal and reflects at
//   most as much as about its own normal. D and W then take the coat's cosine to n; their means are those of the
//   surface's own normal.
#include <array>
#include <optional>

#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/multiple.h"
#include "bsdf/sheen.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {
namespace {

float square(float x) { return x * x; }

/// Cosines of an outside direction, and the share of the coat that is seen from it.
struct Cosines {
  float surface, coat;
  float coat_share = 1;
};

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
  float again;  // share of light from the base that the coat returns as at normal incidence
  Frame coat_frame;
  SchlickCurves curves, dielectric_curves, coat_curves;
  RGB sheen;
  Sheen sheen_lobe;
  float iridescence, film_eta, film_thickness;
  RGB metal_f0;
  float metallic;
  RGB mean_left;    // mean over directions of D
  float mean_rest;  // of W
  RGB rest_color;   // share of W that the metal reflects, times metallic

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
    again = coat * coat_f0;
    if (tilted) coat_frame = Frame::from_normal(bsdf.coat_normal);
    sheen = refracts ? RGB(0.0f) : clamp(bsdf.sheen, 0, 1);
    if (!is_black(sheen)) sheen_lobe = Sheen(bsdf.sheen_alpha);
    film_eta = bsdf.film_eta;
    film_thickness = bsdf.film_thickness;
    iridescence = film_thickness > 0 ? bsdf.iridescence : 0;
    set_means();
  }

  /// Reflectance of the film on a base of this reflectance at normal incidence, seen from the thinner side.
  RGB film(float cosine, RGB base) const { return film_reflectance(cosine, film_eta, film_thickness, base); }
  /// Reflectance of the film on facets as they are seen from this direction on average.
  RGB mean_film(float cosine, RGB base) const {
    const float scale = curves.scale(cosine), bias = curves.bias(cosine);
    return film(1 - std::pow(bias / std::max(1e-6f, scale + bias), 0.2f), base);
  }
  /// The direction relative to the coat's normal; z <= 0 if the coat is not visible.
  Vec3 about_coat(Vec3 w) const { return tilted ? coat_frame.to_local(w) : w; }
  /// The cosine that determines how much the coat weakens light to or from a direction above.
  float coat_cosine(Vec3 w) const {
    const float own = about_coat(w).z;
    return own > 0 ? own : w.z;
  }
  Cosines cosines(Vec3 w) const {
    if (!tilted || !(coat > 0)) return {w.z, w.z};
    const float own = about_coat(w).z;
    return {w.z, coat_cosine(w), std::clamp(own / w.z, 0.0f, 1.0f)};
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
  RGB metal_fresnel(float cosine) const {
    if (totally_reflects(cosine)) return RGB(1.0f);
    const RGB plain = fresnel_schlick(cosine, metal_f0, 1);
    return iridescence > 0 ? lerp(plain, film(cosine, metal_f0), iridescence) : plain;
  }
  /// fresnel() of light that meets the facet again, of which the coat returns r.
  RGB reflectance(float cosine, float r) const {
    if (!(r > 0)) return fresnel(cosine);
    const RGB dielectric = dielectric_fresnel(cosine), metal = metal_fresnel(cosine);
    return lerp(dielectric * meets_again(dielectric, r), metal * meets_again(metal, r), metallic);
  }
  /// Share transmitted, not reflected, at a facet.
  RGB passed(float cosine) const { return transmitted * (RGB(1.0f) - dielectric_fresnel(cosine)); }

  /// Share of light between two directions that passes the sheen.
  float under_sheen(float cosine_o, float cosine_i) const {
    if (is_black(sheen)) return 1;
    return 1 - max_component(sheen) * std::max(sheen_lobe.albedo(cosine_o), sheen_lobe.albedo(cosine_i));
  }
  /// Share of light to or from an outside direction that passes a smooth coat.
  float under_coat(float weight, float cosine) const {
    return weight > 0 ? 1 - weight * fresnel_schlick(cosine, RGB(coat_f0), 1).r : 1.0f;
  }
  float coat_albedo(float cosine) const { return coat_f0 * coat_curves.scale(cosine) + coat_curves.bias(cosine); }

  /// Factor on a facet's reflection of this reflectance for light that meets it again, of which the coat returns r.
  static float meets_again(float fresnel, float r) { return 1 / std::max(1e-6f, 1 - fresnel * r); }
  static RGB meets_again(RGB f, float r) { return {meets_again(f.r, r), meets_again(f.g, r), meets_again(f.b, r)}; }
  /// The same for light that passes the facet: of a pane both sides return it.
  RGB passes_again(RGB f, float r) const { return meets_again(f, r) * (refracts ? 1 : 1 / (1 - r)); }

  /// Share of the light from outside that facets reflect with Schlick's Fresnel term, under coat and sheen.
  float facets(Cosines at, float f0, float f90) const {
    const float passed = under_coat(coat, at.coat), scale = curves.scale(at.surface), bias = curves.bias(at.surface);
    float share;
    if (smooth) {
      const float f = f0 * scale + f90 * bias;
      share = f * passed * meets_again(f, 1 - passed);
    } else {
      const float a = f0 * meets_again(f0, again), b = f90 * meets_again(f90, again);
      share = a * scale + b * bias;
      if (coat > 0)
        share =
            (1 - again) * share - (coat - again) * (a * curves.scale_out(at.surface) + b * curves.bias_out(at.surface));
    }
    return share * passed * under_sheen(at.surface, at.surface);
  }
  RGB facets(Cosines at, RGB f0, RGB f90) const {
    return {facets(at, f0.r, f90.r), facets(at, f0.g, f90.g), facets(at, f0.b, f90.b)};
  }
  /// The same with a film, for a base of this reflectance at normal and grazing incidence.
  RGB film_facets(Cosines at, RGB base, float f90) const {
    const RGB plain = facets(at, base, RGB(f90));
    if (!(iridescence > 0)) return plain;
    const RGB f = mean_film(at.surface, base);
    return lerp(plain, facets(at, f, f), iridescence);
  }
  RGB dielectric_facets(Cosines at) const { return film_facets(at, dielectric_f0, dielectric_f90); }
  /// Share that coat and sheen reflect.
  float on_top(Cosines at) const {
    float share = coat > 0 ? coat * coat_albedo(at.coat) * at.coat_share : 0;
    if (!is_black(sheen))
      share += under_coat(coat, at.coat) * max_component(sheen) * sheen_lobe.albedo(at.surface) * mean_under_coat();
    return share;
  }
  /// Mean share of light that passes a smooth coat.
  float mean_under_coat() const { return 1 - coat * mean_schlick(RGB(coat_f0), 1).r; }
  /// D.
  RGB left(Cosines at) const { return clamp(RGB(1 - on_top(at)) - dielectric_facets(at), 0, 1); }
  /// W.
  float rest(Cosines at) const { return std::max(0.0f, 1 - on_top(at) - facets(at, 1.0f, 1.0f)); }

  /// f over D(wi) of a diffuse base of this albedo. The coat returns some of the light from all that is under it.
  RGB diffuse_factor(RGB left_o, RGB base) const {
    const float passed = mean_under_coat();
    const RGB total = clamp(diffuse + diffuse_through + transmitted + metal_f0 * metallic, 0, 1);
    RGB out;
    for (int c = 0; c < 3; ++c)
      out[c] = base[c] * kInversePi * over_mean(left_o[c], mean_left[c]) * passed / (1 - total[c] * (1 - passed));
    return out;
  }
  /// f over W(wi) of light that meets the metal more than once.
  RGB rest_factor(float rest_o) const { return rest_color * (kInversePi * over_mean(rest_o, mean_rest)); }

 private:
  void set_means() {
    if (!(coat > 0) && is_black(sheen) && !(iridescence > 0)) {
      mean_left = RGB(1.0f) - dielectric_f0 * curves.mean_scale - RGB(dielectric_f90 * curves.mean_bias);
      mean_rest = smooth ? 0 : std::max(0.0f, 1 - curves.mean_scale - curves.mean_bias);
    } else {
      mean_left = RGB(0.0f);
      mean_rest = 0;
      for_mean_cosines([&](float cosine, float weight) {
        mean_left += weight * left({cosine, cosine});
        mean_rest += weight * rest({cosine, cosine});
      });
    }
    rest_color = metallic * multiple_color(mean_schlick(metal_f0, 1), std::min(1.0f, mean_rest / mean_under_coat()));
  }
};

/// Light that meets several facets of a surface that transmits (multiple.h), for a viewer on one side.
struct MultipleTransmission {
  const Layers& layers;
  Curve near[3], far[3];  // of refracting surfaces: Boundary::schlick_lost_*
  RGB mean_near, mean_far;
  RGB reflection, transmission;       // factors of f
  RGB reflected_share, passed_share;  // of the light lost from the viewer's side

  MultipleTransmission(const Layers& material, const Bsdf& bsdf) : layers(material) {
    const RGB transmitted = RGB(1.0f) - mean_schlick(layers.dielectric_f0, layers.dielectric_f90);
    if (layers.refracts) {
      using enum Boundary;
      const float alpha = table_alpha(bsdf.alpha_x, bsdf.alpha_y);
      read({schlick_lost_outside, schlick_lost_f0_outside, schlick_lost_f90_outside}, alpha, layers.inside ? far : near,
           layers.inside ? mean_far : mean_near);
      read({schlick_lost_inside, schlick_lost_f0_inside, schlick_lost_f90_inside}, alpha, layers.inside ? near : far,
           layers.inside ? mean_near : mean_far);
    } else {
      mean_near = mean_far = RGB(layers.mean_rest);
    }
    const float weight = (1 - layers.metallic) * bsdf.transmission_weight;
    for (int c = 0; c < 3; ++c) {
      float passing = multiple_passing(transmitted[c], mean_near[c], mean_far[c]);
      if (layers.inside) passing *= layers.eta * layers.eta;
      passed_share[c] = layers.transmitted[c] * over_mean(passing, mean_near[c]);
      reflected_share[c] = weight * (1 - over_mean(passing, mean_near[c]));
      reflection[c] = kInversePi * reflected_share[c];
      // Radiance is scaled by the squared index of the viewer's side over that of the other.
      transmission[c] = layers.transmitted[c] * kInversePi * passing;
      if (layers.refracts) transmission[c] /= layers.eta * layers.eta;
    }
  }
  /// @param cosines of the direction, mirrored to the outside unless the surface refracts
  RGB lost_near(Cosines at) const { return lost(near, at); }
  RGB lost_far(Cosines at) const { return lost(far, at); }
  RGB over_mean_near(RGB lost) const { return divide(lost, mean_near); }
  RGB over_mean_far(RGB lost) const { return divide(lost, mean_far); }

 private:
  static RGB divide(RGB a, RGB b) { return {over_mean(a.r, b.r), over_mean(a.g, b.g), over_mean(a.b, b.b)}; }
  RGB combined(float own, float by_f0, float by_f90) const {
    return clamp(layers.dielectric_f0 * by_f0 + RGB(own + layers.dielectric_f90 * by_f90), 0, 1);
  }
  RGB lost(const Curve* curves, Cosines at) const {
    if (!layers.refracts) return RGB(layers.rest(at));
    return combined(curves[0](at.surface), curves[1](at.surface), curves[2](at.surface));
  }
  void read(const std::array<Boundary, 3>& of, float alpha, Curve* curves, RGB& mean) const {
    float means[3];
    for (std::size_t i = 0; i < 3; ++i) {
      curves[i] = boundary_curve(of[i], alpha, layers.dense);
      means[i] = boundary_mean(of[i], alpha, layers.dense);
    }
    mean = combined(means[0], means[1], means[2]);
  }
};

/// Share of the light of several facets to or from an outside direction that passes the coat; of panes, W has it.
float multiple_under(const Layers& layers, const Bsdf& bsdf, Vec3 w) {
  return layers.refracts ? layers.under_coat(bsdf.coat, layers.coat_cosine(w)) : 1;
}

/// Values for a viewer's direction, shared by all directions of light.
struct Viewed {
  RGB diffuse, through;  // diffuse_factor()
  RGB rest;              // rest_factor()
  float under;           // under_coat()
  Vec3 about_coat;
  std::optional<MultipleTransmission> multiple;
  RGB lost;  // of `multiple`, over its mean

  Viewed(const Layers& layers, const View& view)
      : under(layers.under_coat(layers.coat, layers.coat_cosine(view.wo))), about_coat(layers.about_coat(view.wo)) {
    const Cosines at = layers.cosines(view.wo);
    if (view.lobes & (kDiffuseReflection | kDiffuseTransmission)) {
      const RGB left = layers.left(at);
      diffuse = layers.diffuse_factor(left, layers.diffuse);
      through = layers.diffuse_factor(left, layers.diffuse_through);
    }
    if (!(view.lobes & layers.lobe)) return;
    if (layers.metallic > 0) rest = layers.rest_factor(layers.rest(at));
    if (layers.smooth || is_black(layers.transmitted)) return;
    multiple.emplace(layers, view.bsdf);
    lost = multiple->over_mean_near(multiple->lost_near(at));
    if (!layers.inside) lost *= multiple_under(layers, view.bsdf, view.wo);
  }
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
  const Cosines at = layers.cosines(wi);
  const float under = viewed.under * layers.under_coat(layers.coat, at.coat);
  if (view.lobes & kDiffuseReflection) f += viewed.diffuse * layers.left(at);
  if (view.lobes & layers.lobe) {
    if (layers.metallic > 0) f += viewed.rest * layers.rest(at);
    if (viewed.multiple) {
      const float above = layers.inside ? 1 : multiple_under(layers, view.bsdf, wi);
      f += viewed.multiple->reflection * viewed.lost * viewed.multiple->lost_near(at) * above;
    }
    if (!layers.smooth) {
      const Vec3 h = reflection_half(view.wo, wi);
      f += layers.reflectance(dot(view.wo, h), layers.again) *
           (microfacet_reflection(layers.microfacet, view.wo, wi, h) * under * layers.under_sheen(view.wo.z, wi.z));
    }
  }
  if (!is_black(layers.sheen) && (view.lobes & kDiffuseReflection))
    f += layers.sheen * (layers.sheen_lobe.evaluate(view.wo, wi) * under);
  if (layers.coat > 0 && !layers.coat_smooth && (view.lobes & layers.coat_lobe))
    f += RGB(reflected_by_coat(layers, viewed, view.wo, wi));
  return f;
}

RGB let_through(const Layers& layers, const View& view, Vec3 wi, const Viewed& viewed) {
  RGB f(0.0f);
  const Vec3 wo = view.wo, mirrored{wi.x, wi.y, -wi.z};
  const Cosines at = layers.cosines(mirrored);
  if (view.lobes & kDiffuseTransmission) f += viewed.through * layers.left(at);
  if (!viewed.multiple) return f;
  const float above = layers.inside ? multiple_under(layers, view.bsdf, mirrored) : 1;
  f += viewed.multiple->transmission * viewed.lost * viewed.multiple->over_mean_far(viewed.multiple->lost_far(at)) *
       above;
  if (!layers.refracts) {
    const Vec3 h = reflection_half(wo, mirrored);
    const float under = viewed.under * layers.under_coat(layers.coat, at.coat);
    return f + layers.passed(dot(wo, h)) * layers.passes_again(layers.dielectric_fresnel(dot(wo, h)), layers.again) *
                   (microfacet_reflection(layers.microfacet, wo, mirrored, h) * under *
                    layers.under_sheen(wo.z, mirrored.z));
  }
  const Vec3 h = refraction_half(wo, wi, layers.eta);
  if (h.z <= 0) return f;
  // Only the outside direction is above coat and sheen.
  const float under = layers.inside ? layers.under_coat(view.bsdf.coat, layers.coat_cosine(mirrored)) : viewed.under;
  return f + layers.passed(dot(wo, h)) * (under * microfacet_refraction(layers.microfacet, wo, wi, h, layers.eta));
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

/// Albedos of the lobes of facets that reflect and transmit.
struct FacetAlbedos {
  RGB reflected, passed;
};

/// The direction outside of light that a smooth surface refracts from inside; close to the horizon at total reflection.
Vec3 refracted_outside(const Layers& layers, Vec3 wo) {
  const float sin2 = (1 - wo.z * wo.z) / (layers.eta * layers.eta);
  return {-wo.x / layers.eta, -wo.y / layers.eta, std::sqrt(std::max(1e-6f, 1 - sin2))};
}

/// Exact, of smooth facets. Light goes to and fro between coat and facets.
FacetAlbedos smooth_albedos(const Layers& layers, const View& view) {
  const Vec3 wo = view.wo, mirror{-wo.x, -wo.y, wo.z};
  const RGB dielectric = layers.dielectric_fresnel(wo.z), passed = layers.passed(wo.z);
  if (layers.inside) {
    const float under = layers.under_coat(view.bsdf.coat, layers.coat_cosine(refracted_outside(layers, wo)));
    const float returned = 1 - under;
    const RGB again = layers.meets_again(dielectric, returned);
    return {layers.fresnel(wo.z) + passed * passed * again * returned, passed * again * under};
  }
  const float under = layers.under_coat(layers.coat, layers.coat_cosine(wo));
  const float under_mirror = layers.under_coat(layers.coat, layers.coat_cosine(mirror)),
              sheen = layers.under_sheen(wo.z, wo.z);
  const float returned = 1 - std::max(under, under_mirror), both = under * under_mirror * sheen;
  return {layers.reflectance(wo.z, returned) * both,
          passed * layers.passes_again(dielectric, returned) * (layers.refracts ? under : both)};
}

/// Estimates for rough facets. Refraction, and all light from inside, uses a dielectric's exact Fresnel term, because
/// total reflection dominates.
FacetAlbedos rough_albedos(const Layers& layers, const View& view) {
  const float cosine = view.wo.z;
  const Cosines at = layers.cosines(view.wo);
  const RGB dielectric = layers.dielectric_facets(at);
  FacetAlbedos out;
  out.reflected = lerp(dielectric, layers.film_facets(at, layers.metal_f0, 1), layers.metallic);
  if (!layers.refracts) {
    out.passed = layers.transmitted * clamp(RGB(layers.facets(at, 1.0f, 1.0f)) - dielectric, 1e-3f, 1);
    return out;
  }
  const float alpha = table_alpha(view.bsdf.alpha_x, view.bsdf.alpha_y);
  const float t = boundary_curve(layers.inside ? Boundary::transmit_inside : Boundary::transmit_outside, alpha,
                                 layers.dense)(cosine);
  if (!layers.inside) {
    // Schlick's term reflects more than the exact one at grazing angles.
    out.passed = layers.transmitted * std::min(t, std::max(1e-3f, 1 - max_component(dielectric))) *
                 layers.under_coat(layers.coat, layers.coat_cosine(view.wo));
    return out;
  }
  const float r = boundary_curve(Boundary::reflect_inside, alpha, layers.dense)(cosine);
  // A metal reflects what a dielectric does at total reflection, and its colour of what that would transmit.
  const float transmitted = std::max(0.0f, layers.curves.scale(cosine) + layers.curves.bias(cosine) - r);
  out.reflected = RGB(r) + layers.metal_f0 * (layers.metallic * transmitted);
  out.passed = layers.transmitted *
               (t * layers.under_coat(view.bsdf.coat, layers.coat_cosine(refracted_outside(layers, view.wo))));
  return out;
}

void add_facets(const Layers& layers, const View& view, Components& out) {
  const FacetAlbedos albedos = layers.smooth ? smooth_albedos(layers, view) : rough_albedos(layers, view);
  Component c;
  c.lobe = layers.lobe;
  c.microfacet = layers.microfacet;
  c.shape = layers.smooth ? Shape::mirror : Shape::rough_reflection;
  c.albedo = albedos.reflected;
  out.add(c);
  if (layers.refracts) c.eta = layers.eta;
  if (layers.smooth)
    c.shape = layers.refracts ? Shape::refraction : Shape::straight;
  else
    c.shape = layers.refracts ? Shape::rough_refraction : Shape::rough_straight;
  c.albedo = albedos.passed;
  out.add(c);
  const Cosines at = layers.cosines(view.wo);
  c.shape = Shape::cosine_reflection;
  c.albedo = layers.rest_color * layers.rest(at);
  out.add(c);
  if (layers.smooth || is_black(layers.transmitted)) return;
  const MultipleTransmission multiple(layers, view.bsdf);
  RGB lost = multiple.lost_near(at);
  if (!layers.inside) lost *= multiple_under(layers, view.bsdf, view.wo);
  c.albedo = multiple.reflected_share * lost;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.albedo = multiple.passed_share * lost;
  out.add(c);
}

void add_diffuse(const Layers& layers, const View& view, Components& out) {
  const float cosine = view.wo.z, under = layers.under_coat(layers.coat, layers.coat_cosine(view.wo));
  const RGB left = layers.left(layers.cosines(view.wo));
  Component c;
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = layers.diffuse_factor(left, layers.diffuse) * layers.mean_left * kPi;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.lobe = kDiffuseTransmission;
  c.albedo = layers.diffuse_factor(left, layers.diffuse_through) * layers.mean_left * kPi;
  out.add(c);
  if (is_black(layers.sheen)) return;
  c.shape = Shape::uniform_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = layers.sheen * (under * std::max(layers.sheen_lobe.albedo(cosine), 1e-3f));
  out.add(c);
}

}  // namespace

void evaluate_metallic_roughness(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Layers layers(view);
  const Viewed viewed(layers, view);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    return w.z > 0 ? reflected(layers, view, w, viewed) : let_through(layers, view, w, viewed);
  });
}

IsotropicReflection reflection_of_metallic_roughness(const Bsdf& bsdf, float cosine_o) {
  const Layers layers(View{bsdf, false, {0, 0, cosine_o}, kBroad});
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  const Cosines at{cosine_o, cosine_o};
  out.diffuse = layers.diffuse_factor(layers.left(at), layers.diffuse);
  if (out.alpha > 0) out.multiple = layers.rest_factor(layers.rest(at));
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
  add_coat(layers, view, out);
  add_facets(layers, view, out);
  add_diffuse(layers, view, out);
}

}  // namespace glowworm::bsdf_detail
