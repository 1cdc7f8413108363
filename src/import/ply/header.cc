#include "import/ply/header.h"

#include <fmt/format.h>

#include <charconv>

#include "core/error.h"
#include "core/lines.h"

namespace glowworm {

namespace {

constexpr std::size_t kMaxHeaderLines = 10000;
constexpr const char* kDamaged = "The file may be damaged or of another format.";

struct NamedType {
  std::string_view name, other_name;
  PlyType type;
  std::size_t size;
};
constexpr NamedType kTypes[] = {
    {"char", "int8", PlyType::int8, 1},        {"uchar", "uint8", PlyType::uint8, 1},
    {"short", "int16", PlyType::int16, 2},     {"ushort", "uint16", PlyType::uint16, 2},
    {"int", "int32", PlyType::int32, 4},       {"uint", "uint32", PlyType::uint32, 4},
    {"float", "float32", PlyType::float32, 4}, {"double", "float64", PlyType::float64, 8},
};

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& file)
      : bytes_(bytes), file_(file), at_(bytes.size() - without_byte_order_mark(bytes).size()) {
    // All lines end as the first one does: binary data may begin with a line feed.
    const std::size_t end = bytes.find_first_of("\r\n");
    if (end != std::string_view::npos && bytes.substr(end, 2) != "\r\n") line_end_ = bytes[end];
  }

  PlyHeader read() {
    PlyHeader header;
    if (trimmed(next_line()) != "ply") fail("is not a PLY file: its first line is not 'ply'", kDamaged);
    bool has_format = false;
    for (;;) {
      std::string_view line = next_line();
      const std::string_view keyword = take_word(line);
      if (keyword == "end_header") break;
      if (keyword == "comment" && take_word(line) == "TextureFile") {
        header.texture = trimmed(line);
        ++header.textures;
      }
      if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "format") {
        header.format = format(take_word(line));
        has_format = true;
      } else if (keyword == "element") {
        header.elements.push_back(element(line));
      } else if (keyword == "property") {
        if (header.elements.empty()) fail("a property comes before any element", kDamaged);
        header.elements.back().properties.push_back(property(line));
      } else {
        fail("unknown word in the header", "Expected format, comment, element, property or end_header.");
      }
    }
    if (!has_format) fail("the header has no format line", kDamaged);
    header.data_begin = at_;
    check_size(header);
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& message, const std::string& remedy) const {
    throw Error({file_, line_, 0}, message, remedy);
  }

  std::string_view next_line() {
    ++line_;
    const std::size_t end = bytes_.find(line_end_, at_);
    if (end == std::string_view::npos || static_cast<std::size_t>(line_) > kMaxHeaderLines) {
      fail("the PLY header has no end", kDamaged);
    }
    const std::string_view line = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }

  PlyFormat format(std::string_view name) const {
    if (name == "ascii") return PlyFormat::ascii;
    if (name == "binary_little_endian") return PlyFormat::binary_little_endian;
    if (name == "binary_big_endian") return PlyFormat::binary_big_endian;
    fail("unknown PLY format", "Expected ascii, binary_little_endian or binary_big_endian.");
  }

  PlyElement element(std::string_view line) const {
    PlyElement out;
    out.name = take_word(line);
    const std::string_view count = take_word(line);
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), out.count);
    if (out.name.empty() || error != std::errc() || end != count.data() + count.size()) {
      fail("malformed element line", "Expected: element NAME COUNT.");
    }
    return out;
  }

  PlyType type(std::string_view name) const {
    for (const NamedType& entry : kTypes) {
      if (entry.name == name || entry.other_name == name) return entry.type;
    }
    fail("unknown property type", "Expected char, uchar, short, ushort, int, uint, float or double.");
  }

  PlyProperty property(std::string_view line) const {
    PlyProperty out;
    std::string_view word = take_word(line);
    if (word == "list") {
      out.is_list = true;
      out.count_type = type(take_word(line));
      if (out.count_type == PlyType::float32 || out.count_type == PlyType::float64) {
        fail("the length of a list must be an integer", kDamaged);
      }
      word = take_word(line);
    }
    out.type = type(word);
    out.name = take_word(line);
    if (out.name.empty()) fail("a property without a name", "Expected: property TYPE NAME.");
    return out;
  }

  void check_size(const PlyHeader& header) const {
    std::uint64_t left = bytes_.size() - header.data_begin;
    if (header.format == PlyFormat::ascii) ++left;  // the last value needs no blank after it
    for (const PlyElement& element : header.elements) {
      const std::uint64_t each = element.smallest_size(header.format);
      if (each == 0) continue;
      if (element.count > left / each) {
        throw Error({file_},
                    fmt::format("the header promises {} elements '{}', but the file ends before them", element.count,
                                std::string_view(element.name).substr(0, 60)),
                    "The file is cut off or damaged.");
      }
      left -= element.count * each;
    }
  }

  std::string_view bytes_;
  const std::string& file_;
  std::size_t at_;
  char line_end_ = '\n';
  int line_ = 0;
};

}  // namespace

std::size_t size_of(PlyType type) {
  for (const NamedType& entry : kTypes) {
    if (entry.type == type) return entry.size;
  }
  return 0;
}

std::size_t PlyElement::smallest_size(PlyFormat format) const {
  std::size_t size = 0;
  for (const PlyProperty& property : properties) {
    size += format == PlyFormat::ascii ? 2 : size_of(property.is_list ? property.count_type : property.type);
  }
  return size;
}

PlyHeader read_ply_header(std::string_view bytes, const std::string& file) { return HeaderReader(bytes, file).read(); }

}  // namespace glowworm
