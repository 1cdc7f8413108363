#include "import/open_glass.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include "import/mesh_tools.h"

namespace glowworm {

namespace {

/// Disjoint sets of numbers.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t of(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[of(a)] = of(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

/// The glass of a scene: triangles and their corners, which are one where their positions are.
class GlassSurfaces {
 public:
  GlassSurfaces(const Geometry& geometry, const std::vector<bool>& is_glass) : geometry_(geometry) {
    std::unordered_map<FloatBits<3>, std::uint32_t, FloatBitsHash> known;
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      if (!is_glass[geometry.material[t]]) continue;
      Corners& corners = corners_.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 place = geometry.positions[geometry.triangles[t][i]] + Vec3{0, 0, 0};  // -0 becomes 0
        const auto next = static_cast<std::uint32_t>(places_.size());
        const auto [found, fresh] = known.try_emplace(std::bit_cast<FloatBits<3>>(place), next);
        if (fresh) places_.push_back(place);
        corners[i] = found->second;
      }
      triangles_.push_back(t);
    }
  }

  /// The triangles of surfaces that enclose nothing.
  std::vector<std::uint32_t> open_triangles() {
    constexpr double kShareOfHoles = 1e-3, kThinnest = 1e-6;
    Sets surfaces(places_.size());
    for (const Corners& c : corners_) {
      surfaces.join(c[0], c[1]);
      surfaces.join(c[1], c[2]);
    }
    std::vector<double> area(places_.size()), volume(places_.size()), holes(places_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::uint32_t surface = surfaces.of(corners_[i][0]);
      const Vec3 from = places_[surface];
      const auto corner = [&](std::size_t c) { return places_[corners_[i][c]] - from; };
      area[surface] += geometry_.area(triangles_[i]);
      volume[surface] += dot(corner(0), cross(corner(1), corner(2))) / 6;
    }
    for (const auto& [place, hole] : hole_areas()) holes[surfaces.of(place)] += length(hole);
    std::vector<std::uint32_t> open;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::uint32_t s = surfaces.of(corners_[i][0]);
      const bool is_flat = std::abs(volume[s]) <= kThinnest * std::pow(area[s], 1.5);
      if (is_flat || holes[s] > kShareOfHoles * area[s]) open.push_back(triangles_[i]);
    }
    return open;
  }

 private:
  using Corners = std::array<std::uint32_t, 3>;

  /// Edges of one triangle alone, as they run around it. A triangle that repeats another adds none.
  std::vector<std::array<std::uint32_t, 2>> free_edges() const {
    std::unordered_map<FloatBits<3>, bool, FloatBitsHash> seen;
    std::unordered_map<FloatBits<2>, std::pair<std::uint32_t, bool>, FloatBitsHash> edges;  // count, and direction
    for (const Corners& c : corners_) {
      FloatBits<3> sorted = c;
      std::sort(sorted.begin(), sorted.end());
      if (!seen.emplace(sorted, true).second) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t from = c[i], to = c[(i + 1) % 3];
        auto& [count, rises] = edges[{std::min(from, to), std::max(from, to)}];
        ++count;
        rises = from < to;
      }
    }
    std::vector<std::array<std::uint32_t, 2>> out;
    for (const auto& [ends, edge] : edges) {
      if (edge.first != 1) continue;
      out.push_back(edge.second ? std::array{ends[0], ends[1]} : std::array{ends[1], ends[0]});
    }
    std::sort(out.begin(), out.end());  // sums must not depend on the order of a hash table
    return out;
  }

  /// For each group of free edges that share places: one of its places, and its area as a vector. A seam has none.
  std::vector<std::pair<std::uint32_t, Vec3>> hole_areas() const {
    const auto edges = free_edges();
    Sets groups(places_.size());
    for (const auto& [from, to] : edges) groups.join(from, to);
    std::unordered_map<std::uint32_t, std::size_t> index;
    std::vector<std::pair<std::uint32_t, Vec3>> out;
    for (const auto& [from, to] : edges) {
      const auto [found, fresh] = index.try_emplace(groups.of(from), out.size());
      if (fresh) out.push_back({from, {0, 0, 0}});
      auto& [place, area] = out[found->second];
      const Vec3 origin = places_[place];
      area += cross(places_[from] - origin, places_[to] - origin) * 0.5f;
    }
    return out;
  }

  const Geometry& geometry_;
  std::vector<std::uint32_t> triangles_;  ///< of glass
  std::vector<Corners> corners_;          ///< of these
  std::vector<Vec3> places_;
};

Material pane_of(const Material& solid) {
  Material pane = solid;
  pane.kind = MaterialKind::thin_dielectric;
  pane.transmittance.value *= solid.transmittance.value;  // light enters and leaves at once
  return pane;
}

}  // namespace

void make_panes_of_open_glass(SceneDescription& scene, NoteCounter& notes) {
  std::vector<bool> is_glass;
  for (const Material& material : scene.materials) is_glass.push_back(material.kind == MaterialKind::dielectric);
  if (std::find(is_glass.begin(), is_glass.end(), true) == is_glass.end()) return;
  const std::vector<std::uint32_t> open = GlassSurfaces(scene.geometry, is_glass).open_triangles();
  std::unordered_map<std::uint32_t, std::uint32_t> panes;  // by the material of the solid
  for (const std::uint32_t t : open) {
    std::uint32_t& material = scene.geometry.material[t];
    const auto next = static_cast<std::uint32_t>(scene.materials.size());
    const auto [found, fresh] = panes.try_emplace(material, next);
    if (fresh) scene.materials.push_back(pane_of(Material(scene.materials[material])));
    material = found->second;
  }
  notes.add("glass of a surface that encloses nothing, taken as a thin pane", open.size());
}

}  // namespace glowworm
