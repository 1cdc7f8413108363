// PNG files, as ISO/IEC 15948 describes them: 8 bits of three channels.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "core/atomic_file.h"
#include "image/deflate.h"
#include "image/image.h"

namespace glowworm {

namespace {

constexpr std::size_t kBytesPerPixel = 3;
constexpr std::size_t kLongestKeyword = 79;
constexpr std::size_t kLargestChunk = std::size_t{1} << 24;

std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
          static_cast<char>(value)};
}

void write_chunk(AtomicFile& file, const std::string& type, const std::string& content) {
  const std::string checked = type + content;
  const auto check = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size())));
  file.write(big_endian(static_cast<std::uint32_t>(content.size())) + checked + big_endian(check));
}

/// A line of the header; as UTF-8 where it is not plain ASCII.
void write_text(AtomicFile& file, const std::string& key, const std::string& value) {
  const std::string keyword = key.substr(0, kLongestKeyword) + '\0';
  const bool plain = std::all_of(value.begin(), value.end(), [](char c) { return c > 0; });
  if (plain)
    write_chunk(file, "tEXt", keyword + value);
  else
    write_chunk(file, "iTXt", keyword + std::string(4, '\0') + value);
}

/// The predictor of filter type 4 (section 9.4): that of left, above and upper left that is nearest to a + b - c.
int paeth(int left, int above, int corner) {
  const int estimate = left + above - corner;
  const int by_left = std::abs(estimate - left), by_above = std::abs(estimate - above),
            by_corner = std::abs(estimate - corner);
  if (by_left <= by_above && by_left <= by_corner) return left;
  return by_above <= by_corner ? above : corner;
}

/// A row under a filter type, the type in front.
std::vector<std::byte> filtered(const std::vector<std::uint8_t>& row, const std::vector<std::uint8_t>& above,
                                int type) {
  std::vector<std::byte> result(row.size() + 1);
  result[0] = static_cast<std::byte>(type);
  for (std::size_t i = 0; i < row.size(); ++i) {
    const bool first = i < kBytesPerPixel;
    const int a = first ? 0 : row[i - kBytesPerPixel], b = above[i], c = first ? 0 : above[i - kBytesPerPixel];
    const std::array<int, 5> predicted = {0, a, b, (a + b) / 2, paeth(a, b, c)};
    result[i + 1] =
        static_cast<std::byte>(static_cast<std::uint8_t>(row[i] - predicted[static_cast<std::size_t>(type)]));
  }
  return result;
}

/// The sum of what is left of a row as signed numbers: the least compresses best, as a rule (section 12.8).
long weight_of(const std::vector<std::byte>& row) {
  long sum = 0;
  for (const std::byte b : row) sum += std::abs(static_cast<std::int8_t>(b));
  return sum;
}

}  // namespace

void write_png(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  check_not_empty(path, image);
  AtomicFile file(path);
  const std::vector<RGB> pixels = image.rgb();
  const auto width = static_cast<std::size_t>(image.width()), height = static_cast<std::size_t>(image.height());
  std::vector<std::uint8_t> row(width * kBytesPerPixel), above(row.size());
  std::vector<std::byte> rows;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const RGB mapped = tone_map(pixels[y * width + x], curve, exposure);
      for (int c = 0; c < 3; ++c) row[x * kBytesPerPixel + static_cast<std::size_t>(c)] = to_byte(mapped[c]);
    }
    std::vector<std::byte> best = filtered(row, above, 0);
    for (int type = 1; type < 5; ++type) {
      std::vector<std::byte> other = filtered(row, above, type);
      if (weight_of(other) < weight_of(best)) best.swap(other);
    }
    rows.insert(rows.end(), best.begin(), best.end());
    row.swap(above);
  }
  const std::vector<std::byte> packed = deflate_bytes(rows);
  file.write("\x89PNG\r\n\x1a\n");
  write_chunk(file, "IHDR",
              big_endian(static_cast<std::uint32_t>(width)) + big_endian(static_cast<std::uint32_t>(height)) +
                  std::string({8, 2, 0, 0, 0}));
  write_chunk(file, "sRGB", std::string(1, '\0'));
  for (const auto& [key, value] : image.metadata) write_text(file, key, value);
  for (std::size_t i = 0; i < packed.size(); i += kLargestChunk)
    write_chunk(file, "IDAT",
                {reinterpret_cast<const char*>(packed.data() + i), std::min(kLargestChunk, packed.size() - i)});
  write_chunk(file, "IEND", "");
  file.commit();
}

}  // namespace glowworm
