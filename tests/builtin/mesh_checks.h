// Brute-force checks of meshes.
#pragma once
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "scene/geometry.h"

namespace glowworm {

using PositionKey = std::array<float, 3>;

/// How many directed edges (by the positions of their ends, bit for bit) have no partner that runs the other way, once
/// each: 0 for closed and consistently wound meshes.
inline std::size_t unmatched_edges(const Geometry& geometry) {
  std::map<std::pair<PositionKey, PositionKey>, int> edges;
  const auto key = [&](std::uint32_t v) {
    const Vec3 p = geometry.positions[v] + Vec3{0, 0, 0};  // turns -0 into 0
    return PositionKey{p.x, p.y, p.z};
  };
  for (const auto& t : geometry.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{key(t[k]), key(t[(k + 1) % 3])}];
  std::size_t unmatched = 0;
  for (const auto& [edge, count] : edges) {
    const auto partner = edges.find({edge.second, edge.first});
    if (partner == edges.end() || partner->second != count) ++unmatched;
  }
  return unmatched;
}

/// The enclosed volume (m^3) by the divergence theorem: positive where the faces of a closed mesh look outwards.
inline double signed_volume(const Geometry& geometry) {
  double volume = 0;
  for (const auto& [a, b, c] : geometry.triangles)
    volume += dot(geometry.positions[a], cross(geometry.positions[b], geometry.positions[c])) / 6.0;
  return volume;
}

inline double total_area(const Geometry& geometry) {
  double area = 0;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) area += geometry.area(t);
  return area;
}

/// Triangles whose smooth normals turn away from the triangle's own by more than 90 degrees, or are not unit.
inline std::size_t wrong_normals(const Geometry& geometry) {
  std::size_t wrong = 0;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t)
    for (const std::uint32_t v : geometry.triangles[t]) {
      const Vec3 n = geometry.normals[v];
      if (n == Vec3{0, 0, 0}) continue;
      if (std::abs(length(n) - 1) > 1e-4f || dot(n, geometry.normal(t)) <= 0) {
        ++wrong;
        break;
      }
    }
  return wrong;
}

/// Triangles thinner than `height` metres (their least height).
inline std::size_t slivers(const Geometry& geometry, float height) {
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
    const auto& [a, b, c] = geometry.triangles[t];
    const float longest = std::max({length(geometry.positions[b] - geometry.positions[a]),
                                    length(geometry.positions[c] - geometry.positions[b]),
                                    length(geometry.positions[a] - geometry.positions[c])});
    if (!(geometry.area(t) * 2 > height * longest)) ++count;
  }
  return count;
}

}  // namespace glowworm
