// A scene with its baked light as a GLB file.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "bake/layout.h"
#include "bake/light.h"
#include "glowworm/bake.h"
#include "import/gltf/parts.h"

namespace glowworm {

using api::BakeFormat;

/// Names for --format, in the order of BakeFormat.
std::vector<std::string> bake_format_names();

/// The quantity that textures of a format hold.
TexelLight quantity_of(BakeFormat format);

/// That quantity in the file of a scene of this origin, or null, as BakeNotes::gltf.
ShownLight shown_light(BakeFormat format, const GltfParts* gltf);

/// What codes of a format should hold. Unlit colours and colours of vertices end at 1.
/// @param exposure stops
/// @param scene and layout: must outlive the result
LightRange range_of(const Scene& scene, const BakeLayout& layout, BakeFormat format, float exposure);

/// Prints a note about the images outside of its folder that a glTF file shows, because the bake only names them.
/// Throws Error if a scene read other files there, because the bake would put their content into its output.
/// @param files  the scene's ImportOptions::outside_files
/// @param gltf   as BakeNotes::gltf
/// @param option name of the option that allows it, for the remedy
void check_outside_files(const std::vector<std::string>& files, const GltfParts* gltf, const std::string& option);

/// Metadata of a baked file.
struct BakeNotes {
  float exposure = 0;        ///< stops: values of the file are radiance or irradiance times 2^exposure
  std::string command_line;  ///< for the file's extras
  /// Files beside this one with the light of each atlas in full range, for the extras of materials; may be empty.
  struct TextureFile {
    std::string name;
    float range = 0;  ///< of RGBM (encode_rgbm()); 0: the file is an EXR file
  };
  std::vector<TextureFile> textures;
  /// Origin of the scene's triangles: a glTF file that the bake changes. Null, or without a path: the file is new.
  std::shared_ptr<const GltfParts> gltf = nullptr;
  bool indirect_only = false;  ///< direct light is left to the viewer
  float metres_per_unit = 1;   ///< of that glTF file in the scene; the bake's file keeps the units
  bool allow_outside = false;  ///< the file may hold image files from outside of the glTF file's folder
  std::string folder = {};     ///< of the new file, which names images from there
};

/// The file. A scene that comes from a glTF file is that file with light: each baked mesh gets texture coordinates for
/// light, and a copy where several nodes show it; everything else stays. Throws Error where the file cannot be read
/// again. The file of another scene has the triangles of each object with TEXCOORD_1 for the light, their materials,
/// and the cameras. What was not baked keeps its material as far as glTF has words for it, and lamps glow.
std::string glb_of_scene(const Scene& scene, const BakeLayout& layout, const EncodedLight& light, BakeFormat format,
                         const BakeNotes& notes);

}  // namespace glowworm
