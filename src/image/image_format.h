// Supported picture formats. OpenImageIO supports more, but their readers crash on damaged files.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace glowworm {

/// A supported format; tests/fuzz fuzzes the reader of each.
struct ImageFormat {
  const char* name;    ///< name for messages: "PNG"
  const char* plugin;  ///< name of the reader, in OpenImageIO; "gif" is read by giflib, null by open_hdr()
  /// Maximum number of pixels per byte of a file; a header that claims more is damaged. 0: unlimited, because the
  /// format can omit whole rows or the rest of the picture. TIFF: see tiff_pixels_per_byte().
  double pixels_per_byte;
  /// Whether the reader decodes row by row. If not, it holds the whole picture in memory.
  bool by_rows;
};

/// The format of a file that begins with `bytes` (kFormatBytes of them, unless the file is shorter); null if it is not
/// supported. TGA has no magic number: it is recognised by the extension of `name` and a plausible header.
const ImageFormat* find_image_format(std::span<const std::uint8_t> bytes, const std::string& name);
inline constexpr std::size_t kFormatBytes = 26;

/// ImageFormat::pixels_per_byte of TIFF files of a compression, by the name that OpenImageIO gives it.
double tiff_pixels_per_byte(std::string_view compression);

/// Whether a TGA file that begins with these bytes has no palette, or a colour for every index.
bool has_whole_palette(std::span<const std::uint8_t> bytes);

/// The name of an unsupported format ("a DDS"), by the first bytes of the file; empty if unknown.
std::string unread_format(std::span<const std::uint8_t> bytes);

/// "PNG, JPEG, ... and GIF".
std::string image_format_names();

}  // namespace glowworm
