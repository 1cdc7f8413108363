// Sorting of a few hundred photons into compact blocks.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace glowworm {

/// Photons in a block; compact_sort() never divides a block.
inline constexpr std::size_t kCompactWidth = 8;
/// The distance, in radii, that weighs as much as a difference of one between normals, and the weight of a difference
/// of radii. (Measured: fewest blocks tested on the atrium.)
inline constexpr float kCompactNormalWeight = 1, kCompactRadiusWeight = 2;

/// Sort data of a photon, all finite.
struct alignas(32) CompactRow {
  static constexpr int kRadius = 6, kIndex = 7;

  float coordinate[8];  ///< position x, y, z, metres; unit normal x, y, z; radius, metres; the bits of an index

  std::uint32_t index() const { return std::bit_cast<std::uint32_t>(coordinate[kIndex]); }
  void set_index(std::uint32_t index) { coordinate[kIndex] = std::bit_cast<float>(index); }
};

/// Sorts rows so that every aligned run of 8, 16, 32, ... of them is compact: divides them along the coordinate with
/// the largest spread, with a power of two of blocks in the first part, and continues with both parts. Rows with the
/// same coordinate keep their order.
/// @param scratch working memory for as many rows
/// @param column  working memory for as many numbers
void compact_sort(std::span<CompactRow> rows, std::span<CompactRow> scratch, std::span<float> column);

}  // namespace glowworm
