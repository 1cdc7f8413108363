// Supported picture formats. OpenImageIO supports more, but their readers crash on damaged files.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace glowworm {

/// A supported format; tests/fuzz fuzzes the reader of each.
struct ImageFormat {
  const char* name;    ///< for messages: "PNG"
  const char* plugin;  ///< OpenImageIO's name of its reader
  /// Pixels that one byte of a file can stand for at most; a header that claims more is damaged. 0: unlimited, since
  /// the format can leave out whole rows or skip to its end.
  double pixels_per_byte;
  /// Whether the reader decodes row by row; else it holds the whole picture.
  bool by_rows;
};

/// The format of a file that begins with `bytes` (kFormatBytes of them, unless the file is shorter); null if it is not
/// supported. TGA has no magic number: it is recognised by the extension of `name` and a plausible header.
const ImageFormat* find_image_format(std::span<const std::uint8_t> bytes, const std::string& name);
inline constexpr std::size_t kFormatBytes = 18;

/// The name of an unsupported format ("a DDS"), by the first bytes of the file; empty if unknown.
std::string unread_format(std::span<const std::uint8_t> bytes);

/// "PNG, JPEG, ... and GIF".
std::string image_format_names();

}  // namespace glowworm
