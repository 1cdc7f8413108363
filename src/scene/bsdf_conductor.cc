#include "scene/bsdf_component.h"
#include "scene/bsdf_fresnel.h"

namespace glowworm::bsdf_detail {
namespace {

RGB fresnel(const Bsdf& bsdf, float cosine) {
  return bsdf.use_reflectance ? fresnel_schlick(cosine, bsdf.specular, 1) : fresnel_conductor(cosine, bsdf.eta, bsdf.k);
}

}  // namespace

RGB evaluate_conductor(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  if (is_smooth(bsdf.alpha_x, bsdf.alpha_y) || wi.z <= 0) return RGB(0.0f);
  const Vec3 h = reflection_half(wo, wi);
  return fresnel(bsdf, dot(wo, h)) * microfacet_reflection(rough(bsdf.alpha_x, bsdf.alpha_y), wo, wi, h);
}

void conductor_components(const Bsdf& bsdf, Vec3 wo, Components& out) {
  Component c;
  c.lobe = lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
  c.albedo = fresnel(bsdf, wo.z);
  c.shape = is_smooth(bsdf.alpha_x, bsdf.alpha_y) ? Shape::mirror : Shape::rough_reflection;
  c.microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
