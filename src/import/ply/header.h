// The header of a PLY file (Turk, "The PLY Polygon File Format", 1994).
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace glowworm {

enum class PlyFormat : std::uint8_t { ascii, binary_little_endian, binary_big_endian };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Size of a binary value, bytes.
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  ///< of a list: the type of its length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  /// Minimum size of an element, bytes. Exact in binary files without lists; in ASCII files, one digit and one blank
  /// per value.
  std::size_t smallest_size(PlyFormat format) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::string texture;         ///< image name from the last comment "TextureFile", or empty
  int textures = 0;            ///< number of these comments
  std::size_t data_begin = 0;  ///< offset of the first byte after the header
};

/// Reads the header, and checks that the file is large enough for the elements it declares.
/// @param file for messages
/// Throws Error with file and line.
PlyHeader read_ply_header(std::string_view bytes, const std::string& file);

}  // namespace glowworm
