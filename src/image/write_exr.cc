// EXR files by OpenEXR: one part of scan lines, ZIP compression.
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "core/error.h"
#include "image/image.h"

namespace glowworm {

namespace {

constexpr float kLargestHalf = 65504;

/// A file in memory, which AtomicFile then writes, so that every failed write is seen. OpenEXR comes back for the
/// table of line offsets when all lines are there.
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

bool is_half(const ImageChannel& channel, ExrPrecision precision) {
  return precision == ExrPrecision::half && !channel.name.ends_with("depth.Z");
}

std::vector<Imath::half> halves(const std::vector<float>& samples) {
  std::vector<Imath::half> out;
  out.reserve(samples.size());
  for (const float sample : samples) out.emplace_back(std::clamp(sample, -kLargestHalf, kLargestHalf));
  return out;
}

/// A slice of samples that lie row by row; OpenEXR only reads them, though it asks for a pointer to write by.
template <typename Sample>
Imf::Slice slice(Imf::PixelType type, const std::vector<Sample>& samples, int width) {
  return {type, reinterpret_cast<char*>(const_cast<Sample*>(samples.data())), sizeof(Sample),
          sizeof(Sample) * static_cast<std::size_t>(width)};
}

void encode(Encoded& out, const Image& image, ExrPrecision precision) {
  Imf::Header header(image.width(), image.height());
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [key, value] : image.metadata) header.insert(key, Imf::StringAttribute(value));
  Imf::FrameBuffer frame;
  std::vector<std::vector<Imath::half>> rounded;
  rounded.reserve(image.channels().size());
  for (const ImageChannel& channel : image.channels()) {
    const Imf::PixelType type = is_half(channel, precision) ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(channel.name, Imf::Channel(type));
    if (type == Imf::HALF) rounded.push_back(halves(channel.samples));
    frame.insert(channel.name, type == Imf::HALF ? slice(type, rounded.back(), image.width())
                                                 : slice(type, channel.samples, image.width()));
  }
  Imf::OutputFile file(out, header);
  file.setFrameBuffer(frame);
  file.writePixels(image.height());
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
