// The Hilbert curve in three dimensions, from a table of the orientations it takes (an L-system).
#pragma once
#include <array>
#include <cstdint>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// Most bits an axis that Morton codes and Hilbert keys have room for in 64 bits.
inline constexpr int kHilbertMaxBits = 21;

/// How the curve goes through the eight octants of a cell, for each of its 24 orientations. An octant is
/// (x upper half) + 2 (y upper half) + 4 (z upper half). The curve of the whole cube starts in orientation 0 whatever
/// the depth, so that a key of fewer bits is the upper part of a key of more.
struct HilbertTables {
  static constexpr int kOrientations = 24;
  /// By orientation and octant: the place of the octant on the curve (0 to 7), plus 8 times the orientation inside it.
  std::array<std::array<std::uint8_t, 8>, kOrientations> place{};
  /// By orientation and place on the curve: the octant that is visited there. The child order of an octree.
  std::array<std::array<std::uint8_t, 8>, kOrientations> octant{};
  /// Two levels at once: by orientation and octant of octant (6 bits), the place (0 to 63) plus 64 times the
  /// orientation.
  std::array<std::array<std::uint16_t, 64>, kOrientations> place2{};
  constexpr HilbertTables();
};
extern const HilbertTables kHilbert;

/// Interleaves the low 21 bits of the three numbers: bit i of x, y, z becomes bit 3i, 3i + 1, 3i + 2.
std::uint64_t morton_code(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// The place on the Hilbert curve of the cell with that Morton code, in a grid of 2^bits cells an axis.
/// @param bits 0 to 21; bits of `morton` above 3 * bits are not looked at
std::uint64_t hilbert_key_of_morton(std::uint64_t morton, int bits);

/// The place of cell (x, y, z) on the Hilbert curve through a grid of 2^bits cells an axis: 0 to 8^bits - 1.
std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits);

/// A cell of a grid.
struct GridCell {
  std::uint32_t x, y, z;
  friend bool operator==(const GridCell&, const GridCell&) = default;
};

/// The inverse of hilbert_key().
GridCell hilbert_cell(std::uint64_t key, int bits);

/// Cubes of equal size, 2^bits along each axis, that cover a box; the longest side of the box decides how large.
class CubeGrid {
 public:
  /// @param bits 0 to 21. A box that is empty, a point or not finite gives a grid of which only one cell is used.
  CubeGrid(const Box3& box, int bits);

  /// The cell of a point; points outside the box, and not a number, go to a cell at the border.
  GridCell cell(Vec3 p) const { return {along(p.x, origin_.x), along(p.y, origin_.y), along(p.z, origin_.z)}; }
  std::uint64_t morton(Vec3 p) const {
    const GridCell c = cell(p);
    return morton_code(c.x, c.y, c.z);
  }

 private:
  std::uint32_t along(float p, float origin) const {
    const float v = (p - origin) * cells_per_metre_;
    // Written so that what is not a number fails the first test.
    return v > 0 ? v < last_ ? static_cast<std::uint32_t>(v) : static_cast<std::uint32_t>(last_) : 0;
  }
  Vec3 origin_;
  float cells_per_metre_ = 0;
  float last_ = 0;
};

}  // namespace glowworm
