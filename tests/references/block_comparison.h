// Finds differences of two noisy pictures beyond their noise, by blocks of pixels.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/rgb.h"

namespace glowworm {

/// What compare_blocks() finds in one block of pixels. Luminances, W sr^-1 m^-2.
struct BlockDifference {
  int x = 0, y = 0;           ///< its first pixel
  double reference = 0;       ///< mean of the reference
  double difference = 0;      ///< mean of picture less reference
  double standard_error = 0;  ///< of that difference
  double z() const { return standard_error > 0 ? difference / standard_error : 0; }
};

/// What a block may differ by, beside noise, before pictures count as different: a share of the block's mean and a
/// share of the picture's.
struct BlockTolerance {
  double of_block = 0.02;
  double of_picture = 0.01;
  /// Standard errors beyond that: 4 are exceeded by chance, on one side or the other, in one block of 16,000.
  double standard_errors = 4;
};

/// Differences of blocks, with what is left of them when their noise is taken off.
struct BlockComparison {
  std::vector<BlockDifference> blocks;
  double mean_ratio = 0;      ///< mean of the picture over mean of the reference, all pixels
  double standard_error = 0;  ///< of mean_ratio
  /// Root of (mean of squared differences less mean of squared standard errors), over the mean of the reference's
  /// blocks; 0 where noise explains all.
  double structured = 0;
  double share_beyond_3 = 0;  ///< of the blocks, |z| > 3; noise alone: 0.003
  /// The blocks of which noise does not explain that they differ by more than `tolerance`.
  std::vector<BlockDifference> different(const BlockTolerance& tolerance) const;
};

/// Compares the mean of several renders, alike but for their seeds, with a reference.
///
/// The error of a block's difference is estimated twice over, and both are added: by how the renders differ among
/// themselves (which sees photons, whose noise neighbouring pixels share), and by how the pixels of the block scatter
/// about a plane (which sees the reference's noise, too).
/// @param renders at least two pictures of width * height pixels
/// @param left_out share of the pixels, those of greatest relative error, that blocks leave out: fireflies of a noisy
///                 reference
BlockComparison compare_blocks(const std::vector<std::vector<RGB>>& renders, std::span<const RGB> reference, int width,
                               int height, int block, double left_out);

}  // namespace glowworm
