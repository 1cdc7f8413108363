// Materials of older formats: colours, a Phong exponent, and MTL's illumination models.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/rgb.h"
#include "image/texture_file.h"
#include "import/notes.h"
#include "import/stand_in.h"
#include "scene/scene.h"

namespace glowworm {

/// A texture as named by a file.
struct PhongTexture {
  std::string name;                ///< as in the file; empty: none
  std::uint32_t embedded = kNone;  ///< index of the embedded texture, if it is one
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  bool by_second_uvs = false;
  Vec2 scale{1, 1}, offset{0, 0};  ///< it is looked up at scale * uv + offset
  float base = 0, gain = 1;        ///< its colours are base + gain * colour
};

/// A material as given in a file, with MTL's defaults.
struct PhongMaterial {
  std::string name;
  RGB diffuse{0.6f}, specular{0.0f}, emissive{0.0f};
  RGB filter{1.0f};  ///< Tf
  float exponent = 0, opacity = 1, ior = 1;
  int model = 1;  ///< MTL's illum; -1: not given
  std::optional<float> metallic, roughness;
  PhongTexture diffuse_map, opacity_map, emissive_map, normal_map;
  bool has_metal_maps = false;  ///< has metallic or roughness textures, which are not supported
};

using PhongTextureLoader =
    std::function<std::shared_ptr<const TextureImage>(const PhongTexture&, const TextureOptions&, StandIn)>;

/// Shared data for converting the materials of one file.
struct PhongContext {
  /// Loads the image of a texture that has a name; never returns null.
  PhongTextureLoader load;
  NoteCounter& notes;
  SceneDescription& description;  ///< receives materials, texture nodes and emissions
};

/// Adds a material to the description, and its emission if it has one. Numbers that are not finite count as not given.
/// The illumination model of MTL (Wavefront, "Advanced Visualizer Manual", appendix B2) selects the material:
/// - 4, 6, 7, 9 with an index Ni above 1: glass. The hue of Tf tints light that passes through a solid, once on entry
/// and
///   once on exit. The level of Tf is ignored, since some programs write 1 for clear and some for opaque;
/// - 3, 5, 8 with Ks well above Kd: a mirror of reflectance Ks;
/// - 3, 5, 8 otherwise: a diffuse base Kd under a gloss of reflectance Ks at normal incidence;
/// - 2 with Ks: the same with 0.08 Ks, as Blender reads and writes it, since Phong highlights are not normalised;
/// - otherwise: diffuse.
/// The exponent Ns becomes a GGX alpha of sqrt(2 / (Ns + 2)) (Walter et al., "Microfacet Models for Refraction through
/// Rough Surfaces", 2007, section 5.1). Reflections that MTL traces as rays are smooth for Ns of 100 or more. Materials
/// with metallic and roughness factors become metallic_roughness.
/// @return index of its emission, or kNone
std::uint32_t add_phong_material(const PhongMaterial& source, const PhongContext& context);

}  // namespace glowworm
