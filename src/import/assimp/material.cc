#include "import/assimp/material.h"

#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

namespace glowworm {

namespace {

constexpr float kRayTracedSmoothExponent = 100;  ///< Ns from which a traced reflection is a mirror's
constexpr float kHighlightReflectance = 0.08f;   ///< reflectance at normal incidence of Ks = 1 in illumination model 2
constexpr float kDefaultDielectricReflectance = 0.04f;  ///< of index 1.5, which KHR_materials_specular scales

struct Phong {
  RGB diffuse{0.5f}, specular{0.0f}, emissive{0.0f}, filter{1.0f};
  float exponent = 0, opacity = 1, ior = 1;
  int model = -1;  ///< MTL's illum; -1: not given
};

RGB color_of(const aiMaterial& material, const char* key, unsigned type, unsigned index, RGB otherwise) {
  aiColor3D c(otherwise.r, otherwise.g, otherwise.b);
  material.Get(key, type, index, c);
  const RGB color(c.r, c.g, c.b);
  return is_finite(color) ? RGB(std::max(0.0f, color.r), std::max(0.0f, color.g), std::max(0.0f, color.b)) : otherwise;
}

float number_of(const aiMaterial& material, const char* key, unsigned type, unsigned index, float otherwise) {
  float value = otherwise;
  if (material.Get(key, type, index, value) != aiReturn_SUCCESS || !std::isfinite(value)) return otherwise;
  return value;
}

Phong phong_of(const aiMaterial& source) {
  Phong p;
  p.diffuse = color_of(source, AI_MATKEY_COLOR_DIFFUSE, RGB(0.5f));
  p.specular = color_of(source, AI_MATKEY_COLOR_SPECULAR, RGB(0.0f));
  p.emissive = color_of(source, AI_MATKEY_COLOR_EMISSIVE, RGB(0.0f));
  p.filter = clamp(color_of(source, AI_MATKEY_COLOR_TRANSPARENT, RGB(1.0f)), 0, 1);
  p.exponent = std::max(0.0f, number_of(source, AI_MATKEY_SHININESS, 0));
  p.opacity = std::clamp(number_of(source, AI_MATKEY_OPACITY, 1), 0.0f, 1.0f);
  p.ior = number_of(source, AI_MATKEY_REFRACTI, 1);
  source.Get("$mat.illum", 0, 0, p.model);
  return p;
}

TextureWrap wrap_of(int mode) {
  switch (mode) {
    case aiTextureMapMode_Clamp:
    case aiTextureMapMode_Decal:
      return TextureWrap::clamp;
    case aiTextureMapMode_Mirror:
      return TextureWrap::mirror;
    default:
      return TextureWrap::repeat;
  }
}

/// The texture of a type as an image; null where the material has none.
std::shared_ptr<const TextureImage> image_of(const aiMaterial& source, aiTextureType type, TextureEncoding encoding,
                                             AssimpMaterialContext& context) {
  aiString name;
  if (source.Get(AI_MATKEY_TEXTURE(type, 0), name) != aiReturn_SUCCESS || name.length == 0) return nullptr;
  int mode_u = aiTextureMapMode_Wrap, mode_v = aiTextureMapMode_Wrap, uv_set = 0;
  source.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), mode_u);
  source.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), mode_v);
  source.Get(AI_MATKEY_UVWSRC(type, 0), uv_set);
  if (uv_set != 0) context.notes.add("texture by a second set of texture coordinates: the first is used");
  TextureOptions options;
  options.wrap_u = wrap_of(mode_u);
  options.wrap_v = wrap_of(mode_v);
  options.encoding = encoding;
  const aiTexture* embedded = context.scene.GetEmbeddedTexture(name.C_Str());
  if (!embedded) {
    return context.textures.load_file(find_texture_file(context.folder, name.C_Str()), options);
  }
  std::span<const std::uint8_t> bytes;  // stays empty, hence magenta, for raw pixels, which no reader in use gives
  if (embedded->mHeight == 0) bytes = {reinterpret_cast<const std::uint8_t*>(embedded->pcData), embedded->mWidth};
  return context.textures.load_memory(name.C_Str(), bytes, options);
}

std::uint32_t node_of(std::shared_ptr<const TextureImage> image, AssimpMaterialContext& context) {
  return image ? add_image_node(context.description.textures, std::move(image)) : kNone;
}

float alpha_of_exponent(float exponent) { return std::min(1.0f, std::sqrt(2 / (exponent + 2))); }

void set_gloss(Material& material, RGB reflectance, float alpha) {
  material.kind = MaterialKind::metallic_roughness;
  material.ior = 1.5f;
  material.metallic.value = 0;
  material.specular.value = 1;
  material.specular_color.value = reflectance / kDefaultDielectricReflectance;
  material.roughness_u.value = material.roughness_v.value = alpha;
}

bool is_glass(const Phong& p) {
  if (p.ior <= 1.001f) return false;
  if (p.model == 6 || p.model == 7 || p.model == 9) return true;
  const bool clear = p.opacity < 1 || !(p.filter == RGB(1.0f)) || max_component(p.diffuse) < 0.1f;
  return p.model == 4 && clear;  // exporters write model 4 for opaque materials too
}

