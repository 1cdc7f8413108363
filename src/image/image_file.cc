#include "image/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <utility>

#include "core/input_file.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "image/hdr_reader.h"
#include "image/image_format.h"
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

// Rows that scan_image_file() holds at a time for files without tiles: these, or the multiple that fills kBandBytes, as
// OpenImageIO allocates 16 MB for each call. Blocks of EXR files have 1, 16, 32 or 256 rows, and are decoded twice
// where bands cut them.
constexpr int kBandRows = 64;
constexpr std::uint64_t kBandBytes = std::uint64_t{1} << 20;
// No format and no renderer needs more; products of several such numbers stay far below 2^64.
constexpr int kMaxSide = 1 << 20, kMaxChannels = 1024;

void check_expansion(const std::string& path, double pixels_per_byte, std::int64_t width, std::int64_t height) {
  std::error_code unknown_size;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, unknown_size);
  const double most = pixels_per_byte * static_cast<double>(file_bytes);
  if (!unknown_size && most > 0 && static_cast<double>(width) * static_cast<double>(height) > most) {
    throw Error({path},
                fmt::format("truncated or damaged: {} x {} pixels cannot come out of a file of {} bytes", width, height,
                            file_bytes),
                "Save or copy the file again.");
  }
}

void check_header(const std::string& path, const ImageFormat& format, const ImageFileHeader& header, int depth) {
  const auto within = [](int value, int largest) { return value > 0 && value <= largest; };
  if (!within(header.width, kMaxSide) || !within(header.height, kMaxSide) || !within(header.channels, kMaxChannels) ||
      depth > 1) {
    throw Error({path},
                fmt::format("not a picture: it says {} x {} pixels of {} channels", header.width, header.height,
                            header.channels),
                "Save it again from the program that made it.");
  }
  const auto compression = header.metadata.find("compression");
  const double pixels_per_byte = format.name == std::string_view("TIFF") && compression != header.metadata.end()
                                     ? tiff_pixels_per_byte(compression->second)
                                     : format.pixels_per_byte;
  check_expansion(path, pixels_per_byte, header.width, header.height);
  const std::uint64_t pixels = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height);
  if (pixels * static_cast<std::uint64_t>(header.channels) * sizeof(float) > physical_memory_bytes() / 2) {
    throw Error({path},
                fmt::format("{} x {} pixels of {} channels do not fit into memory", header.width, header.height,
                            header.channels),
                "Use a smaller picture.", ErrorCode::memory);
  }
}

/// An open image file.
struct Input {
  const ImageFormat* format;
  std::unique_ptr<ImageReader> reader;
  ImageFileHeader header;
};

const ImageFormat& format_of(const std::string& path) {
  std::array<std::uint8_t, kFormatBytes> bytes{};
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error({path}, "cannot be opened", "Check that you may read it.");
  in.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  const std::span<const std::uint8_t> begin = std::span(bytes).first(static_cast<std::size_t>(in.gcount()));
  if (const ImageFormat* format = find_image_format(begin, path)) {
    // OpenImageIO does not check indices into the palette.
    if (format->name == std::string_view("TGA") && !has_whole_palette(begin))
      throw Error({path}, "is a TGA file whose palette has fewer colours than its pixels may name",
                  "Save it without a palette, or as PNG.");
    return *format;
  }
  const std::string other = unread_format(begin);
  throw Error({path},
              other.empty() ? "is not a picture of a format that is read"
                            : fmt::format("is {} picture, a format that is not read", other),
              fmt::format("Convert it: {} are read.", image_format_names()));
}

Input open_input(const std::string& path) {
  check_input_file(path);
  Input input{&format_of(path), nullptr, {}};
  std::string failure;
  input.reader = input.format->plugin ? open_image_reader(path, *input.format, failure) : open_hdr(path, failure);
  if (!input.reader) {
    throw Error({path}, fmt::format("cannot be read as {} ({})", input.format->name, first_line(failure)),
                fmt::format("Use a whole file of one of these formats: {}.", image_format_names()));
  }
  input.header = input.reader->header();
  check_header(path, *input.format, input.header, input.reader->depth());
  ImageFileHeader& header = input.header;
  const int tile = input.reader->tile_height();
  const int band = kBandRows * std::max(1, static_cast<int>(kBandBytes / header.bytes_of_rows(kBandRows)));
  const bool by_rows = input.format->by_rows && !input.reader->unpacks_whole();
  header.rows_at_once = std::min(!by_rows ? header.height : tile > 0 ? tile : band, header.height);
  return input;
}

// Throws if a read of pixels was incomplete.
void check_report(const std::string& path, const Input& input, bool complete) {
  const std::string report = first_line(input.reader->report());
  // TIFF and JPEG readers report success even if data is missing. libjpeg's other messages are about flaws that every
  // viewer ignores.
  const bool blemish =
      complete && input.format->name == std::string_view("JPEG") && report.find("Premature end") == std::string::npos;
  if (!complete || (!report.empty() && !blemish)) {
    throw Error({path}, fmt::format("truncated or damaged ({})", report), "Save or copy the file again.");
  }
  if (!report.empty()) warn(fmt::format("{}: {}", path, report));
}

}  // namespace

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

ImageFileHeader read_image_header(const std::string& path) { return open_input(path).header; }

ImageFileHeader scan_image_file(const std::string& path, bool convert_to_single,
                                const std::function<void(const ImageFileHeader&, std::vector<std::byte>)>& band) {
  const Input input = open_input(path);
  ImageFileHeader header = input.header;
  if (convert_to_single) header.type = SampleType::single;
  if (header.other_primaries)
    warn(fmt::format("{}: its primaries differ from Rec. 709, but its numbers are read as Rec. 709", path));
  for (int first = 0; first < header.height; first += header.rows_at_once) {
    const int last = std::min(first + header.rows_at_once, header.height);
    std::vector<std::byte> samples(header.bytes_of_rows(last - first));
    check_report(path, input, input.reader->read_rows(first, last, header.type, samples.data()));
    band(header, std::move(samples));
  }
  return header;
}

ImageFileData read_image_file(const std::string& path) {
  ImageFileData data;
  data.header = scan_image_file(path, false, [&](const ImageFileHeader& header, std::vector<std::byte> samples) {
    const std::uint64_t bytes = header.bytes_of_rows(header.height);
    if (samples.size() == bytes) {
      data.samples = std::move(samples);
      return;
    }
    data.samples.reserve(bytes);
    data.samples.insert(data.samples.end(), samples.begin(), samples.end());
  });
  return data;
}

}  // namespace glowworm
