#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {

void evaluate_conductor(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const Bsdf& bsdf = view.bsdf;
  const Vec3 wo = view.wo;
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || !(view.lobes & lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y)))
    return fill_black(out);
  const Microfacet m = rough(bsdf.alpha_x, bsdf.alpha_y);
  for_each_direction(view, wi, out, [&](Vec3 w) {
    if (w.z < 0) return RGB(0.0f);
    const Vec3 h = reflection_half(wo, w);
    return fresnel_of_base(bsdf, dot(wo, h), 1) * microfacet_reflection(m, wo, w, h);
  });
}

IsotropicReflection reflection_of_conductor(const Bsdf& bsdf) {
  IsotropicReflection out;
  out.alpha = broad_alpha(bsdf.alpha_x);
  out.first = bsdf.use_reflectance ? bsdf.specular : bsdf.eta;
  if (!bsdf.use_reflectance) out.second = bsdf.k;
  return out;
}

void conductor_components(const View& view, Components& out) {
  const Bsdf& bsdf = view.bsdf;
  Component c;
  c.lobe = lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
  c.albedo = fresnel_of_base(bsdf, view.wo.z, 1);
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y)) {
    c.shape = Shape::mirror;
  } else {
    c.shape = Shape::rough_reflection;
    c.microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
    // Facets are seen at less grazing angles than the surface. Schlick's angular term, averaged over them, approximates
    // that of the exact formula.
    const SchlickCurves schlick = schlick_curves(table_alpha(bsdf.alpha_x, bsdf.alpha_y));
    const RGB f0 = fresnel_of_base(bsdf, 1, 1);
    c.albedo = f0 * schlick.scale(view.wo.z) + RGB(schlick.bias(view.wo.z));
  }
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
