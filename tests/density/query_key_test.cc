// Sort keys of query points.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "density/blocked_queries.h"

namespace glowworm {
namespace {

TEST(QueryKeys, TheCurveVisitsEverySquareOfASheetOnceAndMovesOneSquareAStep) {
  constexpr std::uint32_t kSide = 1u << kKeyLevels, kSquares = kSide * kSide;
  KeyGrid grid;
  grid.cells_per_metre = 1.0f / kSide;  // one cell, whose parts are cubes of a metre
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    for (std::uint32_t slab = 0; slab < 1u << kKeySlabBits; ++slab) {
      Vec3 normal{0, 0, 0};
      normal[static_cast<int>(axis)] = 1;
      std::vector<Vec3> positions(kSquares), by_key(kSquares, Vec3{-1, -1, -1});
      for (std::uint32_t i = 0; i < kSquares; ++i) {
        positions[i][static_cast<int>(axis)] = static_cast<float>(slab * kSide >> kKeySlabBits) + 0.5f;
        positions[i][static_cast<int>(axis + 1) % 3] = static_cast<float>(i % kSide) + 0.5f;
        positions[i][static_cast<int>(axis + 2) % 3] = static_cast<float>(i / kSide) + 0.5f;
      }
      for (std::uint32_t i = 0; i < kSquares; ++i) {
        const std::uint32_t key = query_key(grid, positions[i], normal, true);
        ASSERT_EQ(key >> kKeyCurveBits, 2 * axis << kKeySlabBits | slab);
        by_key[key & (kSquares - 1)] = positions[i];
      }
      for (std::uint32_t i = 0; i < kSquares; ++i) {
        ASSERT_GE(by_key[i].x, 0) << "no square at " << i;
        if (i == 0) continue;
        const Vec3 step = by_key[i] - by_key[i - 1];
        ASSERT_EQ(std::abs(step.x) + std::abs(step.y) + std::abs(step.z), 1.0f);
      }
    }
  }
}

TEST(QueryKeys, TellsCellsAndDirectionsApart) {
  KeyGrid grid;
  grid.origin.x = -2;
  grid.cells_per_metre = 1;
  grid.cells[0] = 4;
  grid.cells[1] = 3;
  grid.cells[2] = 2;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const std::vector<Vec3> positions = {{-1.5f, 0.5f, 0.5f}, {1.5f, 2.5f, 1.5f}, {-50, 99, 0.5f}, {0.5f, 0.5f, 0.5f},
                                       {nan, 0, 0},         {0, infinity, 0},   {0, 0, 0},       {0.5f, 0.5f, 0.5f}};
  const std::vector<Vec3> normals = {{1, 0, 0}, {-0.8f, 0.6f, 0}, {0, 0.7f, -0.7f}, {0.1f, -0.9f, 0.2f},
                                     {0, 0, 1}, {0, 0, 1},        {0, nan, 1},      {0, 0, -1}};
  std::vector<std::uint32_t> keys;
  for (std::size_t i = 0; i < 8; ++i) keys.push_back(query_key(grid, positions[i], normals[i], i < 7));
  const auto cell = [&](int i) { return keys[static_cast<std::size_t>(i)] >> kKeyCellShift; };
  const auto group = [&](int i) { return keys[static_cast<std::size_t>(i)] >> kKeyGroupShift & 7; };
  EXPECT_EQ(cell(0), 0u);
  EXPECT_EQ(cell(1), 23u);
  EXPECT_EQ(cell(2), 8u);
  EXPECT_EQ(cell(3), 2u);
  EXPECT_EQ(group(0), 0u);
  EXPECT_EQ(group(1), 1u);
  EXPECT_EQ(group(2), 2u);
  EXPECT_EQ(group(3), 3u);
  EXPECT_EQ(group(7), kNotLambertianGroup);
  for (std::size_t i = 4; i < 7; ++i) EXPECT_EQ(keys[i], kNoKey);
}

}  // namespace
}  // namespace glowworm
