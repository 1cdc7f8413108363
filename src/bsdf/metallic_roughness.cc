// glTF 2.0's metallic-roughness material (Khronos, "glTF 2.0 Specification", appendix B) with KHR_materials_ior,
// specular, clearcoat and transmission.
//
// The appendix leaves it open how layers are coupled so that energy is kept (B.2.3, "fresnel_mix"; its own sample is
// not energy conserving at grazing angles). Here:
// - Diffuse under the specular layer of directional albedo E: c / pi (1 - E(wo)) (1 - E(wi)) / (1 - mean E), reciprocal
//   and of albedo c (1 - E(wo)) exactly (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF
//   Model with Importance Sampling", 2001, eq. 5).
// - What lies under the clearcoat is weakened at both directions by 1 - coat E_coat.
// - Transmission passes each facet that does not reflect. Thin: straight on, spread by the same lobe mirrored. Not
// thin:
//   refracted, and then the surface has an inside, from which neither coat nor diffuse reflection is seen.
#include "bsdf/component.h"
#include "bsdf/fresnel.h"
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
  RGB f0;       // of the specular layer, dielectric and metal mixed
  float f90;
  RGB dielectric_f0;
  float dielectric_f90;
  RGB diffuse, transmitted;  // shares of the base colour that are scattered and transmitted
  float coat, coat_f0;
  SchlickCurves curves, dielectric_curves, coat_curves;

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
    f0 = lerp(dielectric_f0, bsdf.diffuse, bsdf.metallic);
    f90 = dielectric_f90 * (1 - bsdf.metallic) + bsdf.metallic;
    const RGB dielectric = bsdf.diffuse * (1 - bsdf.metallic);
    diffuse = inside ? RGB(0.0f) : dielectric * (1 - bsdf.transmission_weight);
    transmitted = dielectric * bsdf.transmission_weight;
    curves = schlick_curves(smooth ? 0 : table_alpha(bsdf.alpha_x, bsdf.alpha_y));

    coat = inside ? 0 : bsdf.coat;
    coat_smooth = is_smooth(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_lobe = lobe_of_alpha(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_microfacet = rough(bsdf.coat_alpha, bsdf.coat_alpha);
    coat_f0 = square((bsdf.coat_eta - 1) / (bsdf.coat_eta + 1));
    if (bsdf.coat > 0) coat_curves = schlick_curves(coat_smooth ? 0 : bsdf.coat_alpha);
  }

  /// Schlick's angle is the one on the thinner side, so that both sides agree; 1 for total reflection.
  RGB fresnel(float cosine, RGB at_normal, float at_grazing) const {
    if (eta < 1) {
      const float sin2 = (1 - cosine * cosine) / (eta * eta);
      if (sin2 >= 1) return RGB(1.0f);
      cosine = std::sqrt(1 - sin2);
    }
    return fresnel_schlick(cosine, at_normal, at_grazing);
  }
  RGB fresnel(float cosine) const { return fresnel(cosine, f0, f90); }
  RGB dielectric_fresnel(float cosine) const { return fresnel(cosine, dielectric_f0, dielectric_f90); }
  /// Share transmitted at a facet.
  RGB passed(float cosine) const { return transmitted * (RGB(1.0f) - dielectric_fresnel(cosine)); }

  /// E of the dielectric part of the specular layer.
  RGB layer_albedo(float cosine) const {
    return dielectric_f0 * curves.scale(cosine) + RGB(dielectric_f90 * curves.bias(cosine));
  }
  RGB mean_layer_albedo() const { return dielectric_f0 * curves.mean_scale + RGB(dielectric_f90 * curves.mean_bias); }
  float coat_albedo(float cosine) const { return coat_f0 * coat_curves.scale(cosine) + coat_curves.bias(cosine); }
  /// Share of light to or from an outside direction that passes the clearcoat.
  float under_coat(float weight, float cosine) const { return weight > 0 ? 1 - weight * coat_albedo(cosine) : 1.0f; }

  /// f / (1 - E(wi)) of the diffuse base.
  RGB diffuse_factor(float cosine_o) const {
    const RGB lost = RGB(1.0f) - mean_layer_albedo();
    const RGB kept = RGB(1.0f) - layer_albedo(cosine_o);
    const auto channel = [](float d, float k, float l) { return l > 1e-6f ? d * kInversePi * k / l : 0.0f; };
    return {channel(diffuse.r, kept.r, lost.r), channel(diffuse.g, kept.g, lost.g), channel(diffuse.b, kept.b, lost.b)};
  }
};

