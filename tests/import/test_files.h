// Files written by the import tests.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "import/import.h"
#include "support/temporary_folder.h"

namespace glowworm {

/// A test that loads files.
class FileTest : public FolderTest {
 protected:
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
