// The formats of pictures that are read. OpenImageIO knows more of them, whose readers crash on damaged files.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace glowworm {

/// A format that is read; tests/fuzz fuzzes the reader of each.
struct ImageFormat {
  const char* name;    ///< for people: "PNG"
  const char* plugin;  ///< OpenImageIO's name of its reader
  /// Pixels that one byte of a file can stand for at most; a header that claims more is damaged. 0: unlimited, since
  /// the format can leave out whole rows or skip to its end.
  double pixels_per_byte;
  /// Whether the reader decodes row by row; else it holds the whole picture.
  bool by_rows;
};

/// The format of a file that begins with `bytes` (kFormatBytes of them, if the file has so many); null where it is none
/// that is read. TGA has no mark of its own and is known by the ending of `name` and a header that makes sense.
const ImageFormat* find_image_format(std::span<const std::uint8_t> bytes, const std::string& name);
inline constexpr std::size_t kFormatBytes = 18;

/// The name of a format that is not read ("a DDS"), by what such files begin with; empty where it is not known.
std::string unread_format(std::span<const std::uint8_t> bytes);

/// "PNG, JPEG, ... and GIF".
std::string image_format_names();

}  // namespace glowworm
