// Sorting of photons into compact blocks.
#include "density/compact_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <vector>

#include "core/random.h"

namespace glowworm {
namespace {

using Rows = std::vector<CompactRow>;

float fraction(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(i, which)); }

/// Rows whose coordinates `make` fills in, numbered.
Rows make_rows(std::size_t count, const std::function<void(CompactRow&, std::uint32_t)>& make) {
  Rows rows(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    rows[i] = {};
    make(rows[i], i);
    rows[i].set_index(i);
  }
  return rows;
}

/// Many coordinates equal, zeros of both signs among them.
void ties(CompactRow& row, std::uint32_t i) {
  for (std::uint32_t c = 0; c < 7; ++c) row.coordinate[c] = static_cast<float>(hash_combine(i, c) % 3) - 1;
  if (i % 2 == 0) row.coordinate[0] *= -1;
  row.coordinate[CompactRow::kRadius] = 0.1f;
}

void all_the_same(CompactRow& row, std::uint32_t) { row.coordinate[0] = 3; }

Rows sorted(Rows rows) {
  // Sentinels: what lies around the arrays stays as it is.
  Rows padded(rows.size() + 2), scratch(rows.size() + 2);
  std::memset(static_cast<void*>(padded.data()), 0x5a, padded.size() * sizeof(CompactRow));
  std::memset(static_cast<void*>(scratch.data()), 0x5a, scratch.size() * sizeof(CompactRow));
  const CompactRow sentinel = padded[0];
  std::copy(rows.begin(), rows.end(), padded.begin() + 1);
  std::vector<CompactRow> column(rows.size() / 8 + 2);
  compact_sort(std::span(padded).subspan(1, rows.size()), std::span(scratch).subspan(1, rows.size()),
               {column.data()->coordinate, 8 * ((rows.size() + 7) / 8)});
  for (const CompactRow* other : {&padded.front(), &padded.back(), &scratch.front(), &scratch.back()})
    EXPECT_EQ(0, std::memcmp(other, &sentinel, sizeof sentinel));
  return {padded.begin() + 1, padded.end() - 1};
}

TEST(CompactSort, KeepsTheOrderOfEqualRows) {
  const Rows found = sorted(make_rows(500, all_the_same));
  for (std::uint32_t i = 0; i < found.size(); ++i) EXPECT_EQ(i, found[i].index());
}

TEST(CompactSort, KeepsEveryRow) {
  const Rows found = sorted(make_rows(500, ties));
  std::vector<std::uint32_t> indices;
  for (const CompactRow& row : found) indices.push_back(row.index());
  std::sort(indices.begin(), indices.end());
  for (std::uint32_t i = 0; i < indices.size(); ++i) EXPECT_EQ(i, indices[i]);
}

TEST(CompactSort, CutsAlongTheLargestSpread) {
  // On a square of 1 m: blocks of eight of 512 points lie in cells of an eighth.
  const Rows found = sorted(make_rows(512, [](CompactRow& row, std::uint32_t i) {
    row.coordinate[0] = fraction(i, 0);
    row.coordinate[1] = fraction(i, 1);
    row.coordinate[5] = 1;
    row.coordinate[CompactRow::kRadius] = 0.01f;
  }));
  double sum = 0;
  for (std::size_t block = 0; block < 64; ++block)
    for (int axis = 0; axis < 2; ++axis) {
      float low = 1, high = 0;
      for (std::size_t i = 8 * block; i < 8 * block + 8; ++i) {
        low = std::min(low, found[i].coordinate[axis]);
        high = std::max(high, found[i].coordinate[axis]);
      }
      sum += high - low;
    }
  EXPECT_LT(sum / 128, 0.125);
}

TEST(CompactSort, SeparatesNormalsAndRadii) {
  // Two sides of a sheet, and two radii, each of which outweighs the distance of 1 m between the points.
  for (const int which : {5, 6}) {
    const Rows found = sorted(make_rows(16, [&](CompactRow& row, std::uint32_t i) {
      row.coordinate[0] = static_cast<float>(i) / 16;
      row.coordinate[CompactRow::kRadius] = 2;
      row.coordinate[which] += i % 2 ? 1.0f : -1.0f;
    }));
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(found[i / 8 * 8].coordinate[which], found[i].coordinate[which]);
  }
}

}  // namespace
}  // namespace glowworm
