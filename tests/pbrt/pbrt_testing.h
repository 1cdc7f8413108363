// Small scenes from text, for the tests of the pbrt importer.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "core/error.h"
#include "import/import.h"
#include "support/temporary_folder.h"

namespace glowworm::pbrt_testing {

/// A TGA picture of one row; pixels are blue, green, red and, where there are four bytes for each, alpha.
inline std::string tga_row(int width, std::string_view pixels) {
  const bool has_alpha = pixels.size() == 4 * static_cast<std::size_t>(width);
  std::string bytes(18, '\0');
  bytes[2] = 2;
  bytes[12] = static_cast<char>(width);
  bytes[14] = 1;
  bytes[16] = has_alpha ? 32 : 24;
  bytes[17] = has_alpha ? 0x28 : 0x20;  // first row on top, eight bits of alpha
  return bytes.append(pixels);
}

/// Loads a scene from text.
inline SceneDescription load_text(std::string_view text, const ImportOptions& options = {}) {
  const TemporaryFolder folder;
  return load_scene(folder.write("scene.pbrt", text), options);
}

/// The message with which loading a text fails, paths of the folder taken out; empty where it succeeds.
inline std::string error_of(std::string_view text, const ImportOptions& options = {}) {
  const TemporaryFolder folder;
  const std::string path = folder.write("scene.pbrt", text);
  try {
    load_scene(path, options);
  } catch (const Error& error) {
    std::string message = error.what();
    const std::string prefix = folder.path("");
    for (std::size_t at = message.find(prefix); at != std::string::npos; at = message.find(prefix)) {
      message.erase(at, prefix.size());
    }
    return message;
  }
  return {};
}

/// One triangle with area 1/2, to make scenes that are about something else.
inline constexpr const char* kTriangle =
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

/// Whether a note begins with `text`.
inline bool has_note(const SceneDescription& scene, std::string_view text) {
  for (const std::string& note : scene.notes) {
    if (std::string_view(note).starts_with(text)) return true;
  }
  return false;
}

inline double total_area(const Geometry& geometry) {
  double sum = 0;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) sum += geometry.area(t);
  return sum;
}

inline void expect_near(RGB a, RGB b, float tolerance = 1e-5f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "channel " << c;
}

inline void expect_near(Vec3 a, Vec3 b, float tolerance = 1e-5f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "xyz"[c];
}

}  // namespace glowworm::pbrt_testing
