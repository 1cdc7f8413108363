#include "image/exr_check.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <vector>

#include "core/error.h"

namespace glowworm {

namespace {

// Flags next to the version.
constexpr std::uint32_t kTiled = 0x200, kDeep = 0x800, kMultiPart = 0x1000;
constexpr std::size_t kLongestName = 255;

// Values of the attribute "compression", and rows in a block of each: PIZ, PXR24, B44, B44A, DWAA and DWAB follow.
enum : std::uint8_t { kNone, kRle, kZips, kZip };
constexpr std::array<std::int64_t, 10> kRowsOfBlock = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

// Attributes that are used here, and their types.
const std::map<std::string, std::string> kUsed = {{"channels", "chlist"},
                                                  {"compression", "compression"},
                                                  {"dataWindow", "box2i"},
                                                  {"tiles", "tiledesc"},
                                                  {"type", "string"}};

// Bytes of attributes by their types. OpenEXR reads so many, whatever the file claims.
const std::map<std::string, std::uint32_t> kBytesOfType = {{"box2f", 16},
                                                           {"box2i", 16},
                                                           {"chromaticities", 32},
                                                           {"compression", 1},
                                                           {"deepImageState", 1},
                                                           {"double", 8},
                                                           {"envmap", 1},
                                                           {"float", 4},
                                                           {"int", 4},
                                                           {"keycode", 28},
                                                           {"lineOrder", 1},
                                                           {"m33d", 72},
                                                           {"m33f", 36},
                                                           {"m44d", 128},
                                                           {"m44f", 64},
                                                           {"rational", 8},
                                                           {"tiledesc", 9},
                                                           {"timecode", 8},
                                                           {"v2d", 16},
                                                           {"v2f", 8},
                                                           {"v2i", 8},
                                                           {"v3d", 24},
                                                           {"v3f", 12},
                                                           {"v3i", 12}};

std::uint32_t number_in(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<std::uint8_t>(bytes[at + i])} << (8 * i);
  return value;
}

struct Size {
  std::int64_t width = 0, height = 0;

  /// How many blocks of a size cover this.
  std::int64_t blocks(Size block) const {
    return ((width + block.width - 1) / block.width) * ((height + block.height - 1) / block.height);
  }
};

/// The side of a tiled picture at a level: half of that of the level before.
std::int64_t side_at(std::int64_t side, int level, bool round_up) {
  return std::max<std::int64_t>((side + (round_up ? (std::int64_t{1} << level) - 1 : 0)) >> level, 1);
}

int levels(std::int64_t side, bool round_up) {
  int level = 0;
  while (side_at(side, level, round_up) > 1) ++level;
  return level + 1;
}

/// One picture of a file, as its header describes it.
struct Part {
  Size size, block;
  std::int64_t bytes_of_pixel = 0;
  std::size_t compression = kNone;
  std::uint8_t level_mode = 0;  // of the attribute "tiles"
  bool tiled = false, deep = false;

  /// How many blocks the file lists for it: tiles of all levels, or groups of rows.
  std::int64_t listed_blocks() const {
    enum : std::uint8_t { kMipMap = 1, kRipMap = 2, kMode = 15 };
    const bool up = level_mode > kMode;
    std::int64_t count = size.blocks(block);
    const auto add = [&](int x, int y) {
      count += Size{side_at(size.width, x, up), side_at(size.height, y, up)}.blocks(block);
    };
    if ((level_mode & kMode) == kMipMap) {
      for (int level = 1; level < levels(std::max(size.width, size.height), up); ++level) add(level, level);
    } else if ((level_mode & kMode) == kRipMap) {
      for (int y = 0; y < levels(size.height, up); ++y) {
        for (int x = y == 0; x < levels(size.width, up); ++x) add(x, y);
      }
    }
    return count;
  }

  /// Bytes of the pixels of a block of the largest level.
  std::int64_t bytes_of_block(std::int64_t index) const {
    const std::int64_t across = Size{size.width, 1}.blocks(block);
    const std::int64_t x = index % across * block.width, y = index / across * block.height;
    return std::min(block.width, size.width - x) * std::min(block.height, size.height - y) * bytes_of_pixel;
  }
};

class ExrFile {
 public:
  /// Reads and checks the headers.
  explicit ExrFile(const std::string& path) : path_(path), in_(path, std::ios::binary) {
    std::error_code unknown;
    bytes_ = std::filesystem::file_size(path, unknown);
    if (!in_ || unknown) throw Error({path}, "cannot be opened", "Check that you may read it.");
    in_.seekg(4);  // the magic number
    flags_ = number();
    std::vector<Attributes> headers;
    do {
      headers.push_back(read_attributes());
    } while (flags_ & kMultiPart && !headers.back().empty());
    // An empty header ends the headers of several parts.
    if (flags_ & kMultiPart && headers.size() > 1) headers.pop_back();
    for (Attributes& header : headers) parts_.push_back(part(header));
    if (parts_[0].deep) throw Error({path}, "is a deep picture, which is not read", "Flatten it.");
  }

