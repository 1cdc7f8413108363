#include "settings/steep_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "core/random.h"
#include "core/warp.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

constexpr std::size_t kMostLines = 8;
/// Points at which the maps of a material are looked up: a share of a twentieth is found to a tenth of itself.
constexpr std::size_t kPlaces = 2048;

bool has_map(const Scene& scene, std::uint32_t material) {
  const Material& m = scene.materials()[material];
  if (m.kind == MaterialKind::mix) return has_map(scene, m.mix_a) || has_map(scene, m.mix_b);
  return m.normal_map.texture != kNone || m.bump.texture != kNone;
}

/// How many points of a material were looked up, and how many of them are steep.
struct Looked {
  std::size_t points = 0, steep = 0;
};

/// Looks at points that are spread evenly over the triangles of one material.
/// @param looked by material: a mix has points of its parts
void look_at(const Scene& scene, const std::vector<std::uint32_t>& triangles, std::vector<Looked>& looked) {
  const Geometry& g = scene.geometry();
  std::vector<double> until;
  double area = 0;
  for (const std::uint32_t t : triangles) {
    const auto [a, b, c] = g.corners(t);
    area += length(cross(b - a, c - a));
    until.push_back(area);
  }
  for (std::uint32_t i = 0; i < kPlaces; ++i) {
    const double place = (i + 0.5) / kPlaces * area;
    const auto at = std::min<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(until.begin(), until.end(), place) - until.begin()),
        triangles.size() - 1);
    Sampler sampler(SamplerKind::sobol, 0, 0, i);
    SurfacePoint point = surface_point(scene, triangles[at], square_to_triangle(sampler.next2()));
    const Vec3 before = point.frame.n;
    resolve_bsdf(scene, point);
    Looked& of = looked[point.material];
    ++of.points;
    if (dot(before, point.frame.n) < std::numbers::sqrt2_v<float> / 2) ++of.steep;
  }
}

}  // namespace

std::vector<std::string> steep_map_notes(const Scene& scene) {
  const Geometry& g = scene.geometry();
  std::vector<std::vector<std::uint32_t>> triangles(scene.materials().size());
  std::vector<bool> mapped(scene.materials().size());
  for (std::uint32_t m = 0; m < mapped.size(); ++m) mapped[m] = has_map(scene, m);
  const auto add = [&](std::uint32_t first, const std::vector<std::uint32_t>& materials) {
    for (std::uint32_t t = 0; t < materials.size(); ++t)
      if (mapped[materials[t]]) triangles[materials[t]].push_back(first + t);
  };
  add(0, g.material);
  // A mesh counts once, however often it is placed.
  std::vector<bool> added(g.meshes.size());
  for (const Instance& instance : g.instances) {
    if (!added[instance.mesh]) add(instance.first, g.meshes[instance.mesh]->material);
    added[instance.mesh] = true;
  }
  std::vector<Looked> looked(scene.materials().size());
  for (const std::vector<std::uint32_t>& of_one : triangles)
    if (!of_one.empty()) look_at(scene, of_one, looked);
  std::vector<std::string> notes;
  std::size_t more = 0;
  for (std::size_t m = 0; m < looked.size(); ++m) {
    const double share =
        static_cast<double>(looked[m].steep) / static_cast<double>(std::max<std::size_t>(looked[m].points, 1));
    // Fewer slopes change the picture by no more than maps that differ by their filter alone.
    if (!(share > 0.05)) continue;
    if (notes.size() == kMostLines)
      ++more;
    else
      notes.push_back(
          fmt::format("material \"{}\" has a steep map, which turns the normal by more than 45 degrees on "
                      "{:.0f}% of its surface: it looks brighter than in programs where such normals lose "
                      "light",
                      scene.materials()[m].name, 100 * share));
  }
  if (more > 0) notes.push_back(fmt::format("more materials with steep maps: {}", more));
  return notes;
}

}  // namespace glowworm
