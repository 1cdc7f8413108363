#include "photon/start_media.h"

#include "core/offset_origin.h"

namespace glowworm {

namespace {

/// The medium that a lamp names on a side, or that the surfaces around tell.
PathMedium on_side(const Tracer& tracer, std::uint32_t triangle, Vec3 side) {
  const DiffuseTriangle t = tracer.scene().diffuse_triangle(triangle);
  const Vec3 middle = t.corner + (t.edge[0] + t.edge[1]) / 3;
  const PathMedium around = medium_at_start(tracer, offset_origin(middle, side, t.offset()), side);
  const PathMedium named = medium_behind(tracer.scene(), around, triangle, side);
  return named.named ? named : around;
}

}  // namespace

StartMedia::StartMedia(const Tracer& tracer) {
  const Scene& scene = tracer.scene();
  if (scene.media().empty()) return;
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    const Vec3 normal = scene.diffuse_triangle(triangle).normal;
    sides_.push_back({on_side(tracer, triangle, normal), on_side(tracer, triangle, -normal)});
  }
  around_ = {scene.ambient_medium(), false};
  for (const Light& light : scene.lights()) {
    const bool is_far = light.kind == LightKind::directional;
    const PathMedium around = is_far ? around_ : medium_at_start(tracer, light.position, light.direction);
    sides_.push_back({around, around});
  }
  for (const MediumEmission& emission : scene.emissive_media()) {
    const PathMedium own{emission.medium(), false};
    sides_.push_back({own, own});
  }
}

bool is_outside_of_medium(const Tracer& tracer, const EmittedPhoton& photon) {
  const MediumEmission* const emission = tracer.scene().medium_of_source(photon.light);
  return emission && !is_black(photon.flux) &&
         medium_at_start(tracer, photon.origin, photon.direction).index != emission->medium();
}

}  // namespace glowworm
