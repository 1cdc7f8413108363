#include "bake/face.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace glowworm {

namespace {

/// A vertex of all those at one position, for each vertex.
std::vector<std::uint32_t> weld(const Geometry& geometry) {
  const auto key = [&](std::uint32_t v) {
    const Vec3& p = geometry.positions[v];
    // -0 and 0 are one place.
    return std::tuple(std::bit_cast<std::uint32_t>(p.x + 0.0f), std::bit_cast<std::uint32_t>(p.y + 0.0f),
                      std::bit_cast<std::uint32_t>(p.z + 0.0f), v);
  };
  std::vector<std::uint32_t> order(geometry.positions.size()), out(geometry.positions.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && geometry.positions[order[i]] == geometry.positions[order[i - 1]];
    out[order[i]] = same ? out[order[i - 1]] : order[i];
  }
  return out;
}

struct Edge {
  std::uint32_t low, high;  // welded ends
  bool back, forward;       // forward: from low to high
  std::uint32_t face;
  std::uint8_t corner;

  auto ends() const { return std::tuple(low, high, back); }
};

}  // namespace

std::vector<SharedEdge> shared_edges(const Geometry& geometry, std::span<const BakeFace> faces) {
  const std::vector<std::uint32_t> welded = weld(geometry);
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f)
    for (std::uint8_t c = 0; c < 3; ++c) {
      const auto& corners = geometry.triangles[faces[f].triangle];
      const std::uint32_t a = welded[corners[c]], b = welded[corners[(c + 1u) % 3]];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), faces[f].back, a < b, f, c});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tuple(a.ends(), a.face, a.corner) < std::tuple(b.ends(), b.face, b.corner);
  });
  std::vector<SharedEdge> out;
  for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
    for (end = first + 1; end < edges.size() && edges[end].ends() == edges[first].ends();) ++end;
    // Faces that run along the edge in one direction face opposite ways.
    if (end - first != 2 || edges[first].forward == edges[first + 1].forward) continue;
    const Edge &a = edges[first], &b = edges[first + 1];
    out.push_back({{a.face, b.face}, {a.corner, b.corner}});
  }
  return out;
}

}  // namespace glowworm
