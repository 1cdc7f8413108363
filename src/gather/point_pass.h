// Gather points without a camera: points whose irradiance is computed, such as sensors and texels.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"
#include "gather/camera_pass.h"
#include "transport/vertex.h"

namespace glowworm {

/// Points in a grid of cells, row by row. A render of them fills a film of width x height pixels with irradiance in W
/// m^-2 instead of radiance.
struct PointGrid {
  int width = 0, height = 0;
  std::vector<Vec3> position;  ///< metres
  std::vector<Vec3> normal;    ///< unit; (0, 0, 0): the cell holds no point and stays black
  /// Surface number of each cell. The filter never averages cells of different surfaces. Empty: all cells are on one
  /// surface.
  std::vector<std::uint32_t> surface;
  /// Share of each cell's value, in [0, 1], that is the irradiance from behind the point; the rest is that from the
  /// side of its normal. Empty: none.
  std::vector<RGB> from_behind;
  /// Whether the points lie on surfaces of the scene, where photons are. Other points have no caustic map: gather rays
  /// that meet lights through specular bounces add caustics instead, and photons that pass the points those of lights
  /// without size (maps/air_light.h).
  bool on_surfaces = false;
  /// Whether a guide of gather rays learns from these points. The noise of a point then depends on the other points of
  /// the grid.
  bool learns = false;
  /// Whether light samples of the points leave out lights without size, whose direct light is computed elsewhere.
  bool delta_lights_apart = false;
  /// Random sequences of each cell, independent of each other, that its samples take in turn. The spread of their means
  /// tells the error of the mean over all samples; that of the samples of one sequence, which are stratified, tells
  /// more than there is.
  std::uint32_t batches = 1;
  std::uint32_t first_sequence = 0;  ///< random sequence of the first cell; others follow it

  /// Whether the cell holds a point.
  bool has(std::size_t cell) const { return normal[cell].x != 0 || normal[cell].y != 0 || normal[cell].z != 0; }
  /// Whether light from behind the cell's point counts.
  bool looks_behind(std::size_t cell) const { return !from_behind.empty() && !is_black(from_behind[cell]); }
  /// Appends a cell of another grid with its position, normal and share from behind.
  void append(const PointGrid& grid, std::size_t cell);
  /// Throws Error, with the cell, if arrays differ in length, a coordinate is not finite or a normal is not of unit
  /// length.
  void check() const;

  /// The random sequence of a cell that a sample is of, and its place there.
  std::uint32_t sequence(std::size_t cell, std::uint32_t sample) const;
  std::uint32_t place_in_sequence(std::uint32_t sample) const { return sample / batches; }
};

/// The viewpoint of a render: a camera, or points; or several cameras, for guides that learn from all of them.
struct View {
  View(const Camera& seen_by) : camera(&seen_by) {}
  View(const PointGrid& seen_at) : points(&seen_at) {}
  /// @param along at least one; the array must outlive the view
  View(std::span<const Camera* const> along) : camera(along.front()), along(along) {}
  const Camera* camera = nullptr;
  const PointGrid* points = nullptr;
  std::span<const Camera* const> along;

  /// All cameras: none, one, or those along the way.
  std::span<const Camera* const> cameras() const {
    if (points) return {};
    return along.empty() ? std::span<const Camera* const>(&camera, 1) : along;
  }
};

/// A grid point as a point of a surface.
SurfacePoint white_point(const Scene& scene, const PointGrid& grid, std::size_t cell);
/// A sample of a cell as a surface that reflects, and transmits from behind, all light diffusely: the value of the cell
/// is pi times its radiance.
Vertex white_vertex(const Tracer& tracer, const PointGrid& grid, std::size_t cell, std::uint32_t sample);

/// Marks the cell as hit in `first_hit`, with albedo 1 and a depth that only serves to distinguish surfaces.
void mark_point(const PointGrid& grid, std::size_t cell, FirstHit& first_hit, std::size_t slot);

/// Makes the gather points of tasks over the grid, in place of the camera pass. Resizes `radiance` and `first_hit`.
void point_pass(const Tracer& tracer, const PointGrid& grid, CameraTasks tasks, SlotRadiance& radiance,
                FirstHit& first_hit, GatherPoints& points, Statistics& statistics);

}  // namespace glowworm
