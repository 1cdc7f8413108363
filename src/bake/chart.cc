#include "bake/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bake/overlap.h"
#include "core/frame.h"

namespace glowworm {

namespace {

constexpr float kMinCosine = 0.70710678f;     ///< between a face of a chart and its direction: 45 degrees
constexpr float kCreaseCosine = 0.81915204f;  ///< between neighbours: 35 degrees

/// Data of each face for growing charts.
struct FaceTable {
  std::vector<Vec3> normal;
  std::vector<float> area;
  std::vector<std::uint32_t> object, material;
  std::vector<std::array<std::uint32_t, 3>> neighbour;  ///< across the edge from corner i; kNone: none

  FaceTable(const Geometry& geometry, std::span<const BakeFace> faces)
      : neighbour(faces.size(), {kNone, kNone, kNone}) {
    for (const BakeFace& face : faces) {
      normal.push_back(face_normal(geometry, face));
      area.push_back(geometry.area(face.triangle));
      object.push_back(geometry.object_of(face.triangle));
      material.push_back(geometry.material[face.triangle]);
    }
    for (const SharedEdge& edge : shared_edges(geometry, faces))
      for (int side = 0; side < 2; ++side) neighbour[edge.face[side]][edge.corner[side]] = edge.face[1 - side];
  }
};

/// Faces connected to `seed` that may share its chart and have none yet, in the order of growth.
std::vector<std::uint32_t> grow(const FaceTable& table, std::uint32_t seed, std::vector<bool>& taken) {
  std::vector<std::uint32_t> out{seed};
  taken[seed] = true;
  for (std::size_t i = 0; i < out.size(); ++i)
    for (const std::uint32_t next : table.neighbour[out[i]]) {
      if (next == kNone || taken[next] || table.object[next] != table.object[seed] ||
          table.material[next] != table.material[seed])
        continue;
      if (dot(table.normal[next], table.normal[seed]) < kMinCosine ||
          dot(table.normal[next], table.normal[out[i]]) < kCreaseCosine)
        continue;
      taken[next] = true;
      out.push_back(next);
    }
  return out;
}

float turn(Vec2 a, Vec2 b, Vec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  const auto before = [](Vec2 a, Vec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); };
  std::sort(points.begin(), points.end(), before);
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= base + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

struct Rectangle {
  Vec2 low, high;
};

Rectangle rectangle_along(const std::vector<Vec2>& points, Vec2 axis) {
  constexpr float kFar = std::numeric_limits<float>::max();
  Rectangle r{{kFar, kFar}, {-kFar, -kFar}};
  for (const Vec2& p : points) {
    const float x = p.x * axis.x + p.y * axis.y, y = p.y * axis.x - p.x * axis.y;
    r.low = {std::min(r.low.x, x), std::min(r.low.y, y)};
    r.high = {std::max(r.high.x, x), std::max(r.high.y, y)};
  }
  return r;
}

/// Direction of the rectangle of least area around the points: one of its sides lies along the hull.
Vec2 best_axis(const std::vector<Vec2>& points) {
  constexpr std::size_t kMaxTries = 64;
  const std::vector<Vec2> hull = convex_hull(points);
  Vec2 best{1, 0};
  float least = std::numeric_limits<float>::max();
  const std::size_t step = 1 + hull.size() / kMaxTries;
  for (std::size_t i = 0; i < hull.size(); i += step) {
    const Vec2 d = hull[(i + 1) % hull.size()] - hull[i];
    const float l = std::sqrt(d.x * d.x + d.y * d.y);
    if (!(l > 0)) continue;
    const Rectangle r = rectangle_along(hull, d * (1 / l));
    const float area = (r.high.x - r.low.x) * (r.high.y - r.low.y);
    // A rounding error must not decide which way a chart lies.
    if (area < least * 0.9999f) {
      least = area;
      best = d * (1 / l);
    }
  }
  return best;
}

/// Moves and turns corners so that the chart lies in its smallest rectangle, wider than high.
void settle(Chart& chart) {
  std::vector<Vec2> points;
  for (const auto& face : chart.corners) points.insert(points.end(), face.begin(), face.end());
  Vec2 axis = best_axis(points);
  Rectangle r = rectangle_along(points, axis);
  if (r.high.x - r.low.x < r.high.y - r.low.y) {
    axis = {-axis.y, axis.x};
    r = rectangle_along(points, axis);
  }
  for (auto& face : chart.corners)
    for (Vec2& p : face) p = {p.x * axis.x + p.y * axis.y - r.low.x, p.y * axis.x - p.x * axis.y - r.low.y};
  chart.size = {r.high.x - r.low.x, r.high.y - r.low.y};
}

/// Projects faces along `direction`.
Chart project(const Geometry& geometry, std::span<const BakeFace> faces, std::vector<std::uint32_t> members,
              Vec3 direction) {
  const Frame frame = Frame::from_normal(direction);
  Chart chart;
  chart.faces = std::move(members);
  const Vec3 origin = geometry.positions[geometry.triangles[faces[chart.faces[0]].triangle][0]];
  for (const std::uint32_t f : chart.faces) {
    std::array<Vec2, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 p = geometry.positions[geometry.triangles[faces[f].triangle][c]] - origin;
      corners[c] = {dot(p, frame.s), dot(p, frame.t)};
    }
    chart.corners.push_back(corners);
  }
  return chart;
}

/// The mean direction of faces, or the first face's where some face would lie too steep to the mean.
Vec3 common_direction(const FaceTable& table, const std::vector<std::uint32_t>& members) {
  Vec3 sum{0, 0, 0};
  for (const std::uint32_t f : members) sum += table.normal[f] * table.area[f];
  const float l = length(sum);
  if (!(l > 0)) return table.normal[members[0]];
  sum = sum / l;
  for (const std::uint32_t f : members)
    if (dot(table.normal[f], sum) < kMinCosine) return table.normal[members[0]];
  return sum;
}

}  // namespace

std::vector<FacePlace> places_of_faces(std::span<const Chart> charts, std::size_t faces) {
  std::vector<FacePlace> out(faces);
  for (std::uint32_t c = 0; c < charts.size(); ++c)
    for (std::uint32_t i = 0; i < charts[c].faces.size(); ++i) out[charts[c].faces[i]] = {c, i};
  return out;
}

std::vector<Chart> make_charts(const Geometry& geometry, std::span<const BakeFace> faces) {
  const FaceTable table(geometry, faces);
  std::vector<std::uint32_t> seeds(faces.size());
  for (std::uint32_t i = 0; i < seeds.size(); ++i) seeds[i] = i;
  std::stable_sort(seeds.begin(), seeds.end(), [&](auto a, auto b) { return table.area[a] > table.area[b]; });
  std::vector<bool> taken(faces.size(), false);
  std::vector<Chart> charts;
  // Faces that overlap others of their chart become seeds once more, after all others.
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    if (taken[seeds[i]]) continue;
    std::vector<std::uint32_t> members = grow(table, seeds[i], taken);
    const Vec3 direction = common_direction(table, members);
    Chart chart =
        project(geometry, faces, std::move(members), length_squared(direction) > 0 ? direction : Vec3{0, 0, 1});
    for (const std::uint32_t dropped : drop_overlaps(chart)) {
      taken[dropped] = false;
      seeds.push_back(dropped);
    }
    settle(chart);
    charts.push_back(std::move(chart));
  }
  return charts;
}

}  // namespace glowworm
