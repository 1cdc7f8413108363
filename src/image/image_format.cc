#include "image/image_format.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/text.h"

namespace glowworm {

namespace {

// Deflate expands a byte to at most 1032 bytes (258 bytes from two bits), or 8 one-bit pixels per byte. In JPEG, a
// block of 8 x 8 pixels takes at least one bit. EXR's DWAA deflates runs of 128 bytes to two, with two-byte pixels. In
// HDR, a run of 127 pixels takes 2 bytes for each of four channels; in TGA, one of 128 pixels takes 2 bytes, in BMP one
// of 255, and pixels that it skips cost nothing, so it has twice that. In GIF, a code of 12 bits stands for at most
// 4096 pixels. WebP has no limit, but no side beyond 16383 pixels.
constexpr double kDeflatePixels = 8 * 1032, kJpegPixels = 512;
constexpr std::array kFormats = {
    ImageFormat{"PNG", "png", kDeflatePixels, true},
    ImageFormat{"JPEG", "jpeg", kJpegPixels, true},
    ImageFormat{"EXR", "openexr", 64 * 1032 / 2, true},
    ImageFormat{"HDR", nullptr, 16, true},
    ImageFormat{"TIFF", "tiff", 0, true},
    ImageFormat{"TGA", "targa", 64, false},
    ImageFormat{"BMP", "bmp", 256, false},
    ImageFormat{"WebP", "webp", 0, false},
    ImageFormat{"GIF", "gif", 4096 / 1.5, false},
};

const ImageFormat* by_name(std::string_view name) {
  return std::find_if(kFormats.begin(), kFormats.end(), [&](const ImageFormat& f) { return f.name == name; });
}

// The first bytes of a file.
struct Mark {
  std::string_view bytes;
  const char* format;
};
constexpr Mark kMarks[] = {
    {"\x89PNG\r\n\x1a\n", "PNG"},
    {"\xff\xd8\xff", "JPEG"},
    {"\x76\x2f\x31\x01", "EXR"},
    {"#?", "HDR"},
    {{"II*\0", 4}, "TIFF"},
    {{"MM\0*", 4}, "TIFF"},
    {{"II+\0", 4}, "TIFF"},
    {{"MM\0+", 4}, "TIFF"},
    {"BM", "BMP"},
    {"GIF87a", "GIF"},
    {"GIF89a", "GIF"},
};

// Unsupported formats, for messages.
constexpr Mark kUnreadMarks[] = {
    {"DDS ", "a DDS"},
    {"8BPS", "a Photoshop"},
    {"FOR4", "an IFF"},
    {"FORM", "an IFF"},
    {"SDPX", "a DPX"},
    {"XPDS", "a DPX"},
    {"P1", "a PBM"},
    {"P2", "a PGM"},
    {"P3", "a PPM"},
    {"P4", "a PBM"},
    {"P5", "a PGM"},
    {"P6", "a PPM"},
    {"PF", "a PFM"},
    {"Pf", "a PFM"},
    {"\xabKTX", "a KTX"},
    {"qoif", "a QOI"},
    {"\xff\x0a", "a JPEG XL"},
    {{"\0\0\1\0", 4}, "an ICO"},
    {{"\0\0\0\x0cjP  ", 8}, "a JPEG 2000"},
};

bool is_tga(std::string_view bytes, const std::string& name) {
  const std::string ending = lower_ending(name);
  if (ending != ".tga" && ending != ".tpic") return false;
  constexpr std::size_t kHeaderBytes = 18;
  if (bytes.size() < kHeaderBytes) return false;
  const int map_type = bytes[1], image_type = bytes[2];
  return map_type <= 1 && (image_type & ~8) >= 1 && (image_type & ~8) <= 3;
}

}  // namespace

const ImageFormat* find_image_format(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Mark& mark : kMarks) {
    if (text.starts_with(mark.bytes)) return by_name(mark.format);
  }
  if (text.starts_with("RIFF") && text.size() >= 12 && text.substr(8, 4) == "WEBP") return by_name("WebP");
  return is_tga(text, name) ? by_name("TGA") : nullptr;
}

bool has_whole_palette(std::span<const std::uint8_t> bytes) {
  const bool has_palette = (bytes[2] & ~8) == 1;
  const unsigned first = bytes[3] | bytes[4] << 8, length = bytes[5] | bytes[6] << 8, index_bits = bytes[16];
  return !has_palette || (bytes[1] == 1 && first == 0 && index_bits <= 16 && length >= 1u << index_bits);
}

double tiff_pixels_per_byte(std::string_view compression) {
  // A pixel takes at least a bit. In PackBits, a run of 128 bytes takes 2; in LZW, a code of 12 bits stands for at most
  // 4096 bytes.
  constexpr std::pair<std::string_view, double> kLimits[] = {
      {"none", 8},           {"packbits", 8 * 64},  {"lzw", 8 * 4096 / 1.5}, {"zip", kDeflatePixels},
      {"jpeg", kJpegPixels}, {"ojpeg", kJpegPixels}};
  for (const auto& [name, pixels] : kLimits) {
    if (name == compression) return pixels;
  }
  return 0;
}

std::string unread_format(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Mark& mark : kUnreadMarks) {
    if (text.starts_with(mark.bytes)) return mark.format;
  }
  return text.size() >= 12 && text.substr(4, 4) == "ftyp" ? "a HEIF" : "";
}

std::string image_format_names() {
  std::string names;
  for (std::size_t i = 0; i < kFormats.size(); ++i) {
    names += i == 0 ? "" : i + 1 < kFormats.size() ? ", " : " and ";
    names += kFormats[i].name;
  }
  return names;
}

}  // namespace glowworm