  void check_blocks() {
    std::vector<std::uint64_t> places;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const std::int64_t count = parts_[i].listed_blocks();
      if (static_cast<std::uint64_t>(count) > bytes_ / 8) fail(fmt::format("{} blocks in {} bytes", count, bytes_));
      for (std::int64_t k = 0; k < count; ++k) {
        const std::uint64_t low = number(), place = low | std::uint64_t{number()} << 32;
        // OpenEXR would look for all blocks itself.
        if (place == 0 || place >= bytes_) fail("a block of pixels is missing");
        if (i == 0) places.push_back(place);
      }
    }
    const Part& part = parts_[0];
    for (std::int64_t i = 0; i < part.size.blocks(part.block); ++i) {
      in_.seekg(static_cast<std::streamoff>(places[static_cast<std::size_t>(i)]));
      // The numbers of its part, and of its row or those of its tile and level.
      for (int skipped = (flags_ & kMultiPart ? 1 : 0) + (part.tiled ? 4 : 1); skipped > 0; --skipped) number();
      check_block(part.compression, part.bytes_of_block(i));
    }
  }

 private:
  /// The values of the attributes of a header by their names. Those that are not used here are empty.
  using Attributes = std::map<std::string, std::string>;

  Attributes read_attributes() {
    Attributes values;
    for (std::string name = text(); !name.empty(); name = text()) {
      const std::string type = text();
      const std::uint32_t size = number();
      const std::uint64_t at = static_cast<std::uint64_t>(in_.tellg());
      if (size > bytes_ - std::min(at, bytes_))
        fail(fmt::format("attribute \"{}\" claims {} bytes of a file of {}", name, size, bytes_));
      const auto used = kUsed.find(name);
      std::string& value = values[name];
      value.clear();
      const bool is_used = used != kUsed.end() && used->second == type;
      if (is_used || type == "chlist" || type == "idmanifest" || type == "preview" || type == "stringvector") {
        value.resize(size);
        in_.read(value.data(), size);
      } else {
        in_.seekg(size, std::ios::cur);
      }
      if (size != bytes_of_value(type, value, size))
        fail(fmt::format("attribute \"{}\" of type {} claims {} bytes", name, type, size));
      if (!is_used) value.clear();
    }
    return values;
  }

  /// How many bytes OpenEXR reads of an attribute; another number than `size` if it would not stay within the value.
  std::uint64_t bytes_of_value(const std::string& type, const std::string& value, std::uint32_t size) const {
    constexpr std::uint64_t kWrong = std::uint64_t{1} << 32;
    if (const auto fixed = kBytesOfType.find(type); fixed != kBytesOfType.end()) return fixed->second;
    if (type == "floatvector") return size / 4 * 4;
    if (type == "preview") {
      const std::uint64_t width = size < 8 ? size : number_in(value, 0), height = size < 8 ? size : number_in(value, 4);
      return width > 0 && height > size / width ? kWrong : 8 + 4 * width * height;
    }
    // Deflate expands a byte to at most 1032.
    if (type == "idmanifest") return size < 4 || number_in(value, 0) / 1032 > size ? kWrong : size;
    std::uint64_t at = 0;
    if (type == "stringvector") {
      while (at + 4 <= size) at += 4 + std::uint64_t{number_in(value, at)};
      return at;
    }
    if (type != "chlist") return size;
    while (at < size && value[at] != '\0') at = std::min<std::uint64_t>(value.find('\0', at), size) + 17;
    return at + 1;
  }

  Part part(Attributes& values) const {
    const std::string &window = values["dataWindow"], &type = values["type"], &tiles = values["tiles"];
    if (values["channels"].empty() || values["compression"].size() != 1 || window.size() != 16)
      fail("a header lacks channels, compression or data window");
    Part part;
    const auto side = [&](std::size_t low) {
      return std::int64_t{static_cast<std::int32_t>(number_in(window, low + 8))} -
             static_cast<std::int32_t>(number_in(window, low)) + 1;
    };
    part.size = {side(0), side(4)};
    constexpr std::int64_t kMaxSide = 1 << 20;  // as of all formats
    if (std::min(part.size.width, part.size.height) < 1 || std::max(part.size.width, part.size.height) > kMaxSide)
      fail(fmt::format("it claims {} x {} pixels", part.size.width, part.size.height));
    part.bytes_of_pixel = bytes_of_pixel(values["channels"]);
    part.compression = static_cast<std::uint8_t>(values["compression"][0]);
    if (part.compression >= kRowsOfBlock.size()) fail(fmt::format("unknown compression {}", part.compression));
    part.deep = flags_ & kMultiPart ? type.starts_with("deep") : (flags_ & kDeep) != 0;
    part.tiled = flags_ & kMultiPart ? type == "tiledimage" || type == "deeptile" : (flags_ & kTiled) != 0;
    part.block = {part.size.width, kRowsOfBlock[part.compression]};
    if (!part.tiled) return part;
    if (tiles.size() != 9) fail("a header lacks the size of tiles");
    part.block = {number_in(tiles, 0), number_in(tiles, 4)};
    if (part.block.width < 1 || part.block.height < 1) fail("it claims tiles without pixels");
    // OpenEXR allocates whole tiles, however small the picture is.
    const std::int64_t most = std::max(part.size.width * part.size.height, std::int64_t{1} << 24);
    if (part.block.width > most / part.block.height)
      fail(fmt::format("it claims tiles of {} x {} pixels", part.block.width, part.block.height));
    part.level_mode = static_cast<std::uint8_t>(tiles[8]);
    return part;
  }

