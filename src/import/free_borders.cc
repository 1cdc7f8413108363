#include "import/free_borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace glowworm {
namespace {

float distance_to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  const float l2 = length_squared(along);
  const float t = l2 > 0 ? std::clamp(dot(p - a, along) / l2, 0.0f, 1.0f) : 0.0f;
  return length(p - (a + along * t));
}

float distance_to_triangle(Vec3 p, const std::array<Vec3, 3>& c) {
  const Vec3 normal = cross(c[1] - c[0], c[2] - c[0]);
  bool over = length_squared(normal) > 0;
  float nearest = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 a = c[i], b = c[(i + 1) % 3];
    over = over && dot(cross(b - a, p - a), normal) >= 0;
    nearest = std::min(nearest, distance_to_segment(p, a, b));
  }
  return over ? std::abs(dot(p - c[0], normal)) / length(normal) : nearest;
}

std::pair<Vec3, Vec3> bounds(const std::array<Vec3, 3>& c) {
  return {{std::min({c[0].x, c[1].x, c[2].x}), std::min({c[0].y, c[1].y, c[2].y}), std::min({c[0].z, c[1].z, c[2].z})},
          {std::max({c[0].x, c[1].x, c[2].x}), std::max({c[0].y, c[1].y, c[2].y}), std::max({c[0].z, c[1].z, c[2].z})}};
}

Vec3 middle(const BorderEdge& e) { return (e.a + e.b) * 0.5f; }

/// How near another triangle of its own surface must be to an edge to lie at it, m.
float crack(const BorderEdge& e) { return 1e-3f * length(e.b - e.a); }

}  // namespace

std::vector<double> free_border_lengths(const Geometry& geometry, std::vector<BorderEdge> edges,
                                        const std::vector<std::uint32_t>& surface_of, std::size_t surfaces) {
  std::sort(edges.begin(), edges.end(),
            [](const BorderEdge& a, const BorderEdge& b) { return middle(a).x < middle(b).x; });
  float farthest = 0;
  for (const BorderEdge& e : edges) farthest = std::max({farthest, e.reach, crack(e)});
  std::vector<bool> is_free(edges.size(), true);
  for (std::uint32_t t = 0; t < geometry.triangles.size(); ++t) {
    std::array<Vec3, 3> c;
    for (std::size_t i = 0; i < 3; ++i) c[i] = geometry.positions[geometry.triangles[t][i]];
    const auto [low, high] = bounds(c);
    const auto first = std::partition_point(
        edges.begin(), edges.end(), [from = low.x - farthest](const BorderEdge& e) { return middle(e).x < from; });
    for (auto e = first; e != edges.end() && middle(*e).x <= high.x + farthest; ++e) {
      const auto i = static_cast<std::size_t>(e - edges.begin());
      if (!is_free[i] || e->triangle == t) continue;
      const float reach = surface_of[t] == e->surface ? crack(*e) : e->reach;
      const Vec3 p = middle(*e);
      if (p.y < low.y - reach || p.y > high.y + reach || p.z < low.z - reach || p.z > high.z + reach) continue;
      if (distance_to_triangle(p, c) <= reach) is_free[i] = false;
    }
  }
  std::vector<double> lengths(surfaces, 0.0);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (is_free[i]) lengths[edges[i].surface] += length(edges[i].b - edges[i].a);
  return lengths;
}

}  // namespace glowworm
