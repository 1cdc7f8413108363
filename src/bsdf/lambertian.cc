#include "bsdf/component.h"

namespace glowworm::bsdf_detail {

void evaluate_lambertian(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const RGB above = view.lobes & kDiffuseReflection ? view.bsdf.diffuse * kInversePi : RGB(0.0f);
  const RGB below = view.lobes & kDiffuseTransmission ? view.bsdf.transmission * kInversePi : RGB(0.0f);
  for_each_direction(view, wi, out, [&](Vec3 w) { return w.z > 0 ? above : below; });
}

void lambertian_components(const View& view, Components& out) {
  Component c;
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = view.bsdf.diffuse;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.lobe = kDiffuseTransmission;
  c.albedo = view.bsdf.transmission;
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
