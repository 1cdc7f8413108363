// Builds binary glTF 2.0 files.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// A GLB file: JSON, and one buffer that its buffer views share (glTF 2.0, sections 3.6 and 4.4).
struct GlbFile {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;

  /// Appends an object to a list at the top of the file and returns its index.
  int add(const char* list, nlohmann::json object);
  /// @param target 34962 vertices, 34963 indices, 0 neither
  int add_view(std::string_view content, int target);
  int add_vectors(std::span<const Vec3> values, bool bounded);
  int add_pairs(std::span<const Vec2> values);
  /// Vertex attributes of 1 to 4 components.
  int add_floats(std::span<const float> values, std::size_t components);
  /// In 16 bits where these suffice.
  int add_indices(std::span<const std::uint32_t> values);
  /// A texture of a PNG file. @param repeats whether it goes on beyond its borders
  int add_texture(const std::string& png, const std::string& name, bool repeats = false);

  /// The whole file. The names of all extensions in it are in extensionsUsed. Throws Error if it is too large.
  std::string content() const;
};

/// The names of all extensions that some object of a file has.
std::vector<std::string> extensions_in(const nlohmann::json& json);

}  // namespace glowworm
