// Photons and query points on the surfaces of a box with clutter: what benchmarks of the density engines run on where
// no scene is traced.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "gather/query_points.h"
#include "photon/photon_batch.h"

namespace glowworm::bench {

/// A room of 10 x 4 x 6 metres with boxes and balls in it. Photons crowd towards one wall.
class SurfaceCloud {
 public:
  struct Point {
    Vec3 position, normal;
  };

  explicit SurfaceCloud(std::uint32_t seed) : seed_(seed) {
    add_box({0, 0, 0}, {10, 4, 6}, -1);
    for (std::uint32_t i = 0; i < 12; ++i) {
      Sampler sampler(SamplerKind::independent, 77, 0, i);
      const Vec2 a = sampler.next2(), b = sampler.next2();
      const Vec3 low{9 * a.x, 0, 5 * a.y};
      if (i % 3 == 0)
        balls_.push_back({{low.x + 0.5f, 0.4f + b.x, low.z + 0.5f}, 0.25f + 0.3f * b.y});
      else
        add_box(low, low + Vec3{0.2f + b.x, 0.3f + 1.5f * b.y, 0.3f + b.x * b.y}, 1);
    }
    for (const Quad& q : quads_) areas_.push_back(length(cross(q.u, q.v)));
    for (const Ball& b : balls_) areas_.push_back(4 * kPi * b.radius * b.radius);
    for (const float a : areas_) total_ += a;
  }

  /// @param crowding 0: even over all surfaces; 1: density falls off along x
  Point point(std::uint32_t i, float crowding) const {
    for (std::uint32_t attempt = 0;; ++attempt) {
      Sampler sampler(SamplerKind::independent, seed_, attempt, i);
      const Vec2 u = sampler.next2(), c = sampler.next2();
      float area = c.x * total_;
      std::size_t k = 0;
      while (k + 1 < areas_.size() && area > areas_[k]) area -= areas_[k++];
      Point p;
      if (k < quads_.size()) {
        const Quad& q = quads_[k];
        p = {q.origin + q.u * u.x + q.v * u.y, q.normal};
      } else {
        const Ball& b = balls_[k - quads_.size()];
        const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
        p.normal = {r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z};
        p.position = b.center + p.normal * b.radius;
      }
      const float keep = 1 - crowding * 0.9f * std::min(1.0f, std::max(0.0f, p.position.x / 10));
      if (c.y < keep) return p;
    }
  }

  PhotonBatch photons(std::size_t n) const {
    PhotonBatch batch;
    batch.resize(n);
    parallel_for(0, n, 4096, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Point p = point(static_cast<std::uint32_t>(i), 1);
        batch.position[i] = p.position;
        batch.normal[i] = p.normal;
        batch.direction[i] = p.normal;
        batch.flux[i] = RGB(1.0f, 0.9f, 0.8f) * (1.0f / static_cast<float>(n));
      }
    });
    return batch;
  }

  QueryPoints points(std::size_t n) const {
    QueryPoints points;
    points.position.resize(n);
    points.normal.resize(n);
    parallel_for(0, n, 4096, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Point p = point(static_cast<std::uint32_t>(i) ^ 0x80000000u, 0.3f);
        points.position[i] = p.position;
        points.normal[i] = p.normal;
      }
    });
    points.reflectance.assign(n, RGB(0.7f, 0.6f, 0.5f));
    points.bsdf.assign(n, kLambertianQuery);
    points.weight.assign(n, RGB(1.0f));
    points.gather_point.assign(n, 0);
    return points;
  }

 private:
  struct Quad {
    Vec3 origin, u, v, normal;
  };
  struct Ball {
    Vec3 center;
    float radius;
  };
  /// @param side 1: normals point outwards, -1: inwards
  void add_box(Vec3 low, Vec3 high, float side) {
    for (int axis = 0; axis < 3; ++axis)
      for (const bool upper : {false, true}) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        Quad q{low, {}, {}, {}};
        if (upper) q.origin[axis] = high[axis];
        q.u[a] = high[a] - low[a];
        q.v[b] = high[b] - low[b];
        q.normal[axis] = upper ? side : -side;
        quads_.push_back(q);
      }
  }

  std::uint32_t seed_;
  std::vector<Quad> quads_;
  std::vector<Ball> balls_;
  std::vector<float> areas_;
  float total_ = 0;
};

}  // namespace glowworm::bench
