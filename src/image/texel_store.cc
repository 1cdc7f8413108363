#include "image/texel_store.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "core/error.h"
#include "image/texel_decoder.h"

namespace glowworm {

TexelStore::TexelStore(std::uint64_t cache_bytes)
    : cache_(kBlockBytes, std::max(static_cast<std::size_t>(cache_bytes / kBlockBytes), BlockCache::kWays)) {}

void TexelStore::write(std::uint64_t first, std::span<const std::byte> blocks) {
  file_.write(first * kBlockBytes, blocks);
}

void TexelStore::read(std::uint64_t block, std::size_t offset, std::span<std::byte> to) {
  cache_.access(
      block, [&](std::span<std::byte> data) { file_.read(block * kBlockBytes, data); },
      [&](std::span<std::byte> data) { std::memcpy(to.data(), data.data() + offset, to.size()); });
}

namespace {

StoredTexels layout_of(const ImageFileHeader& header, std::uint64_t first) {
  StoredTexels texels;
  texels.header = header;
  texels.first = first;
  texels.texel_bytes = kept_channels(header) * static_cast<int>(size_of(header.type));
  const std::size_t most = TexelStore::kBlockBytes / static_cast<std::size_t>(texels.texel_bytes);
  const int bits = static_cast<int>(std::bit_width(most)) - 1;
  texels.tile_width_bits = (bits + 1) / 2;
  texels.tile_height_bits = bits / 2;
  const auto tiles = [](int length, int tile_bits) { return ((length - 1) >> tile_bits) + 1; };
  texels.tiles_across = tiles(header.width, texels.tile_width_bits);
  texels.blocks = static_cast<std::uint64_t>(texels.tiles_across) *
                  static_cast<std::uint64_t>(tiles(header.height, texels.tile_height_bits));
  return texels;
}

// Takes a picture's rows from the top down, and writes each row of tiles when it is complete.
class TileWriter {
 public:
  TileWriter(const StoredTexels& texels, TexelStore& store)
      : texels_(texels),
        store_(store),
        tiles_(static_cast<std::size_t>(texels.tiles_across) * TexelStore::kBlockBytes),
        kept_(static_cast<std::size_t>(texels.header.width) * static_cast<std::size_t>(texels.texel_bytes)) {}

  void add(std::span<const std::byte> samples) {
    const std::size_t row_bytes = static_cast<std::size_t>(texels_.header.width) *
                                  static_cast<std::size_t>(texels_.header.channels) * size_of(texels_.header.type);
    for (; !samples.empty(); samples = samples.subspan(row_bytes)) add_row(samples.first(row_bytes));
  }

 private:
  void add_row(std::span<const std::byte> samples) {
    const auto width = static_cast<std::size_t>(texels_.header.width);
    keep_channels(texels_.header, samples, kept_.data());
    const std::size_t tile_width = std::size_t{1} << texels_.tile_width_bits;
    const auto texel_bytes = static_cast<std::size_t>(texels_.texel_bytes);
    const std::size_t offset = texels_.offset_of(0, row_);
    for (std::size_t x = 0, tile = 0; x < width; x += tile_width, ++tile) {
      std::memcpy(tiles_.data() + tile * TexelStore::kBlockBytes + offset, kept_.data() + x * texel_bytes,
                  std::min(tile_width, width - x) * texel_bytes);
    }
    ++row_;
    const int below = row_ & ((1 << texels_.tile_height_bits) - 1);
    if (below == 0 || row_ == texels_.header.height) store_.write(texels_.block_of(0, row_ - 1), tiles_);
  }

  StoredTexels texels_;
  TexelStore& store_;
  std::vector<std::byte> tiles_, kept_;
  int row_ = 0;
};

}  // namespace

StoringOutcome store_texels(const std::string& path, TexelStore& store, std::uint64_t first) {
  StoringOutcome outcome;
  std::optional<TileWriter> writer;
  bool opaque = true;
  scan_image_file(path, false, [&](const ImageFileHeader& header, const std::vector<std::byte>& samples) {
    if (!outcome.problem.empty()) return;
    if (!writer) {
      outcome.texels = layout_of(header, first);
      writer.emplace(outcome.texels, store);
    }
    opaque = opaque && is_opaque(header, samples);
    try {
      writer->add(samples);
    } catch (const Error& error) {
      outcome.problem = error.what();
    }
  });
  if (opaque) outcome.texels.header.alpha_channel = -1;
  return outcome;
}

}  // namespace glowworm
