// Materials of files older than physically based ones: colours, a Phong exponent, MTL's illumination models.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/rgb.h"
#include "image/texture_file.h"
#include "import/notes.h"
#include "scene/scene.h"

namespace glowworm {

/// A texture as a file names it.
struct PhongTexture {
  std::string name;                ///< as the file has it; empty: none
  std::uint32_t embedded = kNone;  ///< index of the texture inside of the file that it means, where it is one
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  bool by_second_uvs = false;
};

/// What a file says of a material. The defaults are MTL's for what is left out.
struct PhongMaterial {
  std::string name;
  RGB diffuse{0.6f}, specular{0.0f}, emissive{0.0f};
  RGB filter{1.0f};  ///< Tf
  float exponent = 0, opacity = 1, ior = 1;
  int model = 1;  ///< MTL's illum; -1: not given
  std::optional<float> metallic, roughness;
  PhongTexture diffuse_map, opacity_map, emissive_map, normal_map;
  bool has_metal_maps = false;  ///< of metallic or roughness, which are not supported
};

/// What materials of one file are converted with.
struct PhongContext {
  /// The image of a texture that has a name; never null.
  std::function<std::shared_ptr<const TextureImage>(const PhongTexture&, const TextureOptions&)> load;
  NoteCounter& notes;
  SceneDescription& description;  ///< takes materials, texture nodes and emissions
};

/// Adds a material to the description, and its emission where it glows. Numbers that are not finite count as not given.
/// Of MTL (Wavefront, "Advanced Visualizer Manual", appendix B2) the illumination model decides:
/// - 4, 6, 7, 9 with an index Ni above 1: glass; the hue of Tf tints what goes through a solid, once in and once out,
///   while its level is left aside, since some programs write 1 for clear and some for opaque;
/// - 3, 5, 8 with Ks well above Kd: a mirror of reflectance Ks;
/// - 3, 5, 8 else: a diffuse base Kd under a gloss of reflectance Ks at normal incidence;
/// - 2 with Ks: the same with 0.08 Ks, as Blender reads and writes it, since Phong highlights are not normalised;
/// - else diffuse.
/// The exponent Ns becomes a GGX alpha of sqrt(2 / (Ns + 2)) (Walter et al., "Microfacet Models for Refraction through
/// Rough Surfaces", 2007, section 5.1); reflections that MTL traces as rays are smooth from Ns = 100 on.
/// Materials with metallic and roughness factors become metallic_roughness.
/// @return index of its emission, or kNone
std::uint32_t add_phong_material(const PhongMaterial& source, const PhongContext& context);

}  // namespace glowworm
