#pragma once
#include <algorithm>

#include "core/random.h"
#include "core/warp.h"
#include "kernels/diffuse_rays.h"

namespace glowworm {

/// The kernels of kernels/diffuse_rays.h as plain loops over core/random.h and core/warp.h, bit for bit.
inline void diffuse_squares_reference(const DiffuseRayPoints& points, const DiffuseRayCell& cell,
                                      const DiffuseSquare& out) {
  for (std::size_t i = 0; i < points.count; ++i) {
    Sampler sampler(SamplerKind::sobol, cell.seed, hash_combine(points.sequence[i], cell.sequence_salt),
                    points.sample[i] * cell.sample_stride + cell.sample_offset);
    const Vec2 u = sampler.next2();
    out.x[i] = u.x * cell.side[0] + cell.low[0];
    out.y[i] = u.y * cell.side[1] + cell.low[1];
  }
}

inline void diffuse_rays_reference(const DiffuseRayPoints& points, const DiffuseSquare& square,
                                   const DiffuseRays& out) {
  for (std::size_t i = 0; i < points.count; ++i) {
    const Vec3 local = square_to_cosine_hemisphere({square.x[i], square.y[i]});
    float side = 0, normals = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float d =
          points.frame[axis][i] * local.x + points.frame[3 + axis][i] * local.y + points.frame[6 + axis][i] * local.z;
      out.direction[axis][i] = d;
      side += d * points.normal[axis][i];
      normals += points.frame[6 + axis][i] * points.normal[axis][i];
    }
    const float twice = 2 * side;
    if (side < 0)
      for (int axis = 0; axis < 3; ++axis) out.direction[axis][i] -= twice * points.normal[axis][i];
    out.cosine[i] = side != 0 ? local.z + std::max(local.z - twice * normals, 0.0f) : 0;
  }
}

}  // namespace glowworm
