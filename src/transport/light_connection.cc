#include "transport/light_connection.h"

#include <algorithm>
#include <cmath>

#include "core/offset_origin.h"

namespace glowworm {

namespace {

/// The ray from a place to a light, offset from the light. If rounding leaves nothing between the two, it meets
/// nothing.
/// @param side the geometric normal on the side of the light; (0,0,0): the place is on no surface
Ray ray_to_light(Vec3 from, Vec3 side, const LightSample& light, float time) {
  if (!std::isfinite(light.distance)) return {from, 0, light.direction, light.distance, time};
  const float before_light = light.offset + kShadowError * light.distance;
  const Vec3 way = offset_origin(light.position, light.normal, before_light) - from;
  const float distance = length(way);
  const bool leaves = side == Vec3{0, 0, 0} || dot(way, side) > 0, arrives = light.delta || dot(way, light.normal) < 0;
  if (!leaves || !arrives) return {from, 0, light.direction, 0, time};
  // A point light has no side to offset to.
  return {from, 0, way / distance, light.delta ? distance * (1 - kShadowError) : distance, time};
}

}  // namespace

UnoccludedLight reflected_light(const LightSample& light, const Vertex& vertex, RGB scattered, float weight) {
  const Vec3 side = face_forward(vertex.point.geometric_normal, light.direction);
  const Vec3 from = offset_origin(vertex.point.position, side, vertex.point.offset);
  return {scattered * light.radiance * (weight / light.pdf), ray_to_light(from, side, light, vertex.time), light.source,
          vertex.media.towards(light.direction, vertex.normal()), light.random};
}

UnoccludedLight scattered_light(const LightSample& light, const MediumVertex& vertex, float weight) {
  if (!(light.pdf > 0)) return {};
  return {light.radiance * (vertex.phase(light.direction) * weight / light.pdf),
          ray_to_light(vertex.position, {0, 0, 0}, light, vertex.time), light.source, vertex.medium, light.random};
}

RGB passed_share(const Tracer& tracer, const UnoccludedLight& light) {
  const Scene& scene = tracer.scene();
  const Ray& shadow = light.shadow_ray;
  if (scene.media().empty()) return tracer.transmittance(shadow);
  std::vector<PassedSurface> surfaces;
  if (!tracer.passes(shadow, surfaces)) return RGB(0.0f);
  PathMedium medium = light.medium;
  RGB product(1.0f);
  float start = 0;
  const auto pass = [&](std::uint32_t triangle, float end) {
    medium = medium_until(scene, medium, triangle, shadow.direction);
    const Ray piece{shadow.origin + shadow.direction * start, 0, shadow.direction, end - start, shadow.time};
    if (medium.index != kNone) {
      const Medium& crossed = scene.media()[medium.index];
      product *= light.random ? estimate_transmittance(crossed, piece, end - start, *light.random)
                              : transmittance(crossed, piece, end - start);
    }
    start = end;
  };
  for (const PassedSurface& surface : surfaces) {
    // A surface that rays pass only where it is absent parts no media there.
    const bool parts = scene.is_pane(scene.geometry().material_of(surface.triangle));
    if (parts) pass(surface.triangle, surface.distance);
    if (!is_interface(scene, surface.triangle))
      product *= straight_transmittance(scene, surface.triangle, surface.barycentric, shadow.direction);
    if (parts) medium = medium_behind(scene, medium, surface.triangle, shadow.direction);
  }
  const std::vector<std::uint32_t>& lamps = scene.emissive_triangles();
  pass(light.source < lamps.size() ? lamps[light.source] : kNone, shadow.t_max);
  return product;
}

std::vector<RGB> passed_shares(const Tracer& tracer, std::span<const UnoccludedLight> lights) {
  std::vector<RGB> passed(lights.size());
  if (tracer.scene().media().empty()) {
    std::vector<Ray> rays;
    rays.reserve(lights.size());
    for (const UnoccludedLight& light : lights) rays.push_back(light.shadow_ray);
    tracer.transmittance(rays, passed);
  } else {
    for (std::size_t i = 0; i < lights.size(); ++i) passed[i] = passed_share(tracer, lights[i]);
  }
  return passed;
}

void LightAdder::add(std::vector<RGB>& part, std::uint32_t slot, RGB factor, const UnoccludedLight& light) {
  if (is_black(light.radiance)) return;
  ++shadow_rays;
  const RGB passed = passed_share(tracer_, light);
  if (!is_black(passed)) radiance_.add(part, slot, factor * light.radiance * passed, light.source);
}

void LightAdder::wait(std::uint32_t slot, const UnoccludedLight& light) {
  if (is_black(light.radiance)) return;
  waiting_.push_back(light);
  slots_.push_back(slot);
}

void LightAdder::add_waiting(std::vector<RGB>& part) {
  const std::vector<RGB> passed = passed_shares(tracer_, waiting_);
  for (std::size_t i = 0; i < passed.size(); ++i)
    if (!is_black(passed[i])) radiance_.add(part, slots_[i], waiting_[i].radiance * passed[i], waiting_[i].source);
  shadow_rays += waiting_.size();
  waiting_.clear();
  slots_.clear();
}

bool takes_light_samples(const Bsdf& bsdf) {
  const bool one_roughness = bsdf.kind == BsdfKind::conductor || bsdf.kind == BsdfKind::dielectric;
  return !(bsdf.kind == BsdfKind::thin_dielectric ||
           (one_roughness && std::max(bsdf.alpha_x, bsdf.alpha_y) < kSmoothAlpha));
}

}  // namespace glowworm
