#include "transport/step.h"

#include <limits>

#include "core/offset_origin.h"

namespace glowworm {

bool leave(PathState& path, const Vertex& vertex, const ScatteredRay& sampled, RGB weight) {
  path.throughput *= weight;
  if (!sampled.valid || is_black(path.throughput)) return false;
  const SurfacePoint& point = vertex.point;
  if (!sampled.is_null) {
    path.pdf = sampled.delta ? 0 : sampled.pdf;
    path.scattered_at = point.position;
  }
  path.medium = vertex.media.towards(sampled.direction, vertex.normal());
  path.ray = leave_surface(point.position, sampled.side, point.offset, sampled.direction, vertex.time);
  return true;
}

Ray leave_surface(Vec3 position, Vec3 side, float offset, Vec3 direction, float time) {
  return {offset_origin(position, side, offset), 0, direction, std::numeric_limits<float>::infinity(), time};
}

}  // namespace glowworm
