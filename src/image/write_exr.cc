// Writes EXR files by OpenEXR: one part of scan lines, ZIP compression.
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "core/disk_memory.h"
#include "core/error.h"
#include "image/image.h"

namespace glowworm {

namespace {

/// Rows of a block of ZIP compression, and bytes of samples that are encoded at once, but at least one block.
constexpr int kRowsOfBlock = 16;
constexpr std::size_t kBytesAtOnce = std::size_t{4} << 20;
/// The range of normal numbers of 16 bits.
constexpr float kLeastHalf = 0x1p-14f, kMaxHalf = 65504;

/// A file in memory, which AtomicFile writes afterwards, so that no failed write is missed. OpenEXR seeks back to write
/// the table of line offsets after all lines.
class Encoded : public Imf::OStream {
 public:
  Encoded() : Imf::OStream("memory.exr") {}

  void write(const char* bytes, int count) override {
    const auto n = static_cast<std::size_t>(count);
    if (at_ + n > bytes_.size()) bytes_.resize(at_ + n);
    std::copy_n(bytes, n, bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ += n;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t at) override { at_ = at; }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// Whether a channel needs more than 16 bits: positions and ids.
bool is_exact(const std::string& channel) {
  const std::string layer = channel.substr(0, channel.find('.'));
  static const std::set<std::string, std::less<>> exact = {"depth", "position", "uv", "object-id", "material-id"};
  return channel.ends_with("depth.Z") || exact.contains(layer) || layer.starts_with("Crypto");
}

/// Whether halves keep the precision of samples: the largest is neither above their range nor so small that they lose
/// digits.
bool fits_halves(const std::vector<float>& samples) {
  float most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % (kBytesAtOnce / sizeof(float)) == 0) check_disk_memory();
    if (std::isfinite(samples[i])) most = std::max(most, std::abs(samples[i]));
  }
  return most == 0 || (most >= kLeastHalf && most <= kMaxHalf);
}

std::string layer_name(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  return dot == std::string::npos ? "" : channel.substr(0, dot);
}

/// The layers whose channels are written as halves. Channels of one layer have one type.
std::set<std::string> half_layers(const Image& image, ExrPrecision precision) {
  std::set<std::string> out;
  if (precision != ExrPrecision::half) return out;
  for (const ImageChannel& channel : image.channels()) out.insert(layer_name(channel.name));
  for (const ImageChannel& channel : image.channels())
    if (is_exact(channel.name) || !fits_halves(channel.samples)) out.erase(layer_name(channel.name));
  return out;
}

/// A slice of samples stored row by row. OpenEXR only reads them, although it asks for a non-const pointer.
template <typename Sample>
Imf::Slice slice(Imf::PixelType type, std::span<const Sample> samples, const Imath::Box2i& window) {
  return Imf::Slice::Make(type, samples.data(), window, sizeof(Sample),
                          sizeof(Sample) * static_cast<std::size_t>(window.max.x - window.min.x + 1));
}

void encode(Encoded& out, const Image& image, ExrPrecision precision) {
  const PicturePlace& place = image.place;
  const int x0 = place.x0, y0 = place.y0;
  const Imath::Box2i part({x0, y0}, {x0 + image.width() - 1, y0 + image.height() - 1});
  const bool is_whole = place.whole_width == 0 || place.whole_height == 0;
  Imf::Header header(is_whole ? part : Imath::Box2i({0, 0}, {place.whole_width - 1, place.whole_height - 1}), part);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [key, value] : image.metadata) header.insert(key, Imf::StringAttribute(value));
  for (const auto& [key, m] : image.matrices)
    header.insert(key, Imf::M44fAttribute({m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11],
                                           m[12], m[13], m[14], m[15]}));
  if (image.radiance_scale > 0) Imf::addWhiteLuminance(header, kLuminousEfficacy / image.radiance_scale);
  // The type's default is Rec. 709.
  Imf::addChromaticities(header, Imf::Chromaticities());
  const std::set<std::string> of_halves = half_layers(image, precision);
  for (const ImageChannel& channel : image.channels())
    header.channels().insert(channel.name,
                             Imf::Channel(of_halves.contains(layer_name(channel.name)) ? Imf::HALF : Imf::FLOAT));
  Imf::OutputFile file(out, header);
  // Halves exist for a band of rows at a time, because channels may be hundreds.
  const std::size_t of_block =
      image.channels().size() * static_cast<std::size_t>(image.width()) * kRowsOfBlock * sizeof(float);
  const int rows = kRowsOfBlock * static_cast<int>(std::clamp<std::size_t>(kBytesAtOnce / of_block, 1, 4));
  for (int first = 0; first < image.height(); first += rows) {
    const int last = std::min(first + rows, image.height());
    const Imath::Box2i band({part.min.x, part.min.y + first}, {part.max.x, part.min.y + last - 1});
    const auto row = static_cast<std::size_t>(image.width());
    const std::size_t at = static_cast<std::size_t>(first) * row, count = static_cast<std::size_t>(last - first) * row;
    Imf::FrameBuffer frame;
    std::vector<std::vector<Imath::half>> rounded;
    rounded.reserve(image.channels().size());
    for (const ImageChannel& channel : image.channels()) {
      check_disk_memory();
      const std::span<const float> samples = std::span(channel.samples).subspan(at, count);
      if (of_halves.contains(layer_name(channel.name))) {
        rounded.emplace_back(samples.begin(), samples.end());
        frame.insert(channel.name, slice<Imath::half>(Imf::HALF, rounded.back(), band));
      } else {
        frame.insert(channel.name, slice<float>(Imf::FLOAT, samples, band));
      }
    }
    file.setFrameBuffer(frame);
    file.writePixels(last - first);
  }
}

}  // namespace

void write_exr(const std::string& path, const Image& image, ExrPrecision precision) {
  check_not_empty(path, image);
  AtomicFile file(path);
  Encoded encoded;
  try {
    encode(encoded, image, precision);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Error({path}, fmt::format("cannot encode the picture ({})", error.what()));
  }
  file.write(encoded.bytes());
  file.commit();
}

}  // namespace glowworm
