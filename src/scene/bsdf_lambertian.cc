#include "scene/bsdf_component.h"

namespace glowworm::bsdf_detail {

RGB evaluate_lambertian(const Bsdf& bsdf, Vec3, Vec3 wi, Lobes lobes) {
  if (wi.z > 0) return lobes & kDiffuseReflection ? bsdf.diffuse * kInversePi : RGB(0.0f);
  return wi.z < 0 && (lobes & kDiffuseTransmission) ? bsdf.transmission * kInversePi : RGB(0.0f);
}

void lambertian_components(const Bsdf& bsdf, Components& out) {
  Component c;
  c.shape = Shape::cosine_reflection;
  c.lobe = kDiffuseReflection;
  c.albedo = bsdf.diffuse;
  out.add(c);
  c.shape = Shape::cosine_transmission;
  c.lobe = kDiffuseTransmission;
  c.albedo = bsdf.transmission;
  out.add(c);
}

}  // namespace glowworm::bsdf_detail
