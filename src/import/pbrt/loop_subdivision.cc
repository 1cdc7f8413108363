// Loop subdivision. Masks: Loop 1987; boundaries and limit positions after Hoppe et al., "Piecewise Smooth Surface
// Reconstruction", 1994.
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "import/pbrt/shapes.h"

namespace glowworm {

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // smaller index first

Edge edge_of(std::uint32_t a, std::uint32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }

struct EdgeFaces {
  int count = 0;
  std::array<std::uint32_t, 2> opposite{};  // third corners of the triangles at the edge
};

using EdgeMap = std::map<Edge, EdgeFaces>;

/// The edges of a mesh; empty where one has more than two triangles.
EdgeMap edges_of(const Geometry& mesh) {
  EdgeMap edges;
  for (const auto& corners : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      EdgeFaces& edge = edges[edge_of(corners[i], corners[(i + 1) % 3])];
      if (edge.count == 2) return {};
      edge.opposite[edge.count++] = corners[(i + 2) % 3];
    }
  }
  return edges;
}

/// What lies around each vertex.
struct Rings {
  std::vector<int> valence;
  std::vector<Vec3> sum;           ///< of the neighbours
  std::vector<Vec3> boundary_sum;  ///< of the neighbours along the boundary
  std::vector<int> boundary_count;
};

Rings rings_of(const Geometry& mesh, const EdgeMap& edges) {
  const std::size_t count = mesh.positions.size();
  Rings rings{std::vector<int>(count), std::vector<Vec3>(count), std::vector<Vec3>(count), std::vector<int>(count)};
  for (const auto& [edge, faces] : edges) {
    for (const auto& [a, b] : {edge, Edge{edge.second, edge.first}}) {
      ++rings.valence[a];
      rings.sum[a] += mesh.positions[b];
      if (faces.count == 1) {
        ++rings.boundary_count[a];
        rings.boundary_sum[a] += mesh.positions[b];
      }
    }
  }
  return rings;
}

/// Weight of each neighbour of an inner vertex: Loop's choice.
float neighbour_weight(int valence) {
  const double c = 0.375 + 0.25 * std::cos(2 * M_PI / valence);
  return static_cast<float>((0.625 - c * c) / valence);
}

/// Moves the old vertices by a mask with the given weights of neighbours.
std::vector<Vec3> relaxed(const Geometry& mesh, const EdgeMap& edges, float boundary_weight, bool limit) {
  const Rings rings = rings_of(mesh, edges);
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

Geometry subdivide_once(const Geometry& mesh, const EdgeMap& edges) {
  Geometry out;
  out.positions = relaxed(mesh, edges, 0.125f, false);
  std::map<Edge, std::uint32_t> middle;
  for (const auto& [edge, faces] : edges) {
    const Vec3 ends = mesh.positions[edge.first] + mesh.positions[edge.second];
    middle[edge] = static_cast<std::uint32_t>(out.positions.size());
    out.positions.push_back(faces.count == 1
                                ? ends * 0.5f
                                : ends * 0.375f +
                                      (mesh.positions[faces.opposite[0]] + mesh.positions[faces.opposite[1]]) * 0.125f);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = middle[edge_of(a, b)], bc = middle[edge_of(b, c)], ca = middle[edge_of(c, a)];
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
    const EdgeMap edges = edges_of(mesh);
    if (edges.empty()) break;
    mesh = subdivide_once(mesh, edges);
  }
  if (levels > 0) {
    const EdgeMap edges = edges_of(mesh);
    if (!edges.empty()) mesh.positions = relaxed(mesh, edges, 0.2f, true);
  }
  // Normals weighted by area: at this fineness they are the limit surface's to a fraction of a degree.
  mesh.normals.assign(mesh.positions.size(), Vec3{0, 0, 0});
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t vertex : mesh.triangles[t]) mesh.normals[vertex] += mesh.scaled_normal(t);
  }
  return mesh;
}

}  // namespace glowworm
