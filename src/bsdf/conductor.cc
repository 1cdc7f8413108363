#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/multiple.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {
namespace {

/// The mean Fresnel term is Schlick's for the same reflectance at normal incidence.
MultipleReflection multiple_of(const Bsdf& bsdf) {
  return {mirror_curve(rough(bsdf.alpha_x, bsdf.alpha_y)), mean_schlick(fresnel_of_base(bsdf, 1, 1), 1)};
}

}  // namespace

void evaluate_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Vec3 wo = view.wo;
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || !(view.lobes & lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y)))
    return fill_black(out);
  const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
  const MultipleReflection multiple = multiple_of(bsdf);
  const RGB factor = multiple.factor(place_of(m, wo));
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    const Vec3 h = reflection_half(wo, w);
    return fresnel_of_base(bsdf, dot(wo, h), 1) * microfacet_reflection(m, wo, w, h) +
           factor * multiple.lost(place_of(m, w));
  });
}

IsotropicReflection reflection_of_conductor(const Bsdf& bsdf, float cosine_o) {
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.first = bsdf.use_reflectance ? bsdf.specular : bsdf.eta;
  if (!bsdf.use_reflectance) out.second = bsdf.k;
  if (out.alpha == 0) return out;
  const MultipleReflection multiple = multiple_of(bsdf);
  out.multiple = multiple.factor({cosine_o});
  const SchlickCurves curves = schlick_curves(rough(bsdf.alpha_x, bsdf.alpha_y));
  out.curve[0] = curves.scale;
  out.curve[1] = curves.bias;
  return out;
}

void conductor_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  Component c;
  c.lobe = lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
  c.albedo = fresnel_of_base(bsdf, view.wo.z, 1);
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y)) {
    c.shape = Shape::mirror;
    return out.add(c);
  }
  c.shape = Shape::rough_reflection;
  c.microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
  // Facets are seen at less grazing angles than the surface. Schlick's angular term, averaged over them, approximates
  // the exact formula's.
  const MultipleReflection multiple = multiple_of(bsdf);
  const Place at = place_of(c.microfacet, view.wo);
  const SchlickCurves curves = schlick_curves(c.microfacet);
  c.albedo = fresnel_of_base(bsdf, 1, 1) * curves.scale(at) + RGB(curves.bias(at));
  out.add(c);
  c.shape = Shape::cosine_reflection;
  c.albedo = multiple.color * multiple.lost(at);
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
