#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

#include "core/atomic_file.h"
#include "core/error.h"
#include "image/image.h"
#include "image/image_file.h"

namespace glowworm {

namespace {

constexpr float kLargestHalf = 65504;

// A picture is encoded in memory and written by AtomicFile, so that every failed write is seen: the libraries'
// own streams drop the error of the last buffer.
void encode_and_write(const std::string& path, const char* format, const OIIO::ImageSpec& spec,
                      OIIO::TypeDesc sample_type, const void* samples) {
  configure_openimageio();
  AtomicFile file(path);
  OIIO::Filesystem::IOVecOutput bytes;
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
  if (!output || !output->supports("ioproxy")) {
    throw Error({path}, fmt::format("this OpenImageIO cannot write {} files ({})", format, OIIO::geterror()),
                "Install Debian's libopenimageio2.4.");
  }
  output->set_ioproxy(&bytes);
  if (!output->open(std::string("memory.") + format, spec) || !output->write_image(sample_type, samples) ||
      !output->close()) {
    throw Error({path}, fmt::format("cannot encode the picture ({})", output->geterror()));
  }
  file.write(bytes.buffer().data(), bytes.buffer().size());
  file.commit();
}

void add_metadata(OIIO::ImageSpec& spec, const Image& image) {
  for (const auto& [key, value] : image.metadata) spec.attribute(key, value);
}

void check_not_empty(const std::string& path, const Image& image) {
  if (image.pixel_count() == 0 || image.channels().empty()) {
    throw Error({path}, "the picture to write has no pixels or no channels");
  }
}

bool ends_with_ignoring_case(const std::string& text, std::string_view ending) {
  return text.size() >= ending.size() &&
         std::equal(ending.begin(), ending.end(), text.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

}  // namespace

Image read_image(const std::string& path) {
  const ImageFileData data = read_image_file(path, true);
  const ImageFileHeader& header = data.header;
  Image image(header.width, header.height);
  image.metadata = header.metadata;
  const auto channels = static_cast<std::size_t>(header.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const bool is_alpha = static_cast<int>(c) == header.alpha_channel;
    const std::span<float> plane = image.add_channel(header.channel_names[c]);
    for (std::size_t i = 0; i < plane.size(); ++i) {
      float value;
      std::memcpy(&value, data.samples.data() + (i * channels + c) * sizeof(float), sizeof(float));
      plane[i] = is_alpha ? value : header.transfer.decode(value);
    }
  }
  if (!image.has_channel("R") && (image.has_channel("Y") || channels == 1)) {
    const std::string grey = image.has_channel("Y") ? "Y" : header.channel_names[0];
    const std::vector<float> samples(image.channel(grey).begin(), image.channel(grey).end());
    for (const char* name : {"R", "G", "B"}) image.add_scalar(name, samples);
  }
  return image;
}

void write_exr(const std::string& path, const Image& image, ExrPrecision precision) {
  check_not_empty(path, image);
  const std::vector<ImageChannel>& channels = image.channels();
  OIIO::ImageSpec spec(image.width(), image.height(), static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames.clear();
  std::vector<bool> is_half;
  for (const ImageChannel& channel : channels) {
    is_half.push_back(precision == ExrPrecision::half && !channel.name.ends_with("depth.Z"));
    spec.channelnames.push_back(channel.name);
    spec.channelformats.push_back(is_half.back() ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    if (channel.name == "A") spec.alpha_channel = static_cast<int>(spec.channelnames.size()) - 1;
  }
  if (std::all_of(is_half.begin(), is_half.end(), [](bool half) { return half; })) spec.format = OIIO::TypeDesc::HALF;
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", "Linear");
  add_metadata(spec, image);

  std::vector<float> interleaved(image.pixel_count() * channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      const float value = channels[c].samples[i];
      interleaved[i * channels.size() + c] = is_half[c] ? std::clamp(value, -kLargestHalf, kLargestHalf) : value;
    }
  }
  encode_and_write(path, "exr", spec, OIIO::TypeDesc::FLOAT, interleaved.data());
}

void write_png(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  check_not_empty(path, image);
  const std::vector<RGB> pixels = image.rgb();
  std::vector<std::uint8_t> bytes(pixels.size() * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const RGB mapped = tone_map(pixels[i], curve, exposure);
    for (int c = 0; c < 3; ++c) bytes[i * 3 + static_cast<std::size_t>(c)] = to_byte(mapped[c]);
  }
  OIIO::ImageSpec spec(image.width(), image.height(), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  add_metadata(spec, image);
  encode_and_write(path, "png", spec, OIIO::TypeDesc::UINT8, bytes.data());
}

void write_image(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  if (ends_with_ignoring_case(path, ".exr")) return write_exr(path, image);
  if (ends_with_ignoring_case(path, ".png")) return write_png(path, image, curve, exposure);
  throw Error({path}, "the ending does not say which kind of image file to write",
              "End the path in .exr (linear, all layers) or .png (8 bits, tone mapped).");
}

}  // namespace glowworm
