#include "gather/point_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "gather/cell_place.h"
#include "transport/medium.h"

namespace glowworm {

namespace {

/// Offset of rays from a point whose triangle is not known, relative to the largest coordinate of point and scene:
/// several times the rounding of points on triangles as large as the scene (core/offset_origin.h).
constexpr float kPointOffset = 0x1p-20f;

float largest_coordinate(Vec3 p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

}  // namespace

void PointGrid::check() const {
  const auto cells = static_cast<std::size_t>(std::max(width, 0)) * static_cast<std::size_t>(std::max(height, 0));
  if (cells == 0 || position.size() != cells || normal.size() != cells ||
      (!surface.empty() && surface.size() != cells) || (!from_behind.empty() && from_behind.size() != cells))
    throw Error(fmt::format("a grid of {}x{} points has {} positions and {} normals", width, height, position.size(),
                            normal.size()),
                "Give one position and one normal for each cell, and at least one cell.");
  for (std::size_t i = 0; i < cells; ++i) {
    if (!has(i)) continue;
    const Vec3 p = position[i], n = normal[i];
    if (!std::isfinite(dot(p, p)))
      throw Error(fmt::format("point {} has no finite position: ({}, {}, {})", i, p.x, p.y, p.z));
    // Rounding may change the squared length.
    if (!(std::abs(dot(n, n) - 1) <= 1e-3f))
      throw Error(fmt::format("point {} has the normal ({}, {}, {}), which is not of unit length", i, n.x, n.y, n.z));
  }
}

void PointGrid::append(const PointGrid& grid, std::size_t cell) {
  position.push_back(grid.position[cell]);
  normal.push_back(grid.normal[cell]);
  if (!grid.from_behind.empty()) from_behind.push_back(grid.from_behind[cell]);
}

std::uint32_t PointGrid::sequence(std::size_t cell, std::uint32_t sample) const {
  const std::uint32_t first = first_sequence + static_cast<std::uint32_t>(cell);
  return batches > 1 ? hash_combine(first, sample % batches) : first;
}

SurfacePoint white_point(const Scene& scene, const PointGrid& grid, std::size_t cell) {
  SurfacePoint point;
  point.position = grid.position[cell];
  point.geometric_normal = grid.normal[cell];
  point.frame = Frame::from_normal(point.geometric_normal);
  float largest = largest_coordinate(point.position);
  const Box3 bounds = scene.bounds();
  if (!bounds.empty()) largest = std::max({largest, largest_coordinate(bounds.min), largest_coordinate(bounds.max)});
  point.offset = kPointOffset * largest;
  return point;
}

Vertex white_vertex(const Tracer& tracer, const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
  Vertex out{white_point(tracer.scene(), grid, cell), grid.normal[cell], {}};
  out.point.position = place_in_cell(grid, cell, sample);
  out.bsdf.diffuse = RGB(1.0f);
  const bool looks_behind = grid.looks_behind(cell);
  if (looks_behind) {
    out.bsdf.transmission = grid.from_behind[cell];
    out.bsdf.diffuse = out.bsdf.diffuse - out.bsdf.transmission;
  }
  if (tracer.scene().media().empty()) return out;
  out.media.front = medium_at_start(tracer, out.point.position, out.wo);
  if (looks_behind) out.media.back = medium_at_start(tracer, out.point.position, -out.wo);
  return out;
}

void mark_point(const PointGrid& grid, std::size_t cell, FirstHit& first_hit, std::size_t slot) {
  first_hit.albedo[slot] = RGB(1.0f);
  first_hit.normal[slot] = grid.normal[cell];
  // Depths of neighbouring surfaces differ by at least a factor of two.
  first_hit.depth[slot] = grid.surface.empty() ? 1.0f : std::ldexp(1.0f, static_cast<int>(grid.surface[cell] % 32));
}

void point_pass(const Tracer& tracer, const PointGrid& grid, CameraTasks tasks, SlotRadiance& radiance,
                FirstHit& first_hit, GatherPoints& points, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::camera_pass);
  const bool in_media = !tracer.scene().media().empty();
  radiance.resize(tasks.slot_count(), in_media);
  first_hit.resize(tasks.slot_count(), false);
  std::fill(first_hit.depth.begin(), first_hit.depth.end(), std::numeric_limits<float>::infinity());
  points.clear();
  points.reserve(tasks.slot_count());
  std::size_t slot = 0;
  const auto add = [&](int x, int y, std::uint32_t sample) {
    const auto cell = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x);
    if (!grid.has(cell)) return;
    mark_point(grid, cell, first_hit, slot);
    add_gather_point(points, white_vertex(tracer, grid, cell, sample), RGB(kPi), static_cast<std::uint32_t>(slot),
                     grid.sequence(cell, sample), grid.place_in_sequence(sample), in_media);
  };
  for (const CameraTask& task : tasks)
    for (std::uint32_t s = 0; s < task.sample_count; ++s)
      for (int y = task.y0; y < task.y1; ++y)
        for (int x = task.x0; x < task.x1; ++x, ++slot)
          if (task.has(x, y)) add(x, y, task.first_sample + s);
  statistics.add(Counter::gather_points, points.size());
}

}  // namespace glowworm
