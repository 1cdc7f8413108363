// Lamps in the plane of other surfaces.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// A lamp exactly in a ceiling's plane is as far along every ray as the ceiling, so rounding would decide which of them
/// a ray meets. Here the lamp wins: the surface behind it is absent where the lamp lies. Lamps that rays pass through
/// are left out.
class LampsInPlanes {
 public:
  /// Calls visit(triangle) for all triangles near a ball, as Tracer::visit_near() does.
  using VisitNear =
      std::function<void(Vec3 center, float radius, const std::function<bool(std::uint32_t triangle)>& visit)>;

  LampsInPlanes() = default;
  /// Finds the lamps. Runs on all threads, and `near` on each of them.
  LampsInPlanes(const Scene& scene, const VisitNear& near);

  bool empty() const { return pairs_.empty(); }
  /// The triangles that a lamp covers parts of, in order.
  std::vector<std::uint32_t> covered() const;
  /// Whether a lamp lies at a point of a triangle. @param by_camera a lamp that cameras see
  bool covers(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, bool by_camera) const;

  bool operator==(const LampsInPlanes&) const = default;

 private:
  struct Pair {
    std::uint32_t covered, lamp;  ///< triangles
    auto operator<=>(const Pair&) const = default;
  };

  std::vector<Pair> pairs_;  ///< in order
};

}  // namespace glowworm
