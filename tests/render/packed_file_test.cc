#include "film/packed_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "core/content_hash.h"
#include "core/parallel.h"

namespace glowworm {
namespace {

using Bytes = std::vector<std::byte>;

Bytes packed(std::span<const std::byte> bytes, std::size_t piece) {
  Bytes out;
  PackedWriter writer([&](std::span<const std::byte> more) { out.insert(out.end(), more.begin(), more.end()); });
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    writer.write(bytes.subspan(at, std::min(piece, bytes.size() - at)));
  writer.finish();
  return out;
}

/// Takes numbers apart one byte at a time.
Bytes sorted_plainly(std::span<const std::byte> bytes) {
  Bytes out;
  const std::size_t whole = bytes.size() / 16 * 16;
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t at = i; at < whole; at += 16) out.push_back(bytes[at]);
  out.insert(out.end(), bytes.begin() + static_cast<std::ptrdiff_t>(whole), bytes.end());
  return out;
}

/// The blocks of packed bytes, each as its header tells and its bytes before compression.
std::vector<Bytes> blocks_of(std::span<const std::byte> packed) {
  std::vector<Bytes> out;
  while (true) {
    std::uint32_t sizes[2];
    std::uint64_t hash = 0;
    std::memcpy(sizes, packed.data(), sizeof sizes);
    std::memcpy(&hash, packed.data() + sizeof sizes, sizeof hash);
    packed = packed.subspan(sizeof sizes + sizeof hash);
    if (sizes[0] == 0) break;
    out.emplace_back(sizes[0]);
    EXPECT_EQ(ZSTD_decompress(out.back().data(), sizes[0], packed.data(), sizes[1]), sizes[0]);
    ContentHash expected;
    expected.add_bytes(packed.data(), sizes[1]);
    EXPECT_EQ(hash, expected.value());
    packed = packed.subspan(sizes[1]);
  }
  EXPECT_TRUE(packed.empty());
  return out;
}

Bytes random_bytes(std::size_t count) {
  Bytes out(count);
  std::uint64_t state = 1;
  for (std::byte& byte : out) byte = static_cast<std::byte>((state = state * 6364136223846793005u + 1) >> 56);
  return out;
}

TEST(PackedFile, HoldsTheBytesOfNumbersByTheirPlaces) {
  constexpr std::size_t kBlock = 1 << 20;
  for (const std::size_t size : {0ul, 1ul, 16ul, 255ul, 256ul, 4111ul, kBlock, kBlock + 1, 2 * kBlock - 17}) {
    const Bytes bytes = random_bytes(size);
    const std::vector<Bytes> blocks = blocks_of(packed(bytes, 1000000));
    ASSERT_EQ(blocks.size(), (size + kBlock - 1) / kBlock);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const std::span<const std::byte> raw = std::span(bytes).subspan(i * kBlock, std::min(kBlock, size - i * kBlock));
      EXPECT_TRUE(blocks[i] == sorted_plainly(raw)) << size;
    }
  }
}

TEST(PackedFile, IsTheSameForAnyPiecesAndThreads) {
  const Bytes bytes = random_bytes((std::size_t{9} << 20) + 12345);
  const Bytes whole = packed(bytes, bytes.size());
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    EXPECT_TRUE(packed(bytes, 300001) == whole);
    std::span<const std::byte> left = whole;
    PackedReader reader([&](std::span<std::byte> to) {
      if (to.size() > left.size()) return false;
      std::copy_n(left.begin(), to.size(), to.begin());
      left = left.subspan(to.size());
      return true;
    });
    Bytes back(bytes.size());
    EXPECT_TRUE(reader.read(std::span(back).first(70001)) && reader.read(std::span(back).subspan(70001)));
    EXPECT_TRUE(reader.at_end());
    EXPECT_TRUE(back == bytes);
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace glowworm
