// Data shared by the parts that build a scene from pbrt directives.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "core/rgb.h"
#include "image/texture_file.h"
#include "import/import.h"
#include "import/pbrt/diagnostics.h"
#include "import/pbrt/file.h"
#include "import/pbrt/parameters.h"
#include "import/stand_in.h"
#include "scene/scene.h"
#include "scene/scene_checks.h"

namespace glowworm {

/// Colour space of "rgb" parameters (directive ColorSpace).
enum class PbrtColorSpace : std::uint8_t { srgb, rec2020, dci_p3, aces2065_1 };

/// A named texture: a constant, a node of the scene's texture table, or a constant times a node.
struct PbrtTexture {
  RGB value{1.0f};
  std::uint32_t node = kNone;
};

using PbrtTextures = std::map<std::string, PbrtTexture, std::less<>>;  ///< by name

/// Opens an image file as a texture. Never returns null.
using PbrtImageLoader = std::function<std::shared_ptr<const TextureImage>(
    const std::string& path, const TextureOptions& options, StandIn stand_in)>;

/// The scene under construction, and the names defined in its file.
struct PbrtContext {
  explicit PbrtContext(CoordinateOrigin& o) : origin(o) {}
  CoordinateOrigin& origin;  ///< is subtracted from all positions
  SceneDescription scene;
  PbrtDiagnostics diagnostics;
  std::string main_file;
  bool v3 = false;                ///< the file is for pbrt-v3
  double seconds = 0;             ///< the moment that is shown
  bool moves = false;             ///< whether anything moves; known at the end
  SceneMotion* motion = nullptr;  ///< gets the cameras of more moments; null: none
  PbrtColorSpace color_space = PbrtColorSpace::srgb;
  /// Limits the memory of files, meshes, and triangles with all instances expanded: even a small file can ask for any
  /// number.
  std::shared_ptr<MemoryBudget> budget = std::make_shared<MemoryBudget>();
  std::unique_ptr<Reservation> sky;      ///< memory of scene.environment's pixels
  std::size_t subdivided_triangles = 0;  ///< total of all loopsubdiv shapes so far
  PbrtImageLoader load_image;
  PbrtImageLoader load_needed_image;       ///< throws Error if the file cannot be read, and uses no stand-in
  std::vector<TextureCost> texture_costs;  ///< of the first nodes of scene.textures
  PbrtTextures float_textures, spectrum_textures;

  /// Full path of a file named in a parameter.
  std::string resolve(const std::string& name, const PbrtPlace& place) const {
    return resolve_pbrt_path(name, main_file, place.file ? *place.file : main_file);
  }
};

}  // namespace glowworm
