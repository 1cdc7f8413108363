// Converts samples of a texel, as stored, to linear numbers.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "image/image_file.h"
#include "image/texture_file.h"

namespace glowworm {

/// The transfer function for `options`, given the one named in the file.
TransferFunction resolve_encoding(const TextureOptions& options, const TransferFunction& of_file);

/// Decodes samples of one type and transfer function. Integers use a table.
class TexelDecoder {
 public:
  TexelDecoder(SampleType type, const TransferFunction& transfer);

  /// Sample `index` of an array as a linear number; 0 if it is not finite.
  float color(const std::byte* samples, std::size_t index) const;
  /// The colour whose samples begin at `first`: one if it is grey, else three.
  RGB color(const std::byte* samples, std::size_t first, bool grey) const {
    if (grey) return RGB(color(samples, first));
    return {color(samples, first), color(samples, first + 1), color(samples, first + 2)};
  }
  /// A sample without the transfer function.
  float alpha(const std::byte* samples, std::size_t index) const;

 private:
  float plain(const std::byte* samples, std::size_t index) const;

  SampleType type_;
  TransferFunction transfer_;
  std::vector<float> table_;  // for integer codes; empty if decoding is only a division
};

/// Number of channels that textures read: 1 or 3 for colour, plus alpha if the header has it.
int kept_channels(const ImageFileHeader& header);
/// Copies these channels of interleaved samples to `to`, alpha last.
void keep_channels(const ImageFileHeader& header, std::span<const std::byte> samples, std::byte* to);

/// Whether all alphas of interleaved samples are 1; `header` gives the position of alpha.
bool is_opaque(const ImageFileHeader& header, const std::vector<std::byte>& samples);

}  // namespace glowworm