  /// Bytes of a pixel in all channels.
  std::int64_t bytes_of_pixel(const std::string& channels) const {
    std::int64_t bytes = 0;
    for (std::size_t at = 0; at < channels.size() && channels[at] != '\0';) {
      at = std::min(channels.find('\0', at), channels.size()) + 1;
      if (at + 16 > channels.size()) fail("its list of channels does not end");
      if (number_in(channels, at + 8) != 1 || number_in(channels, at + 12) != 1)
        throw Error({path_}, "has channels of fewer pixels than others, which are not read",
                    "Save it with whole channels, such as R, G and B.");
      constexpr std::uint32_t kHalf = 1, kTypes = 3;
      const std::uint32_t type = number_in(channels, at);
      if (type >= kTypes) fail(fmt::format("unknown type of channel {}", type));
      bytes += type == kHalf ? 2 : 4;
      at += 16;
    }
    constexpr std::int64_t kMostBytes = 1 << 14;
    if (bytes > kMostBytes) fail("it claims too many channels");
    return bytes;
  }

  /// Checks the block of a number of bytes whose length comes next in the file.
  void check_block(std::size_t compression, std::int64_t wanted) {
    const std::int64_t length = number();
    if (length == 0) fail("a block has no bytes");
    if (compression > kZip) return;  // OpenEXR checks that the others are whole
    // OpenEXR unpacks a block only if it is shorter than its pixels.
    std::int64_t unpacked = length;
    if (length < wanted && compression == kRle) unpacked = unpacked_rle(length);
    if (length < wanted && compression >= kZips) unpacked = unpacked_zip(length, wanted);
    if (unpacked != wanted) fail(fmt::format("a block of {} bytes holds {}", wanted, unpacked));
  }

  /// How many bytes come out of the next ones of the file: runs of a byte after their length less one, or negative
  /// numbers of bytes that stand for themselves.
  std::int64_t unpacked_rle(std::int64_t length) {
    std::int64_t unpacked = 0;
    while (length > 0) {
      const auto count = static_cast<std::int8_t>(in_.get());
      const std::int64_t taken = count < 0 ? -std::int64_t{count} : 1;
      in_.ignore(taken);
      length -= 1 + taken;
      unpacked += count < 0 ? taken : count + 1;
    }
    if (length < 0 || !in_) fail("it ends within a run");
    return unpacked;
  }

  std::int64_t unpacked_zip(std::int64_t length, std::int64_t wanted) {
    packed_.resize(static_cast<std::size_t>(length));
    pixels_.resize(static_cast<std::size_t>(wanted));
    if (!in_.read(packed_.data(), length)) fail("it ends too soon");
    auto unpacked = static_cast<uLongf>(wanted);
    const int result = uncompress(reinterpret_cast<Bytef*>(pixels_.data()), &unpacked,
                                  reinterpret_cast<const Bytef*>(packed_.data()), static_cast<uLong>(length));
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    if (result != Z_OK) fail("a block cannot be inflated");
    return static_cast<std::int64_t>(unpacked);
  }

  std::uint32_t number() {
    std::string digits(4, '\0');
    if (!in_.read(digits.data(), 4)) fail("it ends too soon");
    return number_in(digits, 0);
  }

  std::string text() {
    std::string out;
    for (int next = in_.get(); next != 0; next = in_.get()) {
      if (next < 0 || out.size() == kLongestName) fail("its header does not end");
      out.push_back(static_cast<char>(next));
    }
    return out;
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw Error({path_}, "truncated or damaged: " + why, "Save or copy the file again.");
  }

  const std::string& path_;
  std::ifstream in_;
  std::uint64_t bytes_ = 0;
  std::uint32_t flags_ = 0;
  std::vector<Part> parts_;
  std::vector<char> packed_, pixels_;  // of a block
};

}  // namespace

void check_exr_header(const std::string& path) { ExrFile{path}; }

void check_exr_blocks(const std::string& path) { ExrFile(path).check_blocks(); }

}  // namespace glowworm
