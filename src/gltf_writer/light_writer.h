// Writes baked light as glTF textures, texture coordinates and materials.
#pragma once
#include <nlohmann/json.hpp>
#include <vector>

#include "gltf_writer/glb.h"
#include "gltf_writer/scene_glb.h"
#include "import/gltf/light_units.h"

namespace glowworm {

// Extensions of glTF's materials.
inline constexpr const char* kEmissiveStrength = "KHR_materials_emissive_strength";
inline constexpr const char* kUnlit = "KHR_materials_unlit";

/// Whether alpha makes parts of a glTF material transparent.
bool has_alpha(const nlohmann::json& material);

/// Puts the light of a layout into glTF files.
class LightWriter {
 public:
  /// @param units of the glTF materials that scale_glow() changes
  LightWriter(const BakeLayout& layout, const EncodedLight& light, BakeFormat format, const BakeNotes& notes,
              const GltfLightUnits& units = {});

  /// Adds the light of each atlas, unless vertices hold it.
  void add_textures(GlbFile& file);
  /// A description of the bake, for the file's extras.
  nlohmann::json description() const;

  /// The layer of a chart: an atlas, and a scale of its codes. Each layer needs a material of its own.
  int layer_of(std::uint32_t chart) const;
  /// Coordinates of a corner of a face, by its chart and its number there.
  Vec2 uv(std::uint32_t chart, std::size_t face, std::size_t corner) const;
  /// The light of a layer between texels, over the scale of level 0; linear.
  Vec3 color_at(Vec2 uv, int layer) const;
  /// Makes a glTF material show the light of a layer.
  /// @param uv_set of the coordinates for light
  void light_material(nlohmann::json& material, int layer, int uv_set) const;
  /// Brings what a glTF material emits to the values of the file.
  void scale_glow(nlohmann::json& material) const;
  /// The factor from radiance to the values of the file.
  float gain() const { return gain_; }

 private:
  const BakeLayout& layout_;
  const EncodedLight& light_;
  BakeFormat format_;
  const BakeNotes& notes_;
  float gain_, glow_gain_;
  std::vector<int> textures_;
};

}  // namespace glowworm
