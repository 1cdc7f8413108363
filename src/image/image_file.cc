#include "image/image_file.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>

#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "image/tone_map.h"

namespace glowworm {

float TransferFunction::decode(float encoded) const {
  switch (kind) {
    case Kind::srgb:
      return srgb_decode(encoded);
    case Kind::power:
      return std::copysign(std::pow(std::abs(encoded), exponent), encoded);
    case Kind::linear:
      break;
  }
  return encoded;
}

std::size_t size_of(SampleType type) {
  switch (type) {
    case SampleType::uint8:
      return 1;
    case SampleType::uint16:
    case SampleType::half:
      return 2;
    case SampleType::single:
      break;
  }
  return 4;
}

void configure_openimageio() {
  static std::once_flag once;
  std::call_once(once, [] {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
  });
}

namespace {

// No codec of still images packs more than this many bytes into one; a header that claims more is damaged.
constexpr std::uint64_t kLargestCompression = 5000;
// Rows that scan_image_file holds at once of files that are not tiled.
constexpr int kBandRows = 64;

SampleType sample_type(const OIIO::ImageSpec& spec) {
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      return SampleType::uint8;
    case OIIO::TypeDesc::UINT16:
      return SampleType::uint16;
    case OIIO::TypeDesc::HALF:
      return SampleType::half;
    default:
      return SampleType::single;
  }
}

OIIO::TypeDesc type_desc(SampleType type) {
  switch (type) {
    case SampleType::uint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::uint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::half:
      return OIIO::TypeDesc::HALF;
    case SampleType::single:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

TransferFunction transfer_function(const OIIO::ImageSpec& spec) {
  using Kind = TransferFunction::Kind;
  const std::string space = spec.get_string_attribute("oiio:ColorSpace");
  const float gamma = spec.get_float_attribute("oiio:Gamma", 1.0f);
  if (space.starts_with("Gamma") || space.starts_with("gamma")) {
    return gamma > 0 && gamma != 1 ? TransferFunction{Kind::power, gamma} : TransferFunction{};
  }
  if (space == "sRGB") return {Kind::srgb, 1};
  if (space.empty() && !spec.format.is_floating_point()) return {Kind::srgb, 1};
  return {};
}

ImageFileHeader header_of(const OIIO::ImageSpec& spec) {
  ImageFileHeader header;
  header.width = spec.width;
  header.height = spec.height;
  header.channels = spec.nchannels;
  header.alpha_channel = spec.alpha_channel;
  header.type = sample_type(spec);
  header.transfer = transfer_function(spec);
  header.channel_names = spec.channelnames;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING) header.metadata[attribute.name().string()] = attribute.get_string();
  }
  return header;
}

void check_header(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1) {
    throw Error(
        {path},
        fmt::format("not a picture: it says {} x {} pixels of {} channels", spec.width, spec.height, spec.nchannels),
        "Save it again from the program that made it.");
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height) *
                              static_cast<std::uint64_t>(spec.nchannels) * sizeof(float);
  if (bytes > physical_memory_bytes() / 2) {
    throw Error(
        {path},
        fmt::format("{} x {} pixels of {} channels do not fit into memory", spec.width, spec.height, spec.nchannels),
        "Use a smaller picture.");
  }
  std::error_code unknown_size;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, unknown_size);
  if (!unknown_size && bytes / kLargestCompression > file_bytes) {
    throw Error({path},
                fmt::format("truncated or damaged: {} x {} pixels cannot come out of a file of {} bytes", spec.width,
                            spec.height, file_bytes),
                "Save or copy the file again.");
  }
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::unique_ptr<OIIO::ImageInput> open_input(const std::string& path) {
  configure_openimageio();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw Error({path}, "the image file does not exist or cannot be reached",
                "Check the path and its folder's rights.");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw Error({path}, "not a file that holds an image", "Give the path of an image file.");
  }
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    throw Error({path}, fmt::format("cannot be read as an image ({})", first_line(OIIO::geterror())),
                "Use a whole PNG, JPEG, EXR, HDR, TIFF, TGA, BMP or other image file.");
  }
  check_header(path, input->spec());
  return input;
}

// Throws where a reading of pixels was not complete.
void check_report(const std::string& path, OIIO::ImageInput& input, bool complete) {
  const std::string report = first_line(input.geterror());
  // Readers of TIFF and JPEG say that they succeeded and yet report what is missing; libjpeg's other reports are of
  // blemishes that any viewer passes over.
  const bool blemish =
      complete && std::string_view(input.format_name()) == "jpeg" && report.find("Premature end") == std::string::npos;
  if (!complete || (!report.empty() && !blemish)) {
    throw Error({path}, fmt::format("truncated or damaged ({})", report), "Save or copy the file again.");
  }
  if (!report.empty()) warn(fmt::format("{}: {}", path, report));
}

}  // namespace

ImageFileHeader read_image_header(const std::string& path) { return header_of(open_input(path)->spec()); }

ImageFileData read_image_file(const std::string& path, bool convert_to_single) {
  const std::unique_ptr<OIIO::ImageInput> input = open_input(path);
  ImageFileData data;
  data.header = header_of(input->spec());
  if (convert_to_single) data.header.type = SampleType::single;
  const ImageFileHeader& header = data.header;
  data.samples.resize(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) *
                      static_cast<std::size_t>(header.channels) * size_of(header.type));
  const bool complete = input->read_image(0, 0, 0, header.channels, type_desc(header.type), data.samples.data());
  check_report(path, *input, complete);
  return data;
}

ImageFileHeader scan_image_file(
    const std::string& path, const std::function<void(const ImageFileHeader&, const std::vector<std::byte>&)>& band) {
  const std::unique_ptr<OIIO::ImageInput> input = open_input(path);
  const OIIO::ImageSpec& spec = input->spec();
  const ImageFileHeader header = header_of(spec);
  const int rows = spec.tile_height > 0 ? spec.tile_height : kBandRows;
  const OIIO::TypeDesc type = type_desc(header.type);
  bool complete = true;
  for (int row = 0; row < header.height && complete; row += rows) {
    const int first = spec.y + row, last = spec.y + std::min(row + rows, header.height);
    std::vector<std::byte> samples(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(last - first) *
                                   static_cast<std::size_t>(header.channels) * size_of(header.type));
    complete = spec.tile_width > 0
                   ? input->read_tiles(0, 0, spec.x, spec.x + spec.width, first, last, spec.z, spec.z + 1, 0,
                                       header.channels, type, samples.data())
                   : input->read_scanlines(0, 0, first, last, 0, 0, header.channels, type, samples.data());
    check_report(path, *input, complete);
    band(header, samples);
  }
  return header;
}

}  // namespace glowworm
