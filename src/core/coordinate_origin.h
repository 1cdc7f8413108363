// The origin that is subtracted from coordinates while a file is read.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/transform_double.h"

namespace glowworm {

/// The origin for coordinates within a box: along each axis the box's middle if it lies more than 128 times its
/// diagonal away, and else 0. Positions between vertices are rounded to the last place of their coordinates, and rays
/// begin as far from surfaces: 128 sizes away along each axis, this changes direct light by 0.1% (built-in atrium).
inline Vec3 origin_for(Vec3d min, Vec3d max) {
  constexpr double kFar = 128;
  const Vec3 middle = narrow((min + max) * 0.5);
  const double size = length(max - min);
  Vec3 origin{0, 0, 0};
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(middle[axis]) > kFar * size) origin[axis] = middle[axis];
  return origin;
}

/// Subtracts an origin from coordinates in double precision, and finds out which origin they need.
class CoordinateOrigin {
 public:
  /// What is subtracted, metres; (0, 0, 0) until move().
  Vec3 origin() const { return origin_; }
  /// A place relative to the origin.
  Vec3 relative(Vec3d place) const { return narrow(place - Vec3d(origin_)); }
  /// Takes a place into account for move(), if it is finite.
  void cover(Vec3d place) {
    if (!is_finite(place)) return;
    for (int axis = 0; axis < 3; ++axis) {
      min_[axis] = std::min(min_[axis], place[axis]);
      max_[axis] = std::max(max_[axis], place[axis]);
    }
  }
  /// Calls cover(), and returns the place relative to the origin.
  Vec3 take(Vec3d place) {
    cover(place);
    return relative(place);
  }
  /// Notes that the file itself rounded coordinates far from its origin. No origin restores their digits.
  void set_rounded() { rounded_ = true; }
  bool is_rounded() const { return rounded_; }

  /// Moves to the origin that the places need. If it returns true, the origin has changed, and the caller must read
  /// everything again.
  bool move() {
    if (!(min_.x <= max_.x)) return false;
    const Vec3 wanted = origin_for(min_, max_);
    if (wanted == origin_) return false;
    *this = CoordinateOrigin();
    origin_ = wanted;
    return true;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 origin_{0, 0, 0};
  Vec3d min_{kInfinity, kInfinity, kInfinity}, max_{-kInfinity, -kInfinity, -kInfinity};
  bool rounded_ = false;
};

/// What `read` returns. If the coordinates lie far away, reads them once more, from an origin near them: in floats,
/// small shapes there would lose their form, and perhaps all their triangles.
template <typename Read>
auto read_near(CoordinateOrigin& origin, const Read& read) {
  try {
    auto first = read();
    if (!origin.move()) return first;
  } catch (const MemoryError&) {
    throw;
  } catch (const Error&) {
    if (!origin.move()) throw;
  }
  return read();
}

}  // namespace glowworm
