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
// - Facets under the clearcoat are weakened at both directions by the Fresnel term of a smooth coat. For a rough coat,
//   Schlick's term of the coat's mean albedo takes its place. Light that the coat returns as it would at normal
//   incidence meets the facets again in the same lobe, other light is part of D and W.
// - Transmission passes through each facet that does not reflect. Thin: straight through, spread by the same lobe
//   mirrored. Not thin: refracted; the surface then has an inside, which does not see the coat. There, the share that
//   does not transmit is paint on the glass: it reflects diffusely, without facets. Light that meets several facets
//   leaves on both sides (multiple.h).
// - Diffuse light is reflected or transmitted, by KHR_materials_diffuse_transmission; not on refracting surfaces.
// - Sheen is on top of all layers except the coat (not on refracting surfaces). It weakens facets by the larger of its
//   albedos at the two directions (KHR_materials_sheen, "Albedo-scaling technique").
// - A coat with another normal n has f = f_n min(1, n.wo / z_o) min(1, n.wi / z_i), which is reciprocal and reflects at
//   most as much as about its own normal. Layers below are weakened as by a coat of the surface's normal.
#include <array>
#include <optional>

#include "bsdf/layers.h"

namespace glowworm::bsdf_detail {
namespace {

/// Light that meets several facets of a surface that transmits (multiple.h), for a viewer on one side: what the coat
/// and the lobes of one facet leave of the light.
struct MultipleTransmission {
  const Layers& layers;
  Curve outside[3], inside[3];              // of refracting surfaces: Boundary::schlick_lost_*
  Curve passed_inside[3], passed_under[3];  // under a coat: Boundary::schlick_passed_*
  RGB mean_near, mean_far;
  RGB reflection, transmission;       // factors of f
  RGB reflected_share, passed_share;  // of the light lost from the viewer's side

  MultipleTransmission(const Layers& material, const Bsdf& bsdf) : layers(material) {
    const RGB transmitted = RGB(1.0f) - mean_schlick(layers.dielectric_f0, layers.dielectric_f90);
    if (layers.refracts) {
      RGB mean_outside, mean_inside;
      set_boundary(mean_outside, mean_inside);
      mean_near = layers.inside ? mean_inside : mean_outside;
      mean_far = layers.inside ? mean_outside : mean_inside;
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
      // Radiance is scaled by the squared relative index of the viewer's side.
      transmission[c] = layers.transmitted[c] * kInversePi * passing;
      if (layers.refracts) transmission[c] /= layers.eta * layers.eta;
    }
  }
  /// @param w above; for the far side, mirrored to above
  RGB lost_near(Vec3 w) const { return layers.inside ? from_inside(w) : from_outside(w); }
  RGB lost_far(Vec3 w) const { return layers.inside || !layers.refracts ? from_outside(w) : from_inside(w); }
  /// Share of the light from an outside direction that facets refract at once, without what coat and film do.
  RGB passed_outside(const Seen& at) const {
    const RGB reflected = layers.dielectric_f0 * at.scale + RGB(layers.dielectric_f90 * at.bias);
    return RGB(1.0f) - reflected - combined(outside, at.place);
  }
  RGB over_mean_near(RGB lost) const { return divide(lost, mean_near); }
  RGB over_mean_far(RGB lost) const { return divide(lost, mean_far); }

 private:
  static RGB divide(RGB a, RGB b) { return {over_mean(a.r, b.r), over_mean(a.g, b.g), over_mean(a.b, b.b)}; }
  RGB combined(float own, float by_f0, float by_f90) const {
    return layers.dielectric_f0 * by_f0 + RGB(own + layers.dielectric_f90 * by_f90);
  }
  RGB combined(const Curve* curves, Place at) const { return combined(curves[0](at), curves[1](at), curves[2](at)); }
  RGB from_outside(Vec3 w) const {
    const Seen at = layers.outside(w);
    if (!layers.refracts) return RGB(layers.rest(at));
    if (!(layers.coat > 0)) return clamp(combined(outside, at.place), 0, 1);
    return clamp(RGB(1 - at.coat) - layers.dielectric_facets(at) - passed_outside(at) * at.under, 0, 1);
  }
  RGB from_inside(Vec3 w) const {
    const Place at = place_of(layers.microfacet, w);
    RGB lost = combined(inside, at);
    if (layers.coat > 0) {
      // The coat returns some of the light that passes the facets.
      lost += passed(passed_inside, at) * (layers.coat * layers.under_f0);
      lost += passed(passed_under, at) * (layers.coat * (layers.under_f90 - layers.under_f0));
    }
    return clamp(lost, 0, 1);
  }
  RGB passed(const Curve* curves, Place at) const { return combined(curves[0](at), -curves[1](at), -curves[2](at)); }

