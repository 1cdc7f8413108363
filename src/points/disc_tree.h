// A tree over discs, which finds those that a ray crosses.
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "core/box_tree.h"
#include "core/vec.h"

namespace glowworm {

/// A disc that rays cross from its front, the side of its normal.
struct Disc {
  Vec3 center;       ///< metres
  Vec3 normal;       ///< unit
  float radius = 0;  ///< metres
};

/// A place where a ray crosses a disc.
struct DiscCrossing {
  std::uint32_t disc = 0;
  float distance = 0;        ///< along the ray, in multiples of its direction
  float radius_squared = 0;  ///< from the disc's centre, m^2
};

/// Immutable; calls are thread-safe.
class DiscTree {
 public:
  DiscTree() = default;
  explicit DiscTree(std::vector<Disc> discs);

  bool empty() const { return discs_.empty(); }
  const std::vector<Disc>& discs() const { return discs_; }

  /// Calls visit(DiscCrossing) for each disc that the ray crosses from its front within `length`, until visit returns
  /// false. Which discs it finds, and their crossings, depend on the ray and the disc alone.
  template <class Visit>
  void for_crossed(Vec3 origin, Vec3 direction, float length, Visit&& visit) const {
    boxes_.for_met(origin, direction, length, 0, [&](std::uint32_t i) {
      const DiscCrossing crossing = cross(i, origin, direction, length);
      return !(crossing.distance <= length) || visit(crossing);
    });
  }

 private:
  /// The distance is no number where the ray misses.
  DiscCrossing cross(std::uint32_t disc, Vec3 origin, Vec3 direction, float length) const {
    constexpr DiscCrossing kMissed{0, std::numeric_limits<float>::quiet_NaN(), 0};
    const Disc& d = discs_[disc];
    const float facing = dot(direction, d.normal);
    if (!(facing < 0)) return kMissed;
    const float distance = dot(d.center - origin, d.normal) / facing;
    if (!(distance >= 0 && distance <= length)) return kMissed;
    const float squared = length_squared(origin + direction * distance - d.center);
    return squared < d.radius * d.radius ? DiscCrossing{disc, distance, squared} : kMissed;
  }

  std::vector<Disc> discs_;
  BoxTree boxes_;
};

}  // namespace glowworm
