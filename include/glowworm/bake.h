// Scenes with their light in textures.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "glowworm/render.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Options of bake(). 0 leaves the choice to Glowworm.
struct BakeOptions {
  /// Samples of each texel, gather rays of each sample, photons, seed, noise, time and memory. The size, crop, camera
  /// and AOVs of a picture are not used.
  RenderOptions render;
  std::string format = "emissive";  ///< "emissive", "unlit", "lightmap" or "vertex", as `glowworm bake --format`
  std::string light = "all";        ///< "all", or "indirect": the viewer adds direct light to a lightmap
  int atlas = 0;                    ///< side of an atlas in texels, from 16 to 16384
  double texels_per_metre = 0;      ///< in as many atlases as that takes
  std::optional<float> exposure;    ///< stops, by which values are multiplied as 2^exposure; none: by the scene
  bool allow_outside = false;       ///< the file may hold files from outside of the scene file's folder
};

/// Writes a scene with its light as a GLB file, as `glowworm bake` does; whole or not at all. A scene from a glTF file
/// becomes that file with light, and everything else in it stays; the file is read once more for that.
/// @param progress as of render()
/// Throws Error for options that make no sense, for scenes without a surface to bake, and for files that cannot be
/// written.
void bake(const Scene& scene, const std::string& path, const BakeOptions& options = {},
          const std::function<void(double)>& progress = {});

}  // namespace glowworm::api
