// Reads image files as plain data.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"

namespace glowworm {

/// Thrown if no image file can be read because glowworm-reader or one of its libraries is missing.
class MissingReader : public Error {
 public:
  using Error::Error;
};

/// Conversion of a file's numbers to linear ones.
struct TransferFunction {
  enum class Kind : std::uint8_t { linear, srgb, power };
  Kind kind = Kind::linear;
  float exponent = 1;  ///< power: linear = encoded^exponent

  float decode(float encoded) const;
};

/// The text up to its first line break, for messages of libraries.
std::string first_line(const std::string& text);

/// The type of a sample in memory.
enum class SampleType : std::uint8_t { uint8, uint16, half, single };
std::size_t size_of(SampleType type);

/// The header of an image file.
struct ImageFileHeader {
  int width = 0, height = 0;
  int x0 = 0, y0 = 0, whole_width = 0, whole_height = 0;  ///< position in a larger picture (Image::place)
  int channels = 0;
  int alpha_channel = -1;  ///< -1: none
  SampleType type = SampleType::single;
  TransferFunction transfer;     ///< of the colour channels; alpha is always linear
  bool other_primaries = false;  ///< the file says that its primaries are not Rec. 709's
  std::vector<std::string> channel_names;
  int rows_at_once = 0;                         ///< number of rows held and decoded at once when reading by bands
  std::map<std::string, std::string> metadata;  ///< text attributes

  /// Size of a number of rows as stored, bytes.
  std::uint64_t bytes_of_rows(int rows) const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(channels) *
           size_of(type);
  }
};

/// Pixels as stored: channels interleaved, row-major, first row on top. Alpha is not multiplied into colour if the
/// format separates them.
struct ImageFileData {
  ImageFileHeader header;
  std::vector<std::byte> samples;
};

/// Reads the header of the first picture of a file; throws Error as scan_image_file() does.
ImageFileHeader read_image_header(const std::string& path);

/// Reads the first picture of a file by bands of rows, so that little of it is in memory at once. Calls `band` with the
/// samples of each band from the top down, which it may keep.
/// @param convert_to_single always gives 32-bit floats (integers become 0…1); otherwise the smallest SampleType that
/// represents the file's numbers is used (32-bit integers and doubles become single)
/// Throws Error with a remedy if the file is missing, of an unsupported format (image/image_format.h), truncated,
/// empty, or larger than half of the machine's memory.
ImageFileHeader scan_image_file(const std::string& path, bool convert_to_single,
                                const std::function<void(const ImageFileHeader&, std::vector<std::byte>)>& band);

/// The whole first picture of a file, as stored. Throws Error as scan_image_file() does.
ImageFileData read_image_file(const std::string& path);

}  // namespace glowworm
