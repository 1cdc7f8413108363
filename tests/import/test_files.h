// Files written by the import tests.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>  // mkdtemp

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "import/import.h"

namespace glowworm {

/// A test with a folder of its own, removed at its end.
class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "glowworm-import-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return path(name);
  }

  /// Loads a file that must be refused, and returns the message.
  static std::string message_of(const std::string& file) {
    try {
      load_scene(file);
    } catch (const Error& e) {
      return e.what();
    }
    ADD_FAILURE() << file << " was accepted";
    return "";
  }

 private:
  std::filesystem::path folder_;
};

/// An uncompressed 32-bit TGA image of one row; pixels are blue, green, red, alpha.
inline std::string tga_row(const std::vector<std::array<std::uint8_t, 4>>& pixels) {
  std::string bytes(18, '\0');
  bytes[2] = 2;
  bytes[12] = static_cast<char>(pixels.size());
  bytes[14] = 1;
  bytes[16] = 32;
  bytes[17] = 0x28;  // eight bits of alpha, first row on top
  for (const auto& pixel : pixels) bytes.append(reinterpret_cast<const char*>(pixel.data()), 4);
  return bytes;
}

/// Whether one of the notes holds a text.
inline testing::Matcher<const std::vector<std::string>&> HasNote(const std::string& text) {
  return testing::Contains(testing::HasSubstr(text));
}

template <typename T>
void append_bytes(std::string& out, const std::vector<T>& values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace glowworm
