#include "trace/lamps_in_planes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr std::size_t kLampsAtOnce = 256;

/// In double precision, so that only the vertices are rounded.
struct Point {
  double x, y, z;
};
Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(Point a, Point b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Point unit(Point a) {
  const double length = std::sqrt(dot(a, a));
  return {a.x / length, a.y / length, a.z / length};
}
Point wide(Vec3 a) { return {a.x, a.y, a.z}; }

using Corners = std::array<Point, 3>;

Corners corners(const Geometry& g, std::uint32_t triangle) {
  const auto [a, b, c] = g.corners(triangle);
  return {wide(a), wide(b), wide(c)};
}

/// Not unit.
Point normal(const Corners& t) { return cross(t[1] - t[0], t[2] - t[0]); }

/// Whether all corners of `a` lie in the plane of `b` but for rounding.
bool lies_in_plane(const Corners& a, const Corners& b, double rounding) {
  const Point n = unit(normal(b));
  return std::all_of(a.begin(), a.end(), [&](Point p) { return std::abs(dot(p - b[0], n)) <= rounding; });
}

/// Whether two triangles of one plane overlap by more than rounding: no edge of `a` separates them.
bool no_edge_separates(const Corners& a, const Corners& b, double rounding) {
  const Point n = normal(a);
  for (std::size_t i = 0; i < 3; ++i) {
    const Point inwards = unit(cross(n, a[(i + 1) % 3] - a[i]));
    const auto inside = [&](Point p) { return dot(p - a[i], inwards) > rounding; };
    if (std::none_of(b.begin(), b.end(), inside)) return false;
  }
  return true;
}

float rounding_of(const Scene& scene, std::uint32_t a, std::uint32_t b) {
  return scene.diffuse_triangle(a).offset() + scene.diffuse_triangle(b).offset();
}

bool covers_some(const Scene& scene, std::uint32_t lamp, std::uint32_t other) {
  const Corners a = corners(scene.geometry(), lamp), b = corners(scene.geometry(), other);
  const double rounding = rounding_of(scene, lamp, other);
  return (lies_in_plane(a, b, rounding) || lies_in_plane(b, a, rounding)) && no_edge_separates(a, b, rounding) &&
         no_edge_separates(b, a, rounding);
}

}  // namespace

LampsInPlanes::LampsInPlanes(const Scene& scene, const VisitNear& near) {
  const Geometry& g = scene.geometry();
  std::vector<std::uint32_t> lamps;
  for (std::uint32_t i = 0; i < g.triangles.size(); ++i)
    if (g.emission[i] != kNone && !scene.repeats(i) && !scene.is_pane(g.material[i])) lamps.push_back(i);
  std::vector<std::vector<Pair>> found((lamps.size() + kLampsAtOnce - 1) / kLampsAtOnce);
  parallel_for(0, lamps.size(), kLampsAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t lamp = lamps[i];
      Box3 box;
      for (const std::uint32_t vertex : g.triangles[lamp]) box.grow(g.positions[vertex]);
      const float radius = 0.5f * length(box.diagonal()) + scene.diffuse_triangle(lamp).offset();
      near(box.center(), radius, [&](std::uint32_t other) {
        if (g.emission_of(other) == kNone && covers_some(scene, lamp, other))
          found[first / kLampsAtOnce].push_back({other, lamp});
        return true;
      });
    }
  });
  for (const std::vector<Pair>& some : found) pairs_.insert(pairs_.end(), some.begin(), some.end());
  // A triangle may be visited more than once.
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
}

std::vector<std::uint32_t> LampsInPlanes::covered() const {
  std::vector<std::uint32_t> out;
  for (const Pair& pair : pairs_)
    if (out.empty() || out.back() != pair.covered) out.push_back(pair.covered);
  return out;
}

bool LampsInPlanes::covers(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, bool by_camera) const {
  const DiffuseTriangle at = scene.diffuse_triangle(triangle);
  const Vec3 p = at.corner + at.edge[0] * barycentric.x + at.edge[1] * barycentric.y;
  auto pair = std::lower_bound(pairs_.begin(), pairs_.end(), Pair{triangle, 0});
  for (; pair != pairs_.end() && pair->covered == triangle; ++pair) {
    if (by_camera && scene.materials()[scene.geometry().material_of(pair->lamp)].unseen) continue;
    const Corners lamp = corners(scene.geometry(), pair->lamp);
    // A border as wide as rounding stays covered: a ray may miss the lamp there.
    if (no_edge_separates(lamp, {wide(p), wide(p), wide(p)}, rounding_of(scene, triangle, pair->lamp))) return true;
  }
  return false;
}

}  // namespace glowworm
