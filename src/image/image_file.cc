#include "image/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "image/image_reader.h"
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

namespace {

// No codec of still images packs more than this many bytes into one; a header that claims more is damaged.
constexpr std::uint64_t kLargestCompression = 5000;
// Rows that scan_image_file holds at once of files that are not tiled.
constexpr int kBandRows = 64;

void check_header(const std::string& path, const ImageFileHeader& header, int depth) {
  if (header.width <= 0 || header.height <= 0 || header.channels <= 0 || depth > 1) {
    throw Error({path},
                fmt::format("not a picture: it says {} x {} pixels of {} channels", header.width, header.height,
                            header.channels),
                "Save it again from the program that made it.");
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height) *
                              static_cast<std::uint64_t>(header.channels) * sizeof(float);
  if (bytes > physical_memory_bytes() / 2) {
    throw Error({path},
                fmt::format("{} x {} pixels of {} channels do not fit into memory", header.width, header.height,
                            header.channels),
                "Use a smaller picture.");
  }
  std::error_code unknown_size;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, unknown_size);
  if (!unknown_size && bytes / kLargestCompression > file_bytes) {
    throw Error({path},
                fmt::format("truncated or damaged: {} x {} pixels cannot come out of a file of {} bytes", header.width,
                            header.height, file_bytes),
                "Save or copy the file again.");
  }
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::unique_ptr<ImageReader> open_input(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw Error({path}, "the image file does not exist or cannot be reached",
                "Check the path and its folder's rights.");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw Error({path}, "not a file that holds an image", "Give the path of an image file.");
  }
  std::string failure;
  std::unique_ptr<ImageReader> input = open_image_reader(path, failure);
  if (!input) {
    throw Error({path}, fmt::format("cannot be read as an image ({})", first_line(failure)),
                "Use a whole PNG, JPEG, EXR, HDR, TIFF, TGA, BMP or other image file.");
  }
  check_header(path, input->header(), input->depth());
  return input;
}

// Throws where a reading of pixels was not complete.
void check_report(const std::string& path, ImageReader& input, bool complete) {
  const std::string report = first_line(input.report());
  // Readers of TIFF and JPEG say that they succeeded and yet report what is missing; libjpeg's other reports are of
  // blemishes that any viewer passes over.
  const bool blemish = complete && input.is_jpeg() && report.find("Premature end") == std::string::npos;
  if (!complete || (!report.empty() && !blemish)) {
    throw Error({path}, fmt::format("truncated or damaged ({})", report), "Save or copy the file again.");
  }
  if (!report.empty()) warn(fmt::format("{}: {}", path, report));
}

}  // namespace

ImageFileHeader read_image_header(const std::string& path) { return open_input(path)->header(); }

ImageFileData read_image_file(const std::string& path, bool convert_to_single) {
  const std::unique_ptr<ImageReader> input = open_input(path);
  ImageFileData data;
  data.header = input->header();
  if (convert_to_single) data.header.type = SampleType::single;
  const ImageFileHeader& header = data.header;
  data.samples.resize(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) *
                      static_cast<std::size_t>(header.channels) * size_of(header.type));
  check_report(path, *input, input->read_rows(0, header.height, header.type, data.samples.data()));
  return data;
}

ImageFileHeader scan_image_file(
    const std::string& path, const std::function<void(const ImageFileHeader&, const std::vector<std::byte>&)>& band) {
  const std::unique_ptr<ImageReader> input = open_input(path);
  const ImageFileHeader header = input->header();
  const int rows = input->tile_height() > 0 ? input->tile_height() : kBandRows;
  for (int first = 0; first < header.height; first += rows) {
    const int last = std::min(first + rows, header.height);
    std::vector<std::byte> samples(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(last - first) *
                                   static_cast<std::size_t>(header.channels) * size_of(header.type));
    check_report(path, *input, input->read_rows(first, last, header.type, samples.data()));
    band(header, samples);
  }
  return header;
}

}  // namespace glowworm