  void set_boundary(RGB& mean_outside, RGB& mean_inside) {
    using enum Boundary;
    const BoundaryTable table(layers.microfacet, layers.dense);
    mean_outside = read(table, {schlick_lost_outside, schlick_lost_f0_outside, schlick_lost_f90_outside}, outside);
    mean_inside = read(table, {schlick_lost_inside, schlick_lost_f0_inside, schlick_lost_f90_inside}, inside);
    if (!(layers.coat > 0)) return;
    read(table, {schlick_passed, schlick_passed_f0, schlick_passed_f90}, passed_inside);
    read(table, {schlick_passed_out, schlick_passed_f0_out, schlick_passed_f90_out}, passed_under);
    mean_outside = mean_inside = RGB(0.0f);
    for_mean_directions(layers.microfacet, [&](Vec3 w, float weight) {
      mean_outside += weight * from_outside(w);
      mean_inside += weight * from_inside(w);
    });
  }
  /// Reads curves, and returns their mean over directions.
  RGB read(const BoundaryTable& table, const std::array<Boundary, 3>& of, Curve* curves) const {
    float means[3];
    for (std::size_t i = 0; i < 3; ++i) {
      curves[i] = table.curve(of[i]);
      means[i] = table.mean(of[i]);
    }
    return clamp(combined(means[0], means[1], means[2]), 0, 1);
  }
};

/// Values for a viewer's direction, shared by all directions of light.
struct Viewed {
  Seen at;
  RGB diffuse, through;  // diffuse_factor()
  RGB rest;              // rest_factor()
  Vec3 about_coat;
  std::optional<MultipleTransmission> multiple;
  RGB lost;  // of `multiple`, over its mean

