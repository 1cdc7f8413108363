// Materials of glTF files.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "import/notes.h"
#include "import/texture_cache.h"
#include "scene/scene.h"

namespace tinygltf {
struct Material;
}

namespace glowworm {

struct GltfDocument;

/// What the meshes need to know of a converted material.
struct GltfMaterialInfo {
  std::uint32_t emission = kNone;  ///< index of its emission
  int uv_set = 0;                  ///< set of texture coordinates that its textures read
};

/// Converts materials of one file: metallic-roughness with normal maps, alpha modes and the extensions
/// KHR_materials_{emissive_strength, transmission, ior, specular, clearcoat, unlit, pbrSpecularGlossiness} and
/// KHR_texture_transform. GGX alpha is the square of glTF's roughness (glTF 2.0, appendix B.2.3). An unlit surface
/// becomes a black one that emits its colour.
class GltfMaterials {
 public:
  GltfMaterials(const GltfDocument& document, TextureCache& textures, NoteCounter& notes,
                SceneDescription& description);

  /// Adds a material to the description; its place there is that of its index in the file, when they are added in
  /// order.
  GltfMaterialInfo add(const tinygltf::Material& source);

  /// Adds a copy of a material that was added, its base colour multiplied, and returns its index.
  std::uint32_t add_tinted(std::uint32_t material, RGB tint);

 private:
  /// A reference to a texture, of any of glTF's kinds.
  struct TextureReference {
    int texture = -1, uv_set = 0;
    float scale = 1;  ///< of normal textures
    Vec2 uv_scale{1, 1}, uv_offset{0, 0};
    float uv_rotation = 0;
  };

  template <typename Info>
  TextureReference reference(const Info& info);
  template <typename Extensions>
  void read_texture_transform(const Extensions& extensions, TextureReference& reference);
  std::uint32_t node(const TextureReference& reference, TextureEncoding encoding);
  std::uint32_t square(std::uint32_t node);
  std::shared_ptr<const TextureImage> image(int texture, TextureEncoding encoding);
  void set_base(const tinygltf::Material& source, Material& material);
  void set_alpha(const tinygltf::Material& source, Material& material);
  void set_extensions(const tinygltf::Material& source, Material& material);
  std::uint32_t add_emission(const tinygltf::Material& source, Material& material);
  void use_uv_set(int set);

  const GltfDocument& document_;
  TextureCache& textures_;
  NoteCounter& notes_;
  SceneDescription& description_;
  int uv_set_ = -1;  ///< of the material at hand; -1: not decided yet
};

}  // namespace glowworm
