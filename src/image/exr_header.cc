#include "image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "core/error.h"

namespace glowworm {

namespace {

// Flags next to the version.
constexpr std::uint32_t kTiled = 0x200, kDeep = 0x800, kMultiPart = 0x1000;
constexpr std::size_t kLongestName = 255;

class HeaderWalk {
 public:
  explicit HeaderWalk(const std::string& path) : path_(path), in_(path, std::ios::binary) {
    std::error_code unknown;
    bytes_ = std::filesystem::file_size(path, unknown);
    if (!in_ || unknown) throw Error({path}, "cannot be opened", "Check that you may read it.");
  }

  void check() {
    in_.seekg(4);  // the magic number
    const std::uint32_t flags = number();
    // An empty header ends the headers of several parts.
    bool whole = true;
    while (check_attributes()) {
      whole &= !values_["channels"].empty() && values_["compression"].size() == 1 && values_["dataWindow"].size() == 16;
      if (!(flags & kMultiPart)) break;
    }
    if (!whole) fail("a header lacks channels, compression or data window");
    if ((flags & (kTiled | kDeep | kMultiPart)) == 0 && values_["compression"] == std::string(1, '\0')) check_rows();
  }

 private:
  /// Checks the attributes of one header. Returns false if there are none.
  bool check_attributes() {
    bool any = false;
    values_.clear();
    for (std::string name = text(); !name.empty(); name = text()) {
      any = true;
      const std::string type = text();
      const std::uint32_t size = number();
      const std::uint64_t at = static_cast<std::uint64_t>(in_.tellg());
      if (size > bytes_ - std::min(at, bytes_))
        fail(fmt::format("attribute \"{}\" claims {} bytes of a file of {}", name, size, bytes_));
      if ((name == "channels" && type == "chlist") || (name == "compression" && type == name) ||
          (name == "dataWindow" && type == "box2i"))
        in_.read(values_.insert_or_assign(name, std::string(size, '\0')).first->second.data(), size);
      else
        in_.seekg(size, std::ios::cur);
    }
    return any;
  }

  /// Checks the sizes of rows without compression, one to a block.
  void check_rows() {
    const std::string& window = values_["dataWindow"];
    const auto side = [&](std::size_t low, std::size_t high) {
      return std::int64_t{static_cast<std::int32_t>(number_in(window, high))} -
             static_cast<std::int32_t>(number_in(window, low)) + 1;
    };
    const std::int64_t width = side(0, 8), rows = side(4, 12), wanted = width * bytes_of_column();
    if (wanted <= 0) return;  // OpenEXR refuses windows without pixels
    if (static_cast<std::uint64_t>(rows) > bytes_ / 8) fail(fmt::format("{} rows in {} bytes", rows, bytes_));
    std::vector<std::uint64_t> places(static_cast<std::size_t>(std::max<std::int64_t>(rows, 0)));
    for (std::uint64_t& place : places) {
      place = number();
      place |= std::uint64_t{number()} << 32;
    }
    for (const std::uint64_t place : places) {
      in_.seekg(static_cast<std::streamoff>(std::min(place, bytes_)));
      number();  // of the row
      if (const std::uint32_t size = number(); size != wanted)
        fail(fmt::format("a row of {} bytes claims {}", wanted, size));
    }
  }

  /// Bytes of a pixel in all channels; 0 if some have fewer pixels.
  std::int64_t bytes_of_column() {
    const std::string& channels = values_["channels"];
    std::int64_t bytes = 0;
    for (std::size_t at = 0; at < channels.size() && channels[at] != '\0';) {
      at = std::min(channels.find('\0', at), channels.size()) + 1;
      if (at + 16 > channels.size()) fail("its list of channels does not end");
      if (number_in(channels, at + 8) != 1 || number_in(channels, at + 12) != 1) return 0;
      constexpr std::uint32_t kHalf = 1;
      bytes += number_in(channels, at) == kHalf ? 2 : 4;
      at += 16;
    }
    return bytes;
  }

  std::uint32_t number() {
    std::string digits(4, '\0');
    if (!in_.read(digits.data(), 4)) fail("it ends too soon");
    return number_in(digits, 0);
  }

  static std::uint32_t number_in(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<std::uint8_t>(bytes[at + i])} << (8 * i);
    return value;
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
  std::map<std::string, std::string> values_;  // of some attributes of the last header
};

}  // namespace

void check_exr_header(const std::string& path) { HeaderWalk(path).check(); }

}  // namespace glowworm
