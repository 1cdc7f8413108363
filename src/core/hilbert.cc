#include "core/hilbert.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace glowworm {

namespace {

constexpr unsigned rotate_left3(unsigned v, unsigned by) {
  by %= 3;
  return ((v << by) | (v >> (3 - by))) & 7u;
}
constexpr unsigned gray_code(unsigned i) { return i ^ (i >> 1); }

/// The order in which the curve visits the eight octants of a cell, for each of its 24 orientations: by orientation and
/// octant, (x upper half) + 2 (y upper half) + 4 (z upper half), the place of the octant on the curve (0 to 7), plus 8
/// times its orientation. The curve of the whole cube has orientation 0.
///
/// Hamilton, "Compact Hilbert Indices" (Dalhousie University, technical report CS-2006-07): an orientation is the
/// corner `entry` where the curve enters the cube and the axis `direction` along which it leaves. Place w on the curve
/// is octant T^-1(gray(w)) with T as in section 2.1.3; the orientation of the child follows from the entry points of
/// theorem 2.10 and the directions of lemma 2.8.
constexpr auto kPlaces = [] {
  std::array<std::array<std::uint8_t, 8>, 24> place{};
  for (unsigned entry = 0; entry < 8; ++entry)
    for (unsigned direction = 0; direction < 3; ++direction)
      for (unsigned w = 0; w < 8; ++w) {
        const unsigned cell = rotate_left3(gray_code(w), direction + 1) ^ entry;
        const unsigned child_entry = w == 0 ? 0 : gray_code(2 * ((w - 1) / 2));
        const unsigned turn = w == 0       ? 0
                              : w % 2 == 0 ? static_cast<unsigned>(std::countr_one(w - 1)) % 3
                                           : static_cast<unsigned>(std::countr_one(w)) % 3;
        const unsigned next_entry = entry ^ rotate_left3(child_entry, direction + 1);
        const unsigned next = next_entry * 3 + (direction + turn + 1) % 3;
        place[entry * 3 + direction][cell] = static_cast<std::uint8_t>(w + 8 * next);
      }
  return place;
}();

/// Moves bit i of v to bit 3i, for the low 21 bits.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffffu;
  v = (v | v << 32) & 0x001f00000000ffffull;
  v = (v | v << 16) & 0x001f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  v = (v | v << 2) & 0x1249249249249249ull;
  return v;
}

}  // namespace

std::uint64_t morton_code(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

std::uint64_t hilbert_key_of_morton(std::uint64_t morton, int bits) {
  unsigned orientation = 0;
  std::uint64_t key = 0;
  for (int shift = 3 * bits - 3; shift >= 0; shift -= 3) {
    const unsigned step = kPlaces[orientation][morton >> shift & 7];
    key = key << 3 | (step & 7);
    orientation = step >> 3;
  }
  return key;
}

CubeGrid::CubeGrid(const Box3& box, int bits) {
  const float cells = static_cast<float>(1u << bits);
  last_ = cells - 1;
  if (box.empty()) return;
  origin_ = box.min;
  const Vec3 d = box.diagonal();
  const float scale = cells / std::max(d.x, std::max(d.y, d.z));
  cells_per_metre_ = std::isfinite(scale) ? scale : 0;
}

}  // namespace glowworm
