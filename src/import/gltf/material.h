// Materials of glTF files.
#pragma once
#include <cstdint>

#include "import/gltf/mesh.h"
#include "import/notes.h"
#include "import/texture_cache.h"
#include "scene/scene.h"

namespace tinygltf {
struct Material;
class Value;
}  // namespace tinygltf

namespace glowworm {

struct GltfDocument;

/// Properties of a converted material that meshes need.
struct GltfMaterialInfo {
  std::uint32_t index = kNone;     ///< index in the description
  std::uint32_t emission = kNone;  ///< index of its emission
  GltfUvSets uv_sets;              ///< the sets of texture coordinates that its textures use
};

/// Converts the materials of one file: metallic-roughness with normal maps, alpha modes, KHR_texture_transform and the
/// extensions KHR_materials_{anisotropy, clearcoat, diffuse_transmission, dispersion, emissive_strength, ior,
/// iridescence, pbrSpecularGlossiness, sheen, specular, scatter, transmission, unlit, volume,
/// volume_scatter}. GGX alpha is the square of glTF's
/// roughness (glTF 2.0, appendix B.2.3). An unlit surface becomes black and emits its colour.
class GltfMaterials {
 public:
  GltfMaterials(const GltfDocument& document, TextureCache& textures, NoteCounter& notes,
                SceneDescription& description);

  /// Adds a material of the file to the description, or glTF's default material.
  /// @param material_index in the file; its number of materials or more: the default
  /// @param tinted whether vertex colours multiply its colour
  GltfMaterialInfo add(std::size_t material_index, bool tinted = false);

 private:
  /// A reference to a texture, of any type in glTF.
  struct TextureReference {
    int texture = -1, uv_set = 0;
    float scale = 1;  ///< scale of normal textures
    Vec2 uv_scale{1, 1}, uv_offset{0, 0};
    float uv_rotation = 0;
  };

  template <typename Info>
  TextureReference reference(const Info& info);
  template <typename Extensions>
  void read_texture_transform(const Extensions& extensions, TextureReference& reference);
  std::uint32_t node(const TextureReference& reference, TextureEncoding encoding, StandIn stand_in);
  /// The texture of a member of an extension.
  std::uint32_t texture(const tinygltf::Value& of, const char* key, TextureEncoding encoding,
                        StandIn stand_in = StandIn::one);
  std::uint32_t product(std::uint32_t a, std::uint32_t b);
  std::uint32_t square(std::uint32_t node);
  std::uint32_t times_vertex_color(std::uint32_t node);
  std::shared_ptr<const TextureImage> image(int texture, TextureEncoding encoding, StandIn stand_in);
  void set_base(const tinygltf::Material& source, Material& material);
  void set_alpha(const tinygltf::Material& source, Material& material);
  void set_extensions(const tinygltf::Material& source, Material& material);
  void set_layers(const tinygltf::Material& source, Material& material);
  void set_volume(const tinygltf::Material& source, Material& material);
  /// Gives a surface the medium of its KHR_materials_volume, and of KHR_materials_scatter, on its inside.
  void set_medium(const tinygltf::Material& source, const tinygltf::Value& volume, Material& material);
  /// @param is_moved whether an animation moves what the material emits
  std::uint32_t add_emission(const tinygltf::Material& source, bool is_moved, Material& material);
  bool use_uv_set(int set);

  const GltfDocument& document_;
  TextureCache& textures_;
  NoteCounter& notes_;
  SceneDescription& description_;
  Reservation held_;
  GltfUvSets uv_sets_;  ///< of the current material; -1: not assigned yet
};

}  // namespace glowworm
