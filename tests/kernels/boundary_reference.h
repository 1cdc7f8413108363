#pragma once
#include "core/vec.h"
#include "kernels/boundary.h"

namespace glowworm {

namespace {

Vec3 vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
Vec3 vec(const float* const (&axes)[3], std::size_t i) { return {axes[0][i], axes[1][i], axes[2][i]}; }

double profile_within(KernelShape shape, double squared) { return squared < 1 ? kernel_profile(shape, squared) : 0; }

}  // namespace

/// The kernels of kernels/boundary.h as plain loops. The hits have the same bits.
inline std::size_t segment_hits_reference(const SegmentArrays& segments, const CornerAndEdges& triangle, float first,
                                          std::uint32_t* segment, float* distance) {
  const Vec3 corner = vec(triangle.corner), e = vec(triangle.edge[0]), f = vec(triangle.edge[1]);
  std::size_t found = 0;
  for (std::size_t i = 0; i < segments.count; ++i) {
    const Vec3 d = vec(segments.direction, i), s = vec(segments.origin, i) - corner;
    const Vec3 p = cross(d, f), q = cross(s, e);
    const float inverse = 1 / dot(e, p);
    const float u = dot(s, p) * inverse, v = dot(d, q) * inverse, t = dot(f, q) * inverse;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t >= first && t <= 1)) continue;
    segment[found] = static_cast<std::uint32_t>(i);
    distance[found++] = t;
  }
  return found;
}

inline double sum_at_places_reference(KernelShape shape, const WeightedPlaces& places, const KernelBall& ball,
                                      float min_cosine) {
  double sum = 0;
  for (std::size_t i = 0; i < places.count; ++i) {
    if (!(dot(vec(places.normal, i), vec(ball.normal)) > min_cosine)) continue;
    const double squared = length_squared(vec(places.position, i) - vec(ball.position));
    sum += places.weight[i] * profile_within(shape, squared * ball.inverse_squared_radius);
  }
  return sum;
}

inline double sum_on_plane_reference(KernelShape shape, const float* x, const float* y, std::size_t count,
                                     const KernelBall& ball) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - ball.position[0], dy = y[i] - ball.position[1];
    const double dz = -(dx * ball.normal[0] + dy * ball.normal[1]) / ball.normal[2];
    sum += profile_within(shape, (dx * dx + dy * dy + dz * dz) * ball.inverse_squared_radius);
  }
  return sum;
}

}  // namespace glowworm
