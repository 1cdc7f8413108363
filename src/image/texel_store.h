// Texels of many textures in one temporary file, with a cache of fixed size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/block_cache.h"
#include "core/unnamed_file.h"
#include "image/image_file.h"

namespace glowworm {

/// Blocks of texels in a file without a name (core/unnamed_file.h), read through a BlockCache. Reading is thread-safe.
class TexelStore {
 public:
  static constexpr std::size_t kBlockBytes = 4096;

  /// @param cache_bytes memory for cached blocks, rounded down to whole sets, but at least one set
  /// Throws Error if no temporary file can be created.
  explicit TexelStore(std::uint64_t cache_bytes);

  /// Writes whole blocks from `first` on. They must not have been read before. Throws Error if the disk is full or
  /// fails.
  void write(std::uint64_t first, std::span<const std::byte> blocks);
  /// Copies a part of a block to `to`. Throws Error if the disk fails.
  void read(std::uint64_t block, std::size_t offset, std::span<std::byte> to);

  /// Size of the cache in bytes.
  std::uint64_t cache_bytes() const { return cache_.bytes(); }

 private:
  UnnamedFile file_;
  BlockCache cache_;
};

/// Location of a picture's texels in a store: square tiles with a power of two texels per side, one block per tile, row
/// by row. A texel has 1 or 3 colour samples and, last, alpha if the picture has it.
struct StoredTexels {
  ImageFileHeader header;   ///< alpha_channel is -1 if alpha is 1 everywhere
  std::uint64_t first = 0;  ///< first block
  std::uint64_t blocks = 0;
  int tile_width_bits = 0, tile_height_bits = 0;
  int tiles_across = 0;
  int texel_bytes = 0;

  std::uint64_t block_of(int x, int y) const {
    return first + static_cast<std::uint64_t>(y >> tile_height_bits) * static_cast<std::uint64_t>(tiles_across) +
           static_cast<std::uint64_t>(x >> tile_width_bits);
  }
  std::size_t offset_of(int x, int y) const {
    const int column = x & ((1 << tile_width_bits) - 1), row = y & ((1 << tile_height_bits) - 1);
    return static_cast<std::size_t>((row << tile_width_bits) + column) * static_cast<std::size_t>(texel_bytes);
  }
};

/// Result of storing a picture.
struct StoringOutcome {
  StoredTexels texels;
  std::string problem;  ///< the reason if the store could not hold the texels; empty on success
};

/// Decodes a picture once, by bands of rows, into blocks of a store from `first` on. Throws Error as read_image_file()
/// does if the picture is invalid. If the store fails, the outcome says so.
StoringOutcome store_texels(const std::string& path, TexelStore& store, std::uint64_t first);

}  // namespace glowworm
