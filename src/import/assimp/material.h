// Materials as Assimp gives them (of MTL above all) to materials of the scene.
#pragma once
#include <cstdint>
#include <string>

#include "import/notes.h"
#include "import/texture_cache.h"
#include "scene/scene.h"

struct aiMaterial;
struct aiScene;

namespace glowworm {

/// What materials of one file are converted with.
struct AssimpMaterialContext {
  const aiScene& scene;
  std::string folder;  ///< that texture names are relative to
  TextureCache& textures;
  NoteCounter& notes;
  SceneDescription& description;  ///< takes materials, texture nodes and emissions
};

/// Adds a material to the description, and its emission where it glows. Of MTL (Wavefront, "Advanced Visualizer
/// Manual", appendix B2) the illumination model decides:
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
std::uint32_t add_assimp_material(const aiMaterial& source, AssimpMaterialContext& context);

}  // namespace glowworm