void set_surface(Material& material, const Phong& p) {
  const bool traced = p.model >= 3 && p.model <= 9;
  const float alpha = traced && p.exponent >= kRayTracedSmoothExponent ? 0 : alpha_of_exponent(p.exponent);
  const bool textured = material.reflectance.texture != kNone;
  if (is_glass(p)) {
    material.kind = MaterialKind::dielectric;
    material.ior = p.ior;
    material.reflectance = ColorInput{RGB(1.0f), kNone};
    const float clearest = max_component(p.filter);
    material.transmittance.value = clearest > 0 ? sqrt(p.filter / clearest) : RGB(1.0f);  // passed twice: in and out
    material.alpha.value = 1;
  } else if (traced && max_component(p.specular) > 0.05f && !textured &&
             max_component(p.diffuse) <= 0.5f * max_component(p.specular)) {
    material.kind = MaterialKind::conductor;
    material.use_reflectance = true;
    material.reflectance.value = clamp(p.specular, 0, 1);
    material.roughness_u.value = material.roughness_v.value = alpha;
  } else if (traced && !is_black(p.specular)) {
    set_gloss(material, clamp(p.specular, 0, 1), alpha);
  } else if (p.model != 0 && p.model != 1 && !is_black(p.specular) && p.exponent > 0) {
    set_gloss(material, clamp(p.specular, 0, 1) * kHighlightReflectance, alpha);
  } else {
    material.kind = MaterialKind::diffuse;
  }
}

/// Physically based factors, where the file gives them.
void set_factors(Material& material, const aiMaterial& source, AssimpMaterialContext& context) {
  float metallic = 0, roughness = 1;
  const bool has_metallic = source.Get(AI_MATKEY_METALLIC_FACTOR, metallic) == aiReturn_SUCCESS;
  const bool has_roughness = source.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness) == aiReturn_SUCCESS;
  if (!has_metallic && !has_roughness) return;
  if (material.kind != MaterialKind::diffuse && material.kind != MaterialKind::metallic_roughness) return;
  material.kind = MaterialKind::metallic_roughness;
  material.specular_color.value = RGB(1.0f);
  material.metallic.value = std::isfinite(metallic) ? std::clamp(metallic, 0.0f, 1.0f) : 0;
  const float perceptual = std::isfinite(roughness) ? std::clamp(roughness, 0.0f, 1.0f) : 1;
  material.roughness_u.value = material.roughness_v.value = perceptual * perceptual;
  if (source.GetTextureCount(aiTextureType_METALNESS) + source.GetTextureCount(aiTextureType_DIFFUSE_ROUGHNESS) > 0) {
    context.notes.add("metallic or roughness texture, left out");
  }
}

void set_alpha(Material& material, const Phong& p, const aiMaterial& source,
               const std::shared_ptr<const TextureImage>& diffuse, AssimpMaterialContext& context) {
  material.alpha.value = p.opacity;
  if (auto opacity = image_of(source, aiTextureType_OPACITY, TextureEncoding::linear, context)) {
    material.alpha.channel = opacity->has_alpha() ? Channel::alpha : Channel::mean;
    material.alpha.texture = node_of(std::move(opacity), context);
  } else if (diffuse && diffuse->has_alpha()) {
    material.alpha.channel = Channel::alpha;
    material.alpha.texture = material.reflectance.texture;
  }
}

std::uint32_t add_emission(const Phong& p, const Material& material, const aiMaterial& source,
                           AssimpMaterialContext& context) {
  if (is_black(p.emissive)) return kNone;
  Emission emission;
  emission.name = material.name;
  emission.radiance.value = p.emissive;
  emission.radiance.texture =
      node_of(image_of(source, aiTextureType_EMISSIVE, TextureEncoding::automatic, context), context);
  context.description.emissions.push_back(std::move(emission));
  return static_cast<std::uint32_t>(context.description.emissions.size() - 1);
}

}  // namespace

std::uint32_t add_assimp_material(const aiMaterial& source, AssimpMaterialContext& context) {
  Material material;
  material.name = source.GetName().C_Str();
  const Phong phong = phong_of(source);
  material.reflectance.value = clamp(phong.diffuse, 0, 1);
  auto diffuse = image_of(source, aiTextureType_DIFFUSE, TextureEncoding::automatic, context);
  if (!diffuse) diffuse = image_of(source, aiTextureType_BASE_COLOR, TextureEncoding::automatic, context);
  material.reflectance.texture = node_of(diffuse, context);
  set_alpha(material, phong, source, diffuse, context);
  set_surface(material, phong);
  set_factors(material, source, context);
  if (auto normals = image_of(source, aiTextureType_NORMALS, TextureEncoding::linear, context)) {
    material.normal_map.texture = node_of(std::move(normals), context);
  }
  const std::uint32_t emission = add_emission(phong, material, source, context);
  context.description.materials.push_back(std::move(material));
  return emission;
}

}  // namespace glowworm
