// Synthetic photons and query points on the surfaces of a box with clutter, for benchmarks that need no scene.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frame.h"
#include "core/random.h"
#include "core/warp.h"
#include "points/photon_batch.h"
#include "points/query_points.h"

namespace glowworm::bench {

/// A point of a surface: of the walls of a 10 m box seen from inside, or of one of sixty smaller boxes in it seen
/// from outside, by area. The box stands in no relation to the axes' cells.
struct CloudPlace {
  Vec3 position, normal;
};

inline CloudPlace cloud_place(Sampler& sampler) {
  constexpr int kBoxes = 60;
  const float which = sampler.next1();
  const Vec2 face_u = sampler.next2(), p = sampler.next2();
  const int face = std::min(static_cast<int>(face_u.x * 6), 5), axis = face % 3;
  const bool high = face >= 3;
  Vec3 position, normal{0, 0, 0};
  position[axis] = high ? 1.0f : 0.0f;
  position[(axis + 1) % 3] = p.x;
  position[(axis + 2) % 3] = p.y;
  if (which < 0.5f) {
    normal[axis] = high ? -1.0f : 1.0f;
    return {position * 10, normal};
  }
  Sampler box(SamplerKind::independent, 99, 0, static_cast<std::uint32_t>((which - 0.5f) * 2 * kBoxes));
  const Vec2 a = box.next2(), b = box.next2(), c = box.next2();
  const Vec3 low{a.x * 8, a.y * 8, b.x * 8}, size{0.5f + b.y, 0.5f + c.x, 0.5f + c.y};
  normal[axis] = high ? 1.0f : -1.0f;
  return {low + position * size, normal};
}

/// Photons over the surfaces, denser towards one corner, as near a light.
inline PhotonBatch cloud_photons(std::size_t count) {
  PhotonBatch photons;
  for (std::uint32_t i = 0; photons.size() < count; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 0, i);
    const CloudPlace at = cloud_place(sampler);
    if (sampler.next1() > 1 / (1 + 0.02f * length_squared(at.position))) continue;
    const Vec3 direction = Frame::from_normal(at.normal).to_world(square_to_cosine_hemisphere(sampler.next2()));
    photons.push_back(at.position, direction, RGB(1.0f, 0.8f, 0.6f), at.normal);
  }
  return photons;
}

/// Lambertian query points spread evenly over the same surfaces, in no spatial order.
inline QueryPoints cloud_queries(std::size_t count) {
  QueryPoints points;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 2, 0, i);
    const CloudPlace at = cloud_place(sampler);
    points.push_back(at.position, at.normal, RGB(0.5f), RGB(1.0f), i);
  }
  return points;
}

}  // namespace glowworm::bench
