// Rays against the triangles of a scene, in batches.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "glowworm/scene.h"

namespace glowworm::api {

/// Value of Hits::triangle where a ray hits nothing.
inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// Closest hits; arrays of one length, index i of ray i.
struct Hits {
  std::vector<float> distance;          ///< in lengths of the ray's direction; infinite for no hit
  std::vector<std::uint32_t> triangle;  ///< index into Scene::triangles(); kNoTriangle for no hit
  std::vector<Vec2> barycentric;        ///< weights of the second and third vertex
  std::vector<Vec3> normal;             ///< unit, by the winding of the triangle; (0,0,0) for no hit
};

/// Room for closest hits: memory of the caller, of one length. The members are as in Hits.
struct HitSpans {
  std::span<float> distance;
  std::span<std::uint32_t> triangle;
  std::span<Vec2> barycentric;
};

/// Rays, as arrays of one length n. Surfaces whose texture makes them absent let rays pass.
struct Rays {
  std::span<const Vec3> origin;     ///< n, metres
  std::span<const Vec3> direction;  ///< n; need not be unit
  /// Hits count between these, in lengths of the direction. A ray that leaves a surface needs a small t_min.
  float t_min = 0;
  std::span<const float> t_max;  ///< n, or 1 for all rays; empty: infinite
};

/// Traces rays. Several threads may use it.
class Tracer {
 public:
  explicit Tracer(const Scene& scene) : scene_(scene) {}

  /// Closest hits of a batch, on all threads; a batch of thousands is the fastest. Throws Error for arrays of different
  /// lengths, numbers that are not finite, and directions without length.
  Hits intersect(const Rays& rays) const;
  /// As above, into memory of the caller, without normals: the fastest. Throws Error if `hits` has another length.
  void intersect(const Rays& rays, const HitSpans& hits) const;
  /// Hits::normal of Hits::triangle.
  std::vector<Vec3> normals(std::span<const std::uint32_t> triangles) const;
  /// For each ray 1 if anything lies between t_min and t_max, else 0. Throws as intersect().
  std::vector<std::uint8_t> occluded(const Rays& rays) const;
  const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
};

}  // namespace glowworm::api
