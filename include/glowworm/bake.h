// Scenes with their light in textures.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "glowworm/render.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// How baked light is stored.
enum class BakeFormat : std::uint8_t {
  emissive,  ///< surfaces glow with their radiance: emissiveTexture and KHR_materials_emissive_strength
  unlit,     ///< the same as base colour with KHR_materials_unlit; values end at 1
  lightmap,  ///< base colours, and irradiance by the extension MOZ_lightmap
  vertex,    ///< base colours with KHR_materials_unlit, times irradiance over pi at vertices; values end at 1
};
/// Names of the formats, in the order of BakeFormat: "emissive" and so on.
std::vector<std::string> bake_format_names();

/// Options of bake(). 0 leaves the choice to Glowworm.
struct BakeOptions {
  /// Samples of each texel, gather rays of each sample, photons, seed, noise, time and memory. The size, crop, camera
  /// and AOVs of a picture are not used.
  RenderOptions render;
  BakeFormat format = BakeFormat::emissive;
  bool indirect_only = false;     ///< leave direct light to the viewer, which adds it to a lightmap
  int atlas = 0;                  ///< side of an atlas in texels, from 16 to 16384
  double texels_per_metre = 0;    ///< in as many atlases as that takes
  std::optional<float> exposure;  ///< stops, by which values are multiplied as 2^exposure; none: by the scene
  bool allow_outside = false;     ///< the file may hold files from outside of the scene file's folder
};

/// Names for RenderOptions::more of bakes.
std::vector<std::string> bake_option_names();

/// Writes a scene with its light as a GLB file, as `glowworm bake` does; whole or not at all. A scene from a glTF file
/// becomes that file with light, and everything else in it stays; the file is read once more for that.
/// @param progress as of render()
/// Throws Error for options that make no sense, for scenes without a surface to bake, and for files that cannot be
/// written.
void bake(const Scene& scene, const std::string& path, const BakeOptions& options = {},
          const std::function<void(double)>& progress = {});

}  // namespace glowworm::api
