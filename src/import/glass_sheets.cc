#include "import/glass_sheets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "import/free_borders.h"
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
    for (std::uint32_t t = 0; t < geometry.triangles.size(); ++t) {
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

  /// The triangles of sheets.
  std::vector<std::uint32_t> sheets() const {
    return triangles_of([](const Surface& surface) { return surface.is_sheet; });
  }

  /// The triangles of slabs.
  std::vector<std::uint32_t> slabs() const {
    // Thickness over the root of the area of a side; and the area that a closed surface shows to any side over its own,
    // which is 0. Bent sheets whose borders lie at walls show nearly all.
    constexpr double kThickest = 0.1, kMostOpen = 0.5;
    return triangles_of([](const Surface& surface) {
      const double side = surface.area / 2;
      return !surface.is_sheet && length(surface.normal) <= kMostOpen * surface.area &&
             std::abs(surface.volume) / side <= kThickest * std::sqrt(side);
    });
  }

 private:
  using Corners = std::array<std::uint32_t, 3>;
  /// Triangles that share vertices.
  struct Surface {
    double area = 0, volume = 0;
    Vec3 normal{0, 0, 0};
    bool is_sheet = false;
  };

  template <typename Chosen>
  std::vector<std::uint32_t> triangles_of(Chosen&& chosen) const {
    Sets sets(places_.size());
    const std::vector<Surface> surfaces = measure(sets);
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      if (chosen(surfaces[sets.of(corners_[i][0])])) out.push_back(triangles_[i]);
    return out;
  }

  /// Surfaces by their sets of places, which it joins.
  std::vector<Surface> measure(Sets& sets) const {
    constexpr double kFlat = 1e-3, kThinnest = 1e-6;
    for (const Corners& c : corners_) {
      sets.join(c[0], c[1]);
      sets.join(c[1], c[2]);
    }
    std::vector<Surface> out(places_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::uint32_t set = sets.of(corners_[i][0]);
      const auto corner = [&](std::size_t c) { return places_[corners_[i][c]] - places_[set]; };
      Surface& surface = out[set];
      surface.area += geometry_.area(triangles_[i]);
      surface.volume += dot(corner(0), cross(corner(1), corner(2))) / 6;
      surface.normal += geometry_.scaled_normal(triangles_[i]) * 0.5f;
    }
    for (Surface& surface : out) {
      const bool both_sides = std::abs(surface.volume) <= kThinnest * std::pow(surface.area, 1.5);
      surface.is_sheet = both_sides || length(surface.normal) >= (1 - kFlat) * surface.area;
    }
    add_open(sets, out);
    return out;
  }

  /// Marks the surfaces that have a free border.
  void add_open(Sets& sets, std::vector<Surface>& surfaces) const {
    // Models leave gaps of a hundredth of their size, as between water and the walls around it.
    constexpr double kGap = 0.02, kHole = 0.1;
    std::vector<BorderEdge> borders;
    std::vector<std::uint32_t> surface_of(geometry_.triangles.size(), static_cast<std::uint32_t>(places_.size()));
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    const auto edge = [&](std::size_t i, std::size_t c) {
      return std::minmax({corners_[i][c], corners_[i][(c + 1) % 3]});
    };
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      surface_of[triangles_[i]] = sets.of(corners_[i][0]);
      for (std::size_t c = 0; c < 3; ++c) ++uses[edge(i, c)];
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::uint32_t surface = surface_of[triangles_[i]];
      for (std::size_t c = 0; c < 3 && !surfaces[surface].is_sheet; ++c) {
        const auto [a, b] = edge(i, c);
        if (a == b || uses[{a, b}] > 1) continue;
        borders.push_back({places_[a], places_[b], triangles_[i], surface,
                           static_cast<float>(kGap * std::sqrt(surfaces[surface].area))});
      }
    }
    if (borders.empty()) return;
    const std::vector<double> lengths = free_border_lengths(geometry_, std::move(borders), surface_of, surfaces.size());
    for (std::size_t s = 0; s < surfaces.size(); ++s)
      if (lengths[s] > kHole * std::sqrt(surfaces[s].area)) surfaces[s].is_sheet = true;
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

std::vector<std::uint32_t> triangles_of_slabs(const Geometry& geometry, const std::vector<bool>& is_glass) {
  return GlassSurfaces(geometry, is_glass).slabs();
}

void make_panes_of_glass_sheets(SceneDescription& scene, NoteCounter& notes) {
  std::vector<bool> is_glass;
  for (const Material& material : scene.materials) is_glass.push_back(material.kind == MaterialKind::dielectric);
  if (std::find(is_glass.begin(), is_glass.end(), true) == is_glass.end()) return;
  const std::vector<std::uint32_t> sheets = GlassSurfaces(scene.geometry, is_glass).sheets();
  std::unordered_map<std::uint32_t, std::uint32_t> panes;  // by the material of the solid
  for (const std::uint32_t t : sheets) {
    std::uint32_t& material = scene.geometry.material[t];
    const auto next = static_cast<std::uint32_t>(scene.materials.size());
    const auto [found, fresh] = panes.try_emplace(material, next);
    if (fresh) scene.materials.push_back(pane_of(Material(scene.materials[material])));
    material = found->second;
  }
  notes.add("triangle of a sheet of glass, taken as a thin pane", sheets.size());
}

}  // namespace glowworm
