// EXR files, as the document "OpenEXR File Layout" (openexr.com) describes them: one part of scan lines, ZIP
// compression.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/parallel.h"
#include "image/deflate.h"
#include "image/half.h"
#include "image/image.h"

namespace glowworm {

namespace {

static_assert(std::endian::native == std::endian::little, "EXR files are little-endian");

constexpr float kLargestHalf = 65504;
constexpr std::int32_t kHalf = 1, kFloat = 2;  // pixel types
constexpr std::uint8_t kZip = 3;               // compression
constexpr std::size_t kRowsOfChunk = 16;       // that ZIP compresses together
constexpr std::size_t kLongestShortName = 31;  // longer names need a flag in the version
constexpr std::uint32_t kMagic = 20000630, kVersion = 2, kLongNames = 0x400;

/// A channel as the file has it.
struct FileChannel {
  const ImageChannel* channel;
  bool is_half;
  std::size_t sample_bytes() const { return is_half ? 2 : 4; }
};

class Bytes {
 public:
  template <typename T>
  void add(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add_name(const std::string& name) { text_.append(name.c_str(), name.size() + 1); }
  template <typename... Values>
  void attribute(const std::string& name, const char* type, Values... values) {
    add_name(name);
    add_name(type);
    add(static_cast<std::int32_t>((sizeof(values) + ...)));
    (add(values), ...);
  }
  void attribute(const std::string& name, const char* type, const std::string& value) {
    add_name(name);
    add_name(type);
    add(static_cast<std::int32_t>(value.size()));
    text_ += value;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Channels in the order of the file, which is that of their names.
std::vector<FileChannel> file_channels(const Image& image, ExrPrecision precision) {
  std::vector<FileChannel> channels;
  for (const ImageChannel& channel : image.channels())
    channels.push_back({&channel, precision == ExrPrecision::half && !channel.name.ends_with("depth.Z")});
  std::sort(channels.begin(), channels.end(),
            [](const FileChannel& a, const FileChannel& b) { return a.channel->name < b.channel->name; });
  return channels;
}

std::string exr_header(const Image& image, const std::vector<FileChannel>& channels) {
  Bytes list;
  bool long_names = false;
  for (const FileChannel& c : channels) {
    long_names = long_names || c.channel->name.size() > kLongestShortName;
    list.add_name(c.channel->name);
    list.add(c.is_half ? kHalf : kFloat);
    list.add(std::uint32_t{0});  // whether perceptually linear, and three bytes kept for later
    list.add(std::int32_t{1});   // sampling
    list.add(std::int32_t{1});
  }
  list.add('\0');
  for (const auto& [key, value] : image.metadata) long_names = long_names || key.size() > kLongestShortName;
  const std::int32_t right = image.width() - 1, bottom = image.height() - 1;
  Bytes header;
  header.add(kMagic);
  header.add(kVersion | (long_names ? kLongNames : 0));
  header.attribute("channels", "chlist", list.text());
  header.attribute("compression", "compression", kZip);
  header.attribute("dataWindow", "box2i", 0, 0, right, bottom);
  header.attribute("displayWindow", "box2i", 0, 0, right, bottom);
  header.attribute("lineOrder", "lineOrder", std::uint8_t{0});
  header.attribute("pixelAspectRatio", "float", 1.0f);
  header.attribute("screenWindowCenter", "v2f", 0.0f, 0.0f);
  header.attribute("screenWindowWidth", "float", 1.0f);
  for (const auto& [key, value] : image.metadata) header.attribute(key, "string", value);
  header.add('\0');
  return header.text();
}

/// The samples of rows [first, last): row by row, in each channel by channel.
std::vector<std::byte> samples_of_rows(const std::vector<FileChannel>& channels, std::size_t width, std::size_t first,
                                       std::size_t last) {
  std::size_t bytes = 0;
  for (const FileChannel& c : channels) bytes += c.sample_bytes() * width * (last - first);
  std::vector<std::byte> samples(bytes);
  std::byte* to = samples.data();
  for (std::size_t row = first; row < last; ++row) {
    for (const FileChannel& c : channels) {
      const float* from = c.channel->samples.data() + row * width;
      if (!c.is_half) std::memcpy(to, from, width * sizeof(float));
      for (std::size_t x = 0; x < width && c.is_half; ++x) {
        const std::uint16_t half = float_to_half(std::clamp(from[x], -kLargestHalf, kLargestHalf));
        std::memcpy(to + 2 * x, &half, sizeof half);
      }
      to += width * c.sample_bytes();
    }
  }
  return samples;
}

/// Compresses as OpenEXR's ZIP does: even bytes before odd ones, differences, zlib. As they are where that saves
/// nothing.
std::vector<std::byte> zip(const std::vector<std::byte>& samples) {
  const std::size_t half = (samples.size() + 1) / 2;
  std::vector<std::byte> apart(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) apart[(i & 1 ? half : 0) + i / 2] = samples[i];
  auto before = std::to_integer<std::uint8_t>(apart[0]);
  for (std::size_t i = 1; i < apart.size(); ++i) {
    const auto value = std::to_integer<std::uint8_t>(apart[i]);
    apart[i] = static_cast<std::byte>(static_cast<std::uint8_t>(value - before + 128));
    before = value;
  }
  std::vector<std::byte> packed = deflate_bytes(apart);
  return packed.size() < samples.size() ? packed : samples;
}

}  // namespace

void write_exr(const std::string& path, const Image& image, ExrPrecision precision) {
  check_not_empty(path, image);
  AtomicFile file(path);
  const std::vector<FileChannel> channels = file_channels(image, precision);
  const auto width = static_cast<std::size_t>(image.width()), height = static_cast<std::size_t>(image.height());
  std::vector<std::vector<std::byte>> chunks((height + kRowsOfChunk - 1) / kRowsOfChunk);
  parallel_for(0, chunks.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      chunks[i] = zip(samples_of_rows(channels, width, i * kRowsOfChunk, std::min((i + 1) * kRowsOfChunk, height)));
  });
  Bytes start;
  const std::string header = exr_header(image, channels);
  std::uint64_t offset = header.size() + chunks.size() * sizeof(std::uint64_t);
  for (const std::vector<std::byte>& chunk : chunks) {
    start.add(offset);
    offset += 2 * sizeof(std::int32_t) + chunk.size();
  }
  file.write(header);
  file.write(start.text());
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    Bytes head;
    head.add(static_cast<std::int32_t>(i * kRowsOfChunk));
    head.add(static_cast<std::int32_t>(chunks[i].size()));
    file.write(head.text());
    file.write(chunks[i].data(), chunks[i].size());
  }
  file.commit();
}

}  // namespace glowworm
