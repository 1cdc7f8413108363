#include "import/polygon.h"

#include <cmath>
#include <cstddef>

namespace glowworm {

namespace {

constexpr std::size_t kTestsPerCorner = 1024;  ///< maximum number of point-in-triangle tests per corner

struct Point {
  double x = 0, y = 0;
};

bool same(Point a, Point b) { return a.x == b.x && a.y == b.y; }

/// Twice the signed area of a triangle: positive if it is counter-clockwise.
double turn(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// Projects the corners to the coordinate plane in which the polygon is largest, counter-clockwise overall (Newell's
/// normal). Empty if the area is zero.
std::vector<Point> flattened(std::span<const Vec3> corners) {
  double n[3] = {0, 0, 0};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i], b = corners[(i + 1) % corners.size()];
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      n[axis] += (double{a[u]} - b[u]) * (double{a[v]} + b[v]);
    }
  }
  int axis = 0;
  for (int other = 1; other < 3; ++other) {
    if (std::fabs(n[other]) > std::fabs(n[axis])) axis = other;
  }
  if (!(std::fabs(n[axis]) > 0) || !std::isfinite(n[axis])) return {};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Point> flat;
  flat.reserve(corners.size());
  for (const Vec3& p : corners) flat.push_back({n[axis] > 0 ? p[u] : -p[u], p[v]});
  return flat;
}

class EarCutter {
 public:
  EarCutter(const std::vector<Point>& flat, std::vector<std::array<std::uint32_t, 3>>& triangles)
      : flat_(flat), triangles_(triangles), left_(static_cast<std::uint32_t>(flat.size())) {
    for (std::uint32_t i = 0; i < left_; ++i) {
      previous_.push_back(i == 0 ? left_ - 1 : i - 1);
      next_.push_back(i + 1 == left_ ? 0 : i + 1);
    }
    for (std::uint32_t i = 0; i < left_; ++i) {
      blocks_.push_back(bend(i) <= 0);
      if (blocks_[i]) blockers_.push_back(i);
    }
  }

  bool is_convex() const {
    for (const std::uint32_t i : blockers_) {
      if (bend(i) < 0) return false;
    }
    return true;
  }
  /// The first reflex corner.
  std::uint32_t reflex_corner() const {
    for (const std::uint32_t i : blockers_) {
      if (bend(i) < 0) return i;
    }
    return 0;
  }

  bool cut() {
    std::size_t tests = kTestsPerCorner * flat_.size();
    std::uint32_t at = 0, in_vain = 0;
    while (left_ > 3 && in_vain < left_ && tests >= blockers_.size()) {
      tests -= blockers_.size();
      const std::uint32_t following = next_[at];
      if (!blocks_[at] && is_empty_ear(at)) {
        triangles_.push_back({previous_[at], at, following});
        remove(at);
        in_vain = 0;
      } else {
        ++in_vain;
      }
      at = following;
    }
    const bool whole = left_ <= 3;
    for (std::uint32_t i = next_[at]; next_[i] != at; i = next_[i]) triangles_.push_back({at, i, next_[i]});
    return whole;
  }

 private:
  double bend(std::uint32_t i) const { return turn(flat_[previous_[i]], flat_[i], flat_[next_[i]]); }

  bool is_empty_ear(std::uint32_t at) {
    const Point a = flat_[previous_[at]], b = flat_[at], c = flat_[next_[at]];
    std::size_t kept = 0;
    bool empty = true;
    for (const std::uint32_t i : blockers_) {
      if (!blocks_[i]) continue;  // cut off since
      blockers_[kept++] = i;
      const Point p = flat_[i];
      // Corners that coincide with the ear's are the ends of a bridge to a hole.
      if (!empty || same(p, a) || same(p, b) || same(p, c)) continue;
      empty = turn(a, b, p) < 0 || turn(b, c, p) < 0 || turn(c, a, p) < 0;
    }
    blockers_.resize(kept);
    return empty;
  }

  void remove(std::uint32_t at) {
    const std::uint32_t before = previous_[at], after = next_[at];
    next_[before] = after;
    previous_[after] = before;
    --left_;
    for (const std::uint32_t i : {before, after}) {
      if (blocks_[i] && bend(i) > 0) blocks_[i] = false;
    }
  }

  const std::vector<Point>& flat_;
  std::vector<std::array<std::uint32_t, 3>>& triangles_;
  std::uint32_t left_;
  std::vector<std::uint32_t> previous_, next_;
  std::vector<bool> blocks_;             ///< whether a corner is straight or reflex
  std::vector<std::uint32_t> blockers_;  ///< indices of these corners; some may no longer be
};

}  // namespace

bool cut_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  std::uint32_t hub = 0;
  if (count > 3) {
    const std::vector<Point> flat = flattened(corners);
    if (!flat.empty()) {
      EarCutter cutter(flat, triangles);
      if (!cutter.is_convex()) {
        if (count > 4) return cutter.cut();
        hub = cutter.reflex_corner();
      }
    }
  }
  for (std::uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({hub, (hub + i) % count, (hub + i + 1) % count});
  return true;
}

}  // namespace glowworm