  Viewed(const Layers& layers, const View& view) : at(layers.near(view.wo)), about_coat(layers.about_coat(view.wo)) {
    if (view.lobes & (kDiffuseReflection | kDiffuseTransmission)) {
      const RGB left = layers.left(at);
      diffuse = layers.diffuse_factor(left, layers.diffuse);
      through = layers.diffuse_factor(left, layers.diffuse_through);
    }
    if (!(view.lobes & layers.lobe)) return;
    if (layers.metallic > 0) rest = layers.rest_factor(layers.rest(at));
    if (layers.smooth || is_black(layers.transmitted)) return;
    multiple.emplace(layers, view.bsdf);
    lost = multiple->over_mean_near(multiple->lost_near(view.wo));
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
  const Seen at = layers.near(wi);
  const float under = viewed.at.under * at.under;
  if (view.lobes & kDiffuseReflection) f += viewed.diffuse * layers.left(at);
  if (view.lobes & layers.lobe) {
    if (layers.metallic > 0) f += viewed.rest * layers.rest(at);
    if (viewed.multiple) f += viewed.multiple->reflection * viewed.lost * viewed.multiple->lost_near(wi);
    if (!layers.smooth) {
      const Vec3 h = reflection_half(view.wo, wi);
      f += layers.reflectance(dot(view.wo, h), at.again) *
           (microfacet_reflection(layers.microfacet, view.wo, wi, h) * under * layers.under_sheen(view.wo.z, wi.z));
    }
  }
  if (!is_black(layers.sheen) && (view.lobes & kDiffuseReflection))
    f += layers.sheen * (layers.sheen_lobe.evaluate(view.wo, wi) * under);
  if (layers.coat > 0 && !layers.inside && !layers.coat_smooth && (view.lobes & layers.coat_lobe))
    f += RGB(reflected_by_coat(layers, viewed, view.wo, wi));
  return f;
}

RGB let_through(const Layers& layers, const View& view, Vec3 wi, const Viewed& viewed) {
  RGB f(0.0f);
  const Vec3 wo = view.wo, mirrored{wi.x, wi.y, -wi.z};
  if (view.lobes & kDiffuseTransmission) f += viewed.through * layers.left(layers.outside(mirrored));
  if (!viewed.multiple) return f;
  const MultipleTransmission& multiple = *viewed.multiple;
  f += multiple.transmission * viewed.lost * multiple.over_mean_far(multiple.lost_far(mirrored));
  if (!layers.refracts) {
    const Vec3 h = reflection_half(wo, mirrored);
    const float under = viewed.at.under * layers.under_coat(mirrored);
    return f + layers.passed(dot(wo, h)) * layers.passes_again(layers.dielectric_fresnel(dot(wo, h)), viewed.at.again) *
                   (microfacet_reflection(layers.microfacet, wo, mirrored, h) * under *
                    layers.under_sheen(wo.z, mirrored.z));
  }
  const Vec3 h = refraction_half(wo, wi, layers.eta);
  if (h.z <= 0) return f;
  // Only the outside direction is above coat and sheen.
  const float under = layers.inside ? layers.under_coat(mirrored) : viewed.at.under;
  return f + layers.passed(dot(wo, h)) * (under * microfacet_refraction(layers.microfacet, wo, wi, h, layers.eta));
}

void add_coat(const Layers& layers, const View& view, Components& out) {
  if (!(layers.coat > 0) || layers.inside) return;
  const Vec3 o = layers.about_coat(view.wo);
  Component c;
  c.shape = layers.coat_smooth ? Shape::mirror : Shape::rough_reflection;
  c.lobe = layers.coat_lobe;
  c.microfacet = layers.coat_microfacet;
  if (layers.tilted) c.normal = layers.coat_frame.n;
  // Of a rough coat, some light is at directions of which little is expected.
  c.albedo = RGB(std::max(layers.near(view.wo).coat, layers.coat_smooth ? 0 : 1e-3f * layers.coat));
  if (layers.coat_smooth && layers.tilted && (o.z <= 0 || reflect(view.wo, c.normal).z <= 0)) return;
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
  const Vec3 wo = view.wo;
  const RGB dielectric = layers.dielectric_fresnel(wo.z), passed = layers.passed(wo.z);
  if (layers.inside) {
    const float under = layers.direct_under_coat(refracted_outside(layers, wo)), returned = 1 - under;
    const RGB again = layers.meets_again(dielectric, returned);
    return {layers.fresnel(wo.z) + passed * passed * again * returned, passed * again * under};
  }
  const Seen at = layers.outside(wo);
  const float returned = 1 - std::max(at.direct, at.direct_mirror);
  const float both = at.direct * at.direct_mirror * layers.under_sheen(wo.z, wo.z);
  return {layers.reflectance(wo.z, returned) * both,
          passed * layers.passes_again(dielectric, returned) * (layers.refracts ? at.direct : both)};
}

/// Estimates for rough facets. All light from inside uses a dielectric's exact Fresnel term, because total reflection
/// dominates.
/// @param multiple null if nothing is transmitted
FacetAlbedos rough_albedos(const Layers& layers, const View& view, const MultipleTransmission* multiple) {
  const Seen at = layers.near(view.wo);
  const RGB dielectric = layers.dielectric_facets(at);
  FacetAlbedos out;
  out.reflected = lerp(dielectric, layers.metal_facets(at), layers.metallic);
  if (!layers.refracts) {
    out.passed = layers.transmitted * clamp(RGB(layers.facets(at, 1.0f, 1.0f)) - dielectric, 1e-3f, 1);
    return out;
  }
  if (!layers.inside) {
    if (multiple) out.passed = layers.transmitted * clamp(multiple->passed_outside(at), 1e-3f, 1) * at.under;
    return out;
  }
  const BoundaryTable table(layers.microfacet, layers.dense);
  const auto read = [&](Boundary what) { return table.curve(what)(at.place); };
  const float t = read(Boundary::transmit_inside), r = read(Boundary::reflect_inside);
  // A metal reflects what a dielectric does at total reflection, and its colour of what that would transmit.
  const float transmitted = std::max(0.0f, at.scale + at.bias - r);
  out.reflected =
      lerp(RGB(r * layers.clear), RGB(r), layers.metallic) + layers.metal_f0 * (layers.metallic * transmitted);
  float returned = 0;
  if (layers.coat > 0) {
    const float all = read(Boundary::schlick_passed), grazing = read(Boundary::schlick_passed_out);
    returned = layers.coat * (layers.under_f0 + (layers.under_f90 - layers.under_f0) * (all > 0 ? grazing / all : 0));
  }
  out.passed = layers.transmitted * (t * (1 - returned));
  return out;
}

void add_facets(const Layers& layers, const View& view, Components& out) {
  std::optional<MultipleTransmission> multiple;
  if (!layers.smooth && !is_black(layers.transmitted)) multiple.emplace(layers, view.bsdf);
  const FacetAlbedos albedos =
      layers.smooth ? smooth_albedos(layers, view) : rough_albedos(layers, view, multiple ? &*multiple : nullptr);
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
  c.shape = Shape::cosine_reflection;
  c.albedo = layers.rest_color * layers.rest(layers.near(view.wo));
  out.add(c);
  if (!multiple) return;
  const RGB lost = multiple->lost_near(view.wo);
  c.albedo = multiple->reflected_share * lost;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.albedo = multiple->passed_share * lost;
  out.add(c);
}

void add_diffuse(const Layers& layers, const View& view, Components& out) {
  const Seen at = layers.near(view.wo);
  const RGB left = layers.left(at);
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
  c.albedo = layers.sheen * (at.under * std::max(layers.sheen_lobe.albedo(view.wo.z), 1e-3f));
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
  const Seen at = layers.near({std::sqrt(std::max(0.0f, 1 - cosine_o * cosine_o)), 0, cosine_o});
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
