#include "transport/light_connection.h"

#include <algorithm>
#include <cmath>

#include "core/offset_origin.h"

namespace glowworm {

namespace {

/// Relative error of a shadow ray's length and direction: 16 half units in the last place.
constexpr float kShadowError = 0x1p-20f;

/// The ray from a point to a place on a light, both offset from their surfaces. If rounding leaves nothing between
/// them, the ray meets nothing.
/// @param side the geometric normal on the side of the light
Ray shadow_ray(const Vertex& vertex, Vec3 side, const LightSample& light) {
  const SurfacePoint& point = vertex.point;
  const Vec3 from = offset_origin(point.position, side, point.offset);
  if (!std::isfinite(light.distance)) return {from, 0, light.direction, light.distance, vertex.time};
  const float before_light = light.offset + kShadowError * light.distance;
  const Vec3 way = offset_origin(light.position, light.normal, before_light) - from;
  const float distance = length(way);
  const bool crossed = !(dot(way, side) > 0) || (!light.delta && !(dot(way, light.normal) < 0));
  if (crossed) return {from, 0, light.direction, 0, vertex.time};
  // A point light has no side to offset to.
  return {from, 0, way / distance, light.delta ? distance * (1 - kShadowError) : distance, vertex.time};
}

/// Share of a light sample that the volume between the light and the point leaves.
RGB remaining(const Scene& scene, const LightSample& light, const SurfacePoint& point) {
  if (point.triangle == kNone || !std::isfinite(light.distance)) return RGB(1.0f);
  const std::vector<std::uint32_t>& lamps = scene.emissive_triangles();
  const RGB arrived =
      light.source < lamps.size() ? absorption(scene, lamps[light.source], -light.direction) : RGB(0.0f);
  return transmittance(absorption(scene, point.triangle, light.direction), arrived, light.distance);
}
}  // namespace

UnoccludedLight reflected_light(const Scene& scene, const LightSample& light, const Vertex& vertex, RGB scattered,
                                float weight) {
  const Vec3 side = face_forward(vertex.point.geometric_normal, light.direction);
  return {scattered * light.radiance * (weight / light.pdf) * remaining(scene, light, vertex.point),
          shadow_ray(vertex, side, light), light.source};
}

bool takes_light_samples(const Bsdf& bsdf) {
  const bool one_roughness = bsdf.kind == BsdfKind::conductor || bsdf.kind == BsdfKind::dielectric;
  return !(bsdf.kind == BsdfKind::thin_dielectric ||
           (one_roughness && std::max(bsdf.alpha_x, bsdf.alpha_y) < kSmoothAlpha));
}

}  // namespace glowworm
