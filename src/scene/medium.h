// Participating media: what fills space between surfaces.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/box.h"
#include "core/rgb.h"
#include "core/transform.h"

namespace glowworm {

/// Values in the cells of a regular grid over a medium's bounds, factors on the medium's coefficients. Arrays have one
/// value for each cell, x fastest, then y; an empty one counts as 1 everywhere.
struct MediumGridValues {
  std::array<int, 3> size{0, 0, 0};  ///< number of cells along x, y and z
  std::vector<float> density;        ///< factor on sigma_a and sigma_s
  std::vector<RGB> sigma_a, sigma_s;
  std::vector<RGB> emission;

  std::size_t cell_count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
};

/// A grid of values with the maxima of blocks of its cells.
class MediumGrid {
 public:
  /// Throws Error if an array has another length than the grid, or a value that is negative or not finite.
  explicit MediumGrid(MediumGridValues values);

  const MediumGridValues& values() const { return values_; }
  /// Factors at a place.
  struct Point {
    RGB sigma_a{1.0f}, sigma_s{1.0f}, emission{1.0f};
  };
  /// Interpolates linearly between the centres of cells, as pbrt-v4 does: towards 0 in the outer half of those at the
  /// border. @param at in [0, 1]^3, across the bounds
  Point at(Vec3 at) const;

  /// Blocks of cells along each axis, for bounds on the coefficients within each.
  const std::array<int, 3>& blocks() const { return blocks_; }
  int cells_per_block() const { return cells_per_block_; }
  /// Upper bounds of at() in a block, without emission.
  Point bound(const std::array<int, 3>& block) const;
  /// Upper bounds everywhere.
  const Point& greatest() const { return greatest_; }

 private:
  MediumGridValues values_;
  std::array<int, 3> blocks_{1, 1, 1};
  int cells_per_block_ = 1;
  std::vector<float> most_density_;
  std::vector<RGB> most_sigma_a_, most_sigma_s_;
  Point greatest_;
};

/// What fills space between surfaces: it absorbs, scatters and emits light (Pharr, Jakob and Humphreys, "Physically
/// Based Rendering", 4th edition, chapter 11). The phase function is Henyey and Greenstein's (bsdf/phase.h).
struct Medium {
  std::string name;
  RGB sigma_a{0.0f}, sigma_s{0.0f};  ///< m^-1; factors on the grid's values where there is a grid
  float g = 0;                       ///< mean cosine of the phase function, in (-1, 1)
  RGB emission{0.0f};                ///< Le, W sr^-1 m^-2: the medium emits Le sigma_a; a factor on the grid's values
  Transform to_medium;               ///< from the scene's coordinates to the medium's own
  std::optional<Box3> bounds;        ///< in its own coordinates; vacuum outside of it. None: everywhere. Grids have one
  std::shared_ptr<const MediumGrid> grid;  ///< null: homogeneous (also within bounds)
};

/// Coefficients at a point.
struct MediumPoint {
  RGB sigma_a{0.0f}, sigma_s{0.0f};  ///< m^-1
  RGB emission{0.0f};                ///< Le sigma_a, W sr^-1 m^-3
};
/// @param position in the scene's coordinates
MediumPoint medium_point(const Medium& medium, Vec3 position);

/// Ways through a homogeneous medium of less opacity get work in proportion to it: they scatter little light, and the
/// noise of surfaces behind exceeds theirs.
inline constexpr float kThinOpacity = 0.25f;
inline bool is_homogeneous(const Medium& medium) { return !medium.grid; }
/// Whether a medium may emit light.
bool emits(const Medium& medium);
/// The largest sigma_t of any place and channel, m^-1.
float greatest_extinction(const Medium& medium);

/// A part of a ray, metres along it.
struct MediumSpan {
  float first = 0, last = 0;
  bool empty() const { return !(first < last); }
};
/// The part of [first, last) of a ray that lies within the medium's bounds; empty if none. `last` may be infinite.
MediumSpan span_in(const Medium& medium, Vec3 origin, Vec3 direction, float first, float last);

/// Walks along a ray through the blocks of a medium's grid (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for
/// Ray Tracing", 1987).
class BlockWalk {
 public:
  /// @param span span_in(), not empty
  BlockWalk(const Medium& medium, Vec3 origin, Vec3 direction, MediumSpan span);
  /// Where the ray leaves the block, at most the end of the span.
  float leaves() const { return std::min(std::min(next_[0], next_[1]), std::min(next_[2], last_)); }
  /// Largest sigma_t of the block, m^-1.
  float majorant() const;
  /// Goes on to the next block. Returns false behind the last.
  bool advance();

 private:
  const Medium& medium_;
  float last_;
  std::array<int, 3> block_{}, step_{};
  std::array<float, 3> next_{}, by_{};  // where the ray meets the next plane between blocks; distance between planes
};

/// Calls visit(first, last, majorant) for consecutive pieces of the part of a ray within [first, last) and the medium's
/// bounds, until it returns false. The majorant is at least sigma_t of every channel at every point of the piece, m^-1.
template <typename Visit>
void for_majorants(const Medium& medium, Vec3 origin, Vec3 direction, float first, float last, Visit&& visit) {
  const MediumSpan span = span_in(medium, origin, direction, first, last);
  if (span.empty()) return;
  if (is_homogeneous(medium)) {
    visit(span.first, span.last, greatest_extinction(medium));
    return;
  }
  float at = span.first;
  for (BlockWalk walk(medium, origin, direction, span);;) {
    const float leaves = walk.leaves();
    if (at < leaves && !visit(at, leaves, walk.majorant())) return;
    at = std::max(at, leaves);
    if (!walk.advance()) return;
  }
}

}  // namespace glowworm
