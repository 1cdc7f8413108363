#include "image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr std::uint32_t kMultiPart = 0x1000;  // flag next to the version
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
    const bool multi_part = (number() & kMultiPart) != 0;
    // An empty header ends the headers of several parts.
    while (check_attributes() && multi_part) {
    }
  }

 private:
  /// Checks the attributes of one header. Returns false if there are none.
  bool check_attributes() {
    bool any = false;
    for (std::string name = text(); !name.empty(); name = text()) {
      any = true;
      text();  // the type
      const std::uint32_t size = number();
      const std::uint64_t at = static_cast<std::uint64_t>(in_.tellg());
      if (size > bytes_ - std::min(at, bytes_))
        fail(fmt::format("attribute \"{}\" claims {} bytes of a file of {}", name, size, bytes_));
      in_.seekg(size, std::ios::cur);
    }
    return any;
  }

  std::uint32_t number() {
    std::array<char, 4> digits{};
    if (!in_.read(digits.data(), digits.size())) fail("its header does not end");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < digits.size(); ++i)
      value |= std::uint32_t{static_cast<std::uint8_t>(digits[i])} << (8 * i);
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
};

}  // namespace

void check_exr_header(const std::string& path) { HeaderWalk(path).check(); }

}  // namespace glowworm
