// The Hilbert curve in three dimensions, from a table of orientations (an L-system).
#pragma once
#include <cstdint>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// The most bits per axis that fit into a 64-bit Morton code or Hilbert key.
inline constexpr int kHilbertMaxBits = 21;

/// Interleaves the low 21 bits of three numbers: bit i of x, y, z becomes bit 3i, 3i + 1, 3i + 2.
std::uint64_t morton_code(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// The position on the Hilbert curve of the cell with a given Morton code, in a grid of 2^bits cells per axis. A key of
/// fewer bits is a prefix of a longer one.
/// @param bits 0 to 21; bits of `morton` above 3 * bits are ignored
std::uint64_t hilbert_key_of_morton(std::uint64_t morton, int bits);

/// A cell of a grid.
struct GridCell {
  std::uint32_t x, y, z;
  friend bool operator==(const GridCell&, const GridCell&) = default;
};

/// A grid of equal cubes, 2^bits along each axis, that covers a box. The longest side of the box determines their size.
class CubeGrid {
 public:
  /// @param bits 0 to 21. If the box is empty, a point or not finite, the grid uses only one cell.
  CubeGrid(const Box3& box, int bits);

  /// The cell of a point. Points outside the box, and NaN, go to a cell at the border.
  GridCell cell(Vec3 p) const { return {along(p.x, origin_.x), along(p.y, origin_.y), along(p.z, origin_.z)}; }
  std::uint64_t morton(Vec3 p) const {
    const GridCell c = cell(p);
    return morton_code(c.x, c.y, c.z);
  }

 private:
  std::uint32_t along(float p, float origin) const {
    const float v = (p - origin) * cells_per_metre_;
    // NaN fails the first test.
    return v > 0 ? v < last_ ? static_cast<std::uint32_t>(v) : static_cast<std::uint32_t>(last_) : 0;
  }
  Vec3 origin_;
  float cells_per_metre_ = 0;
  float last_ = 0;
};

}  // namespace glowworm
