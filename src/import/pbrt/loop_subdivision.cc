// Loop subdivision. Masks after Loop 1987; boundaries and limit positions after Hoppe et al., "Piecewise Smooth Surface
// Reconstruction", 1994.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "core/radix_sort.h"
#include "import/pbrt/shapes.h"

namespace glowworm {

namespace {

struct Edge {
  std::uint32_t ends[2];      ///< smaller index first
  std::uint32_t opposite[2];  ///< opposite corners of the adjacent triangles
  int triangles = 0;
};

/// The edges of a mesh, sorted by their ends.
struct EdgeTable {
  std::vector<Edge> edges;
  std::vector<std::uint32_t> after_corner;  ///< three per triangle: the edge from that corner to the next
};

/// The edges of a mesh; empty if an edge has more than two triangles.
EdgeTable edges_of(const Geometry& mesh) {
  const std::size_t corners = 3 * mesh.triangles.size();
  std::vector<KeyedIndex<std::uint64_t>> sorted;
  sorted.reserve(corners);
  for (std::uint32_t corner = 0; corner < corners; ++corner) {
    const auto& triangle = mesh.triangles[corner / 3];
    const std::uint64_t a = triangle[corner % 3], b = triangle[(corner + 1) % 3];
    sorted.push_back({std::min(a, b) << 32 | std::max(a, b), corner});
  }
  radix_sort(sorted, 64);
  EdgeTable table;
  table.after_corner.resize(corners);
  for (std::size_t i = 0; i < corners; ++i) {
    const auto& [key, corner] = sorted[i];
    if (i == 0 || key != sorted[i - 1].key) {
      table.edges.push_back({{static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)}, {}});
    }
    Edge& edge = table.edges.back();
    if (edge.triangles == 2) return {};
    edge.opposite[edge.triangles++] = mesh.triangles[corner / 3][(corner + 2) % 3];
    table.after_corner[corner] = static_cast<std::uint32_t>(table.edges.size() - 1);
  }
  return table;
}

/// Sums over the neighbours of each vertex.
struct Rings {
  std::vector<int> valence;
  std::vector<Vec3> sum;           ///< of the neighbours
  std::vector<Vec3> boundary_sum;  ///< of the neighbours along the boundary
  std::vector<int> boundary_count;
};

Rings rings_of(const Geometry& mesh, const EdgeTable& table) {
  const std::size_t count = mesh.positions.size();
  Rings rings{std::vector<int>(count), std::vector<Vec3>(count), std::vector<Vec3>(count), std::vector<int>(count)};
  for (const Edge& edge : table.edges) {
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t a = edge.ends[end], b = edge.ends[1 - end];
      ++rings.valence[a];
      rings.sum[a] += mesh.positions[b];
      if (edge.triangles == 1) {
        ++rings.boundary_count[a];
        rings.boundary_sum[a] += mesh.positions[b];
      }
    }
  }
  return rings;
}

/// Loop's weight of each neighbour of an inner vertex.
float neighbour_weight(int valence) {
  const double c = 0.375 + 0.25 * std::cos(2 * M_PI / valence);
  return static_cast<float>((0.625 - c * c) / valence);
}

/// Moves the old vertices by a mask with the given neighbour weights.
std::vector<Vec3> relaxed(const Geometry& mesh, const EdgeTable& table, float boundary_weight, bool limit) {
  const Rings rings = rings_of(mesh, table);
  std::vector<Vec3> out = mesh.positions;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const int n = rings.valence[i];
    if (n == 0) continue;
    if (rings.boundary_count[i] == 2) {
      out[i] = out[i] * (1 - 2 * boundary_weight) + rings.boundary_sum[i] * boundary_weight;
    } else if (rings.boundary_count[i] == 0) {
      const float beta = neighbour_weight(n);
      const float weight = limit ? 1 / (n + 3 / (8 * beta)) : beta;
      out[i] = out[i] * (1 - n * weight) + rings.sum[i] * weight;
    }
  }
  return out;
}

Geometry subdivide_once(const Geometry& mesh, const EdgeTable& table) {
  Geometry out;
  out.positions = relaxed(mesh, table, 0.125f, false);
  const auto first_middle = static_cast<std::uint32_t>(out.positions.size());
  for (const Edge& edge : table.edges) {
    const Vec3 ends = mesh.positions[edge.ends[0]] + mesh.positions[edge.ends[1]];
    out.positions.push_back(edge.triangles == 1
                                ? ends * 0.5f
                                : ends * 0.375f +
                                      (mesh.positions[edge.opposite[0]] + mesh.positions[edge.opposite[1]]) * 0.125f);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const std::uint32_t* const middle = &table.after_corner[3 * t];
    const std::uint32_t ab = first_middle + middle[0], bc = first_middle + middle[1], ca = first_middle + middle[2];
    out.triangles.push_back({a, ab, ca});
    out.triangles.push_back({ab, b, bc});
    out.triangles.push_back({ca, bc, c});
    out.triangles.push_back({ab, bc, ca});
  }
  return out;
}

}  // namespace

Geometry loop_subdivide(const Geometry& control, int levels) {
  Geometry mesh = control;
  for (int level = 0; level < levels; ++level) {
    check_cancelled();
    const EdgeTable table = edges_of(mesh);
    if (table.edges.empty()) break;
    mesh = subdivide_once(mesh, table);
  }
  if (levels > 0) {
    const EdgeTable table = edges_of(mesh);
    if (!table.edges.empty()) mesh.positions = relaxed(mesh, table, 0.2f, true);
  }
  // Area-weighted normals: after subdivision, they match the limit surface to a fraction of a degree.
  mesh.normals.assign(mesh.positions.size(), Vec3{0, 0, 0});
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t vertex : mesh.triangles[t]) mesh.normals[vertex] += mesh.scaled_normal(t);
  }
  return mesh;
}

}  // namespace glowworm
