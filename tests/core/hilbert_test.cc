#include "core/hilbert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "core/random.h"

namespace glowworm {
namespace {

/// The position of cell (x, y, z) on the Hilbert curve in a grid of 2^bits cells per axis: 0 to 8^bits - 1.
std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits) {
  return hilbert_key_of_morton(morton_code(x, y, z), bits);
}

/// The inverse of hilbert_key().
GridCell hilbert_cell(std::uint64_t key, int bits) {
  GridCell cell{0, 0, 0};
  // The key of a coarser cell is the beginning of that of a cell in it.
  for (int level = bits - 1; level >= 0; --level)
    for (unsigned octant = 0; octant < 8; ++octant) {
      const GridCell child{cell.x << 1 | (octant & 1), cell.y << 1 | (octant >> 1 & 1), cell.z << 1 | octant >> 2};
      if (hilbert_key(child.x, child.y, child.z, bits - level) != key >> (3 * level)) continue;
      cell = child;
      break;
    }
  return cell;
}

int steps_between(GridCell a, GridCell b) {
  return std::abs(static_cast<int>(a.x) - static_cast<int>(b.x)) +
         std::abs(static_cast<int>(a.y) - static_cast<int>(b.y)) +
         std::abs(static_cast<int>(a.z) - static_cast<int>(b.z));
}

TEST(Hilbert, VisitsEveryCellOnceAndMovesOneCellAStep) {
  for (int bits = 0; bits <= 6; ++bits) {
    const std::uint64_t cells = std::uint64_t{1} << (3 * bits);
    std::vector<bool> seen(cells);
    GridCell before{0, 0, 0};
    for (std::uint64_t key = 0; key < cells; ++key) {
      const GridCell cell = hilbert_cell(key, bits);
      const std::uint64_t index = (static_cast<std::uint64_t>(cell.z) << bits | cell.y) << bits | cell.x;
      ASSERT_LT(index, cells);
      ASSERT_FALSE(seen[index]) << "key " << key << " of " << bits << " bits";
      seen[index] = true;
      if (key > 0) {
        ASSERT_EQ(steps_between(before, cell), 1) << "key " << key << " of " << bits << " bits";
      }
      ASSERT_EQ(hilbert_key(cell.x, cell.y, cell.z, bits), key);
      before = cell;
    }
  }
}

TEST(Hilbert, MovesOneCellAStepAtFullDepth) {
  constexpr std::uint64_t kSteps = std::uint64_t{1} << 63;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const std::uint64_t key = (static_cast<std::uint64_t>(hash32(i)) << 32 | hash32(i + 7777)) % (kSteps - 1);
    const GridCell a = hilbert_cell(key, 21), b = hilbert_cell(key + 1, 21);
    ASSERT_EQ(steps_between(a, b), 1);
    ASSERT_EQ(hilbert_key(a.x, a.y, a.z, 21), key);
  }
}

TEST(Hilbert, FewerBitsAreTheUpperPart) {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const std::uint32_t x = hash32(3 * i) & 0x1fffff, y = hash32(3 * i + 1) & 0x1fffff,
                        z = hash32(3 * i + 2) & 0x1fffff;
    const std::uint64_t key = hilbert_key(x, y, z, 21);
    for (int bits = 0; bits < 21; ++bits)
      ASSERT_EQ(hilbert_key(x >> (21 - bits), y >> (21 - bits), z >> (21 - bits), bits), key >> (3 * (21 - bits)));
  }
}

TEST(Hilbert, StaysCloserThanMortonOrder) {
  constexpr int kBits = 5;
  double hilbert = 0, morton = 0;
  std::vector<GridCell> by_morton(std::size_t{1} << (3 * kBits));
  for (std::uint32_t z = 0; z < 32; ++z)
    for (std::uint32_t y = 0; y < 32; ++y)
      for (std::uint32_t x = 0; x < 32; ++x) by_morton[morton_code(x, y, z)] = {x, y, z};
  // Distance between cells that lie 64 places apart; what a sorted block of points spans.
  for (std::size_t i = 64; i < by_morton.size(); ++i) {
    hilbert += steps_between(hilbert_cell(i, kBits), hilbert_cell(i - 64, kBits));
    morton += steps_between(by_morton[i], by_morton[i - 64]);
  }
  EXPECT_LT(hilbert, morton);
}

TEST(Hilbert, MortonInterleavesBits) {
  EXPECT_EQ(morton_code(1, 0, 0), 1u);
  EXPECT_EQ(morton_code(0, 1, 0), 2u);
  EXPECT_EQ(morton_code(0, 0, 1), 4u);
  EXPECT_EQ(morton_code(0x1fffff, 0x1fffff, 0x1fffff), 0x7fffffffffffffffull);
  EXPECT_EQ(morton_code(5, 3, 6), 0b101'110'011u + 0u);
}

TEST(CubeGrid, PutsPointsInCells) {
  const CubeGrid grid({{-1, -1, -1}, {7, 1, 3}}, 3);
  EXPECT_EQ(grid.cell({-1, -1, -1}), (GridCell{0, 0, 0}));
  EXPECT_EQ(grid.cell({0.5f, 0.5f, 2.5f}), (GridCell{1, 1, 3}));
  EXPECT_EQ(grid.cell({7, 1, 3}), (GridCell{7, 2, 4}));
  EXPECT_EQ(grid.cell({-100, 100, 1e30f}), (GridCell{0, 7, 7}));
}

TEST(CubeGrid, AcceptsPointsThatAreNotFinite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  const CubeGrid grid({{0, 0, 0}, {1, 1, 1}}, 21);
  EXPECT_EQ(grid.cell({kNan, kInfinity, -kInfinity}), (GridCell{0, 0x1fffff, 0}));
  for (const Box3& box : {Box3(), Box3{{2, 2, 2}, {2, 2, 2}}, Box3{{-3e38f, 0, 0}, {3e38f, 0, 0}}}) {
    EXPECT_EQ(CubeGrid(box, 8).cell({5, -7, 9}), (GridCell{0, 0, 0}));
  }
}

}  // namespace
}  // namespace glowworm
