// What the parts that build a scene from pbrt directives share.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/memory_budget.h"
#include "core/rgb.h"
#include "image/texture_file.h"
#include "import/pbrt/diagnostics.h"
#include "import/pbrt/parameters.h"
#include "scene/scene.h"

namespace glowworm {

/// Colour space that "rgb" parameters are given in (directive ColorSpace).
enum class PbrtColorSpace : std::uint8_t { srgb, rec2020, dci_p3, aces2065_1 };

/// A named texture: a constant, a node of the scene's texture table, or a constant times a node.
struct PbrtTexture {
  RGB value{1.0f};
  std::uint32_t node = kNone;
  Channel channel = Channel::mean;  ///< of float textures: what a number is taken from
};

/// Opens an image file as a texture. Never gives null.
using PbrtImageLoader =
    std::function<std::shared_ptr<const TextureImage>(const std::string& path, const TextureOptions& options)>;

/// The scene as it grows, and the names that its file has defined.
struct PbrtContext {
  SceneDescription scene;
  PbrtDiagnostics diagnostics;
  std::string main_file;
  bool v3 = false;  ///< the file is for pbrt-v3
  PbrtColorSpace color_space = PbrtColorSpace::srgb;
  /// Bounds files, meshes, and triangles with all instances resolved: small files can ask for any number.
  std::shared_ptr<MemoryBudget> budget = std::make_shared<MemoryBudget>();
  std::unique_ptr<Reservation> sky;      ///< of the pixels of scene.environment
  std::size_t subdivided_triangles = 0;  ///< of all loopsubdiv shapes so far
  PbrtImageLoader load_image;
  PbrtImageLoader load_needed_image;  ///< throws Error where the file cannot be read
  std::map<std::string, PbrtTexture, std::less<>> float_textures, spectrum_textures;

  /// Full path of a file that a parameter names.
  std::string resolve(const std::string& name, const PbrtPlace& place) const;
};

}  // namespace glowworm
