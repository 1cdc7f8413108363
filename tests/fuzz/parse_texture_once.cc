#include <stdlib.h>  // mkdtemp

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"
#include "fuzz/parse_once.h"
#include "image/texture_file.h"

namespace glowworm::fuzz {

namespace {

/// Bytes that a picture may take. Headers that claim more are refused; to decode larger pictures would take most of the
/// time, for no other code.
constexpr std::uint64_t kPictureBudget = std::uint64_t{4} << 20;

/// Where the bytes stand for the reader: in memory where the system has a folder of that kind. TGA needs the ending;
/// other formats are known by their content.
const std::string& texture_path() {
  struct Folder {
    Folder() {
      const bool in_memory = std::filesystem::is_directory("/dev/shm");
      std::string name = (in_memory ? "/dev/shm" : std::filesystem::temp_directory_path().string()) + "/fuzz-XXXXXX";
      if (!mkdtemp(name.data())) std::abort();
      file = name + "/texture.tga";
    }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(std::filesystem::path(file).parent_path(), ignored);
    }
    std::string file;
  };
  static const Folder folder;
  return folder.file;
}

}  // namespace

void parse_texture(std::string_view bytes) {
  std::ofstream(texture_path(), std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto budget = [] { return std::make_shared<MemoryBudget>(kPictureBudget); };
  try {
    // Once held whole and once in a file, which must agree.
    TextureLibrary whole(kPictureBudget, budget()), stored(4, budget());
    const auto a = whole.open(texture_path()), b = stored.open(texture_path());
    for (int i = 0; i < 64; ++i) {
      const Vec2 uv{static_cast<float>(i) / 63, static_cast<float>(i * 17 % 64) / 63};
      const RGB color = a->color(uv);
      if (!(color == b->color(uv)) || a->alpha(uv) != b->alpha(uv) || !is_finite(color)) std::abort();
    }
  } catch (const Error&) {
  }
}

}  // namespace glowworm::fuzz
