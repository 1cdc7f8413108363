// From the samples of a texel, as stored, to linear numbers.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/rgb.h"
#include "image/image_file.h"
#include "image/texture_file.h"

namespace glowworm {

/// The transfer function for `options`, given the one that the file names.
TransferFunction resolve_encoding(const TextureOptions& options, const TransferFunction& of_file);

/// Decodes samples of one type and transfer function; integers by a table.
class TexelDecoder {
 public:
  TexelDecoder(SampleType type, const TransferFunction& transfer);

  /// Sample `index` of an array as a linear number; 0 where it is not finite.
  float color(const std::byte* samples, std::size_t index) const;
  /// The same without the transfer function.
  float alpha(const std::byte* samples, std::size_t index) const;

 private:
  float plain(const std::byte* samples, std::size_t index) const;

  SampleType type_;
  TransferFunction transfer_;
  std::vector<float> table_;  // of integer codes; empty where there is nothing but a division to do
};

/// How many channels of a texel textures read: 1 or 3 of colour, and alpha where the header names it.
int kept_channels(const ImageFileHeader& header);
/// Copies those channels of interleaved samples to `to`, alpha last.
void keep_channels(const ImageFileHeader& header, std::span<const std::byte> samples, std::byte* to);

/// Whether every alpha of interleaved samples is 1; `header` says where alpha is.
bool is_opaque(const ImageFileHeader& header, const std::vector<std::byte>& samples);

}  // namespace glowworm