RGB reflected(const Layers& layers, const View& view, Vec3 wi, RGB diffuse, float under_o) {
  RGB f(0.0f);
  if (view.lobes & kDiffuseReflection) f += diffuse * (RGB(1.0f) - layers.layer_albedo(wi.z));
  if (!layers.smooth && (view.lobes & layers.lobe)) {
    const Vec3 h = reflection_half(view.wo, wi);
    f += layers.fresnel(dot(view.wo, h)) * microfacet_reflection(layers.microfacet, view.wo, wi, h);
  }
  if (layers.coat <= 0) return f;
  f *= under_o * layers.under_coat(layers.coat, wi.z);
  if (!layers.coat_smooth && (view.lobes & layers.coat_lobe)) {
    const Vec3 h = reflection_half(view.wo, wi);
    const float fresnel = fresnel_schlick(dot(view.wo, h), RGB(layers.coat_f0), 1).r;
    f += RGB(layers.coat * fresnel * microfacet_reflection(layers.coat_microfacet, view.wo, wi, h));
  }
  return f;
}

RGB let_through(const Layers& layers, const View& view, Vec3 wi, float under_o) {
  if (layers.smooth || !(view.lobes & layers.lobe) || is_black(layers.transmitted)) return RGB(0.0f);
  const Vec3 wo = view.wo;
  if (!layers.refracts) {
    const Vec3 mirrored{wi.x, wi.y, -wi.z}, h = reflection_half(wo, mirrored);
    return layers.passed(dot(wo, h)) * (microfacet_reflection(layers.microfacet, wo, mirrored, h) * under_o *
                                        layers.under_coat(layers.coat, mirrored.z));
  }
  const Vec3 h = refraction_half(wo, wi, layers.eta);
  if (h.z <= 0) return RGB(0.0f);
  // Only the direction outside is above the coat.
  const float under = layers.inside ? layers.under_coat(view.bsdf.coat, -wi.z) : under_o;
  return layers.passed(dot(wo, h)) * (under * microfacet_refraction(layers.microfacet, wo, wi, h, layers.eta));
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
  const RGB diffuse = layers.diffuse_factor(view.wo.z);
  const float under_o = layers.under_coat(layers.coat, view.wo.z);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    return w.z > 0 ? reflected(layers, view, w, diffuse, under_o) : let_through(layers, view, w, under_o);
  });
}

IsotropicReflection reflection_of_metallic_roughness(const Bsdf& bsdf, float cosine_o) {
  const Layers layers(View{bsdf, false, {0, 0, cosine_o}, kBroad});
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.diffuse = layers.diffuse_factor(cosine_o);
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
  const float cosine = view.wo.z, under = layers.under_coat(layers.coat, cosine);
  Component c;
  if (layers.coat > 0) {
    c.shape = layers.coat_smooth ? Shape::mirror : Shape::rough_reflection;
    c.lobe = layers.coat_lobe;
    c.microfacet = layers.coat_microfacet;
    c.albedo = RGB(layers.coat * layers.coat_albedo(cosine));
    out.add(c);
  }
  c.lobe = layers.lobe;
  c.microfacet = layers.microfacet;
  c.eta = layers.eta;
  RGB reflected, passed;
  specular_albedos(layers, view, reflected, passed);
  c.shape = layers.smooth ? Shape::mirror : Shape::rough_reflection;
  c.albedo = reflected * (under * under);  // the coat weakens again on the way out
  out.add(c);
  if (layers.smooth)
    c.shape = layers.refracts ? Shape::refraction : Shape::straight;
  else
    c.shape = layers.refracts ? Shape::rough_refraction : Shape::rough_straight;
  c.albedo = passed * (layers.refracts ? under : under * under);
  if (layers.inside) {
    const float sin2 = (1 - cosine * cosine) / (layers.eta * layers.eta);
    c.albedo *= layers.under_coat(view.bsdf.coat, std::sqrt(std::max(0.0f, 1 - sin2)));
  }
  out.add(c);

  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = layers.diffuse * (RGB(1.0f) - layers.layer_albedo(cosine)) * under;
  if (layers.coat > 0)
    c.albedo *= 1 - layers.coat * (layers.coat_f0 * layers.coat_curves.mean_scale + layers.coat_curves.mean_bias);
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
