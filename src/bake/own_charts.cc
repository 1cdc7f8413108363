// Charts from the texture coordinates of a file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bake/chart.h"
#include "bake/overlap.h"

namespace glowworm {

namespace {

constexpr double kMaxOverlap = 0.005;  ///< share of the cells: rounding of coordinates in 16 bits makes some
constexpr float kRounding = 1e-4f;     ///< by which coordinates may leave [0, 1]

float uv_area(const std::array<Vec2, 3>& c) {
  return 0.5f * std::abs((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x));
}

/// Whether an object has coordinates of its own; others have (0, 0).
bool has_coordinates(const Geometry& geometry, std::span<const BakeFace> faces, const Chart& chart) {
  if (geometry.second_uvs.empty()) return false;
  return std::any_of(chart.faces.begin(), chart.faces.end(), [&](std::uint32_t f) {
    const auto& corners = geometry.triangles[faces[f].triangle];
    return std::any_of(corners.begin(), corners.end(),
                       [&](std::uint32_t v) { return geometry.second_uvs[v].x != 0 || geometry.second_uvs[v].y != 0; });
  });
}

/// Makes a chart of an object's coordinates. Returns why they cannot be used; "" where they can.
std::string lay_out(const Geometry& geometry, std::span<const BakeFace> faces, Chart& chart) {
  double in_space = 0, in_texture = 0;
  std::size_t flat = 0;
  Vec2 low{1, 1}, high{0, 0};
  for (const std::uint32_t f : chart.faces) {
    if (faces[f].back) return "both sides of its surfaces are lit";
    std::array<Vec2, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec2 uv = geometry.second_uvs[geometry.triangles[faces[f].triangle][c]];
      const bool inside = uv.x >= -kRounding && uv.x <= 1 + kRounding && uv.y >= -kRounding && uv.y <= 1 + kRounding;
      if (!inside) return fmt::format("a vertex has ({:.3g}, {:.3g}), outside of [0, 1]", uv.x, uv.y);
      low = {std::min(low.x, uv.x), std::min(low.y, uv.y)};
      high = {std::max(high.x, uv.x), std::max(high.y, uv.y)};
      corners[c] = uv;
    }
    const float area = uv_area(corners);
    flat += !(area > 0);
    in_texture += area;
    in_space += geometry.area(faces[f].triangle);
    chart.corners.push_back(corners);
  }
  if (flat > 0) return fmt::format("{} of its triangles have no area in the texture", flat);
  if (const double share = overlapping_share(chart); share > kMaxOverlap)
    return fmt::format("{:.1f}% of their area overlaps", 100 * share);
  const auto metres = static_cast<float>(std::sqrt(in_space / in_texture));
  for (auto& corners : chart.corners)
    for (Vec2& p : corners) p = (p - low) * metres;
  chart.size = (high - low) * metres;
  return "";
}

}  // namespace

OwnCharts own_charts(const Geometry& geometry, std::span<const BakeFace> faces) {
  OwnCharts out;
  std::map<std::uint32_t, Chart> by_object;
  for (std::uint32_t f = 0; f < faces.size(); ++f) by_object[geometry.object_of(faces[f].triangle)].faces.push_back(f);
  for (auto& [object, chart] : by_object) {
    const bool has_own = has_coordinates(geometry, faces, chart);
    const std::string reason = has_own ? lay_out(geometry, faces, chart) : "";
    if (has_own && reason.empty()) {
      out.charts.push_back(std::move(chart));
      continue;
    }
    out.rest.insert(out.rest.end(), chart.faces.begin(), chart.faces.end());
    if (has_own) {
      const std::string name = object != kNone ? geometry.objects[object].name : "the mesh";
      out.reasons.push_back(
          fmt::format("'{}' gets texture coordinates for light instead of its own: {}", name, reason));
    }
  }
  return out;
}

}  // namespace glowworm
