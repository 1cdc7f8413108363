#include "import/gltf/material.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "import/gltf/document.h"
#include "import/gltf/value.h"
#include "import/mesh_tools.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

float unit_range(double value) { return static_cast<float>(std::clamp(value, 0.0, 1.0)); }

RGB positive(RGB c) { return {std::max(c.r, 0.0f), std::max(c.g, 0.0f), std::max(c.b, 0.0f)}; }

RGB color_of(const std::vector<double>& factor, RGB otherwise) {
  if (factor.size() < 3) return otherwise;
  const RGB c(static_cast<float>(factor[0]), static_cast<float>(factor[1]), static_cast<float>(factor[2]));
  return is_finite(c) ? positive(c) : otherwise;
}

TextureWrap wrap_of(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::clamp;
  return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? TextureWrap::mirror : TextureWrap::repeat;
}

constexpr float kDefaultDielectricReflectance = 0.04f;  ///< of index 1.5; specularColorFactor scales it

/// Albedo of single scattering that gives a half-space this albedo under diffuse light (Kulla and Conty, "Revisiting
/// Physically Based Shading at Imageworks", 2017).
RGB albedo_of_multiscatter(RGB color, float g) {
  RGB out;
  for (int c = 0; c < 3; ++c) {
    const float x = color[c];
    const float s = std::max(4.09712f + 4.20863f * x - std::sqrt(9.59217f + 41.6808f * x + 17.7126f * x * x), 0.0f);
    out[c] = std::clamp((1 - s * s) / (1 - g * s * s), 0.0f, 1.0f);
  }
  return out;
}

}  // namespace

GltfMaterials::GltfMaterials(const GltfDocument& document, TextureCache& textures, NoteCounter& notes,
                             SceneDescription& description)
    : document_(document),
      textures_(textures),
      notes_(notes),
      description_(description),
      held_(*document.budget, "materials", 0) {}

/// Returns whether a set is the second one of the current material.
bool GltfMaterials::use_uv_set(int set) {
  if (uv_sets_.first < 0) uv_sets_.first = set;
  if (uv_sets_.first == set) return false;
  if (uv_sets_.second < 0) uv_sets_.second = set;
  if (uv_sets_.second != set) notes_.add("texture by a third set of texture coordinates: the first is used");
  return uv_sets_.second == set;
}

template <typename Extensions>
void GltfMaterials::read_texture_transform(const Extensions& extensions, TextureReference& reference) {
  const tinygltf::Value* transform = find_extension(extensions, "KHR_texture_transform");
  if (!transform) return;
  reference.uv_scale = {element_member(*transform, "scale", 0, 1), element_member(*transform, "scale", 1, 1)};
  reference.uv_offset = {element_member(*transform, "offset", 0, 0), element_member(*transform, "offset", 1, 0)};
  reference.uv_rotation = number_member(*transform, "rotation", 0);
  reference.uv_set = static_cast<int>(number_member(*transform, "texCoord", static_cast<float>(reference.uv_set)));
}

template <typename Info>
GltfMaterials::TextureReference GltfMaterials::reference(const Info& info) {
  TextureReference out;
  out.texture = info.index;
  out.uv_set = info.texCoord;
  if constexpr (std::is_same_v<Info, tinygltf::NormalTextureInfo>) out.scale = static_cast<float>(info.scale);
  read_texture_transform(info.extensions, out);
  return out;
}

// glTF 2.0, section 3.8.3: transfer functions in image files (gAMA, ICC profiles) are ignored.
std::shared_ptr<const TextureImage> GltfMaterials::image(int index, TextureEncoding encoding, StandIn stand_in) {
  const std::string name = fmt::format("textures[{}] of {}", index, document_.path);
  if (index >= static_cast<int>(document_.model->textures.size()))
    return textures_.missing(name, "no such texture", stand_in);
  const tinygltf::Texture& texture = document_.model->textures[static_cast<std::size_t>(index)];
  int source = texture.source;
  for (const char* extension : {"EXT_texture_webp", "MSFT_texture_dds", "KHR_texture_basisu"}) {
    const tinygltf::Value* other = find_extension(texture.extensions, extension);
    if (other && source < 0) source = static_cast<int>(number_member(*other, "source", -1));
  }
  if (source < 0 || source >= static_cast<int>(document_.images.size())) {
    return textures_.missing(name, "it names no image", stand_in);
  }
  TextureOptions options;
  options.encoding = encoding;
  if (texture.sampler >= 0) {
    const tinygltf::Sampler& sampler = document_.model->samplers.at(static_cast<std::size_t>(texture.sampler));
    options.wrap_u = wrap_of(sampler.wrapS);
    options.wrap_v = wrap_of(sampler.wrapT);
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) options.filter = TextureFilter::nearest;
  }
  const GltfImage& image = document_.images[static_cast<std::size_t>(source)];
  const std::string image_name = fmt::format("images[{}] of {}", source, document_.path);
  if (image.buffer_view >= 0)
    return textures_.load_memory(image_name, document_.view(image.buffer_view), options, stand_in);
  if (image.uri.starts_with("data:")) {
    return textures_.load_memory(image_name, decode_data_uri(image.uri), options, stand_in);
  }
  return textures_.load_file(find_texture_file(document_.folder, decode_uri(image.uri)), options, stand_in);
}

std::uint32_t GltfMaterials::node(const TextureReference& reference, TextureEncoding encoding, StandIn stand_in) {
  if (reference.texture < 0) return kNone;
  const std::uint32_t id = add_image_node(description_.textures, image(reference.texture, encoding, stand_in));
  description_.textures[id].second_uv = use_uv_set(reference.uv_set);
  // glTF: uv' = offset + R (scale uv) with v downwards and R(u, v) = (c u + s v, -s u + c v). Here v points upwards (v
  // -> 1 - v before and after), so the same rotation is counter-clockwise, and the offset changes accordingly.
  const float c = std::cos(reference.uv_rotation), s = std::sin(reference.uv_rotation);
  const Vec2 scale = reference.uv_scale, offset = reference.uv_offset;
  TextureNode& node = description_.textures[id];
  node.uv_offset = {s * scale.y + offset.x, 1 - c * scale.y - offset.y};
  if (reference.uv_rotation == 0) {
    node.uv_scale = scale;
    return id;
  }
  node.uv_rotation = reference.uv_rotation;
  if (scale.x == 1 && scale.y == 1) return id;
  // A node scales after it rotates, but glTF scales first, so a second node around this one scales.
  TextureNode outer;
  outer.kind = TextureKind::scale;
  outer.uv_scale = scale;
  outer.child_a = id;
  return add_node(description_.textures, std::move(outer));
}

std::uint32_t GltfMaterials::texture(const tinygltf::Value& of, const char* key, TextureEncoding encoding,
                                     StandIn stand_in) {
  return node(reference(texture_member(of, key)), encoding, stand_in);
}

std::uint32_t GltfMaterials::product(std::uint32_t a, std::uint32_t b) {
  if (a == kNone || b == kNone) return a == kNone ? b : a;
  return add_product_node(description_.textures, a, b);
}

std::uint32_t GltfMaterials::square(std::uint32_t id) { return product(id, id); }

std::uint32_t GltfMaterials::times_vertex_color(std::uint32_t id) {
  TextureNode node;
  node.kind = TextureKind::vertex_color;
  return product(id, add_node(description_.textures, std::move(node)));
}

void GltfMaterials::set_base(const tinygltf::Material& source, Material& material) {
  const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
  material.kind = MaterialKind::metallic_roughness;
  material.reflectance.value = clamp(color_of(pbr.baseColorFactor, RGB(1.0f)), 0, 1);
  material.reflectance.texture = node(reference(pbr.baseColorTexture), TextureEncoding::srgb, StandIn::magenta);
  const std::uint32_t texture = node(reference(pbr.metallicRoughnessTexture), TextureEncoding::linear, StandIn::one);
  material.metallic = {unit_range(pbr.metallicFactor), texture, Channel::blue};
  const float roughness = unit_range(pbr.roughnessFactor);
  material.roughness_u = {roughness * roughness, square(texture), Channel::green};
  material.roughness_v = material.roughness_u;
  if (source.normalTexture.index >= 0) {
    const TextureReference normals = reference(source.normalTexture);
    material.normal_map = {RGB(1.0f), node(normals, TextureEncoding::linear, StandIn::flat_normal)};
    material.normal_scale = normals.scale;
  }
  if (source.occlusionTexture.index >= 0) notes_.add("occlusion texture, not used: occlusion is computed");
}

void GltfMaterials::set_alpha(const tinygltf::Material& source, Material& material) {
  if (source.alphaMode == "OPAQUE") return;
  const std::vector<double>& factor = source.pbrMetallicRoughness.baseColorFactor;
  float opacity = factor.size() > 3 ? unit_range(factor[3]) : 1.0f;
  if (const auto* old = find_extension(source.extensions, "KHR_materials_pbrSpecularGlossiness"))
    opacity = unit_range(element_member(*old, "diffuseFactor", 3, 1));
  material.alpha = {opacity, material.reflectance.texture, Channel::alpha};
  if (source.alphaMode == "MASK") {
    material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
  } else if (source.alphaMode != "BLEND") {
    notes_.add("alphaMode '" + source.alphaMode + "' is not known, taken as BLEND");
  }
}

void GltfMaterials::set_extensions(const tinygltf::Material& source, Material& material) {
  const auto find = [&](const char* name) { return find_extension(source.extensions, name); };
  if (const auto* ior = find("KHR_materials_ior")) {
    const float value = number_member(*ior, "ior", 1.5f);
    material.ior = value == 0 ? 1e4f : std::max(1.0f, value);  // 0 means total reflection
  }
  if (const auto* specular = find("KHR_materials_specular")) {
    material.specular = {unit_range(number_member(*specular, "specularFactor", 1)),
                         texture(*specular, "specularTexture", TextureEncoding::linear), Channel::alpha};
    material.specular_color = {positive(color_member(*specular, "specularColorFactor", RGB(1.0f))),
                               texture(*specular, "specularColorTexture", TextureEncoding::srgb)};
  }
  set_layers(source, material);
  set_volume(source, material);
  for (const auto& [name, value] : source.extensions) {
    if (!is_supported_extension(name)) notes_.add("material extension " + name + " is not supported, left out");
  }
}

void GltfMaterials::set_layers(const tinygltf::Material& source, Material& material) {
  const auto find = [&](const char* name) { return find_extension(source.extensions, name); };
  if (const auto* coat = find("KHR_materials_clearcoat")) {
    material.clearcoat = {unit_range(number_member(*coat, "clearcoatFactor", 0)),
                          texture(*coat, "clearcoatTexture", TextureEncoding::linear), Channel::red};
    const float roughness = unit_range(number_member(*coat, "clearcoatRoughnessFactor", 0));
    material.coat_roughness = {roughness * roughness,
                               square(texture(*coat, "clearcoatRoughnessTexture", TextureEncoding::linear)),
                               Channel::green};
    material.coat_normal_map = {
        RGB(1.0f), texture(*coat, "clearcoatNormalTexture", TextureEncoding::linear, StandIn::flat_normal)};
    if (coat->Has("clearcoatNormalTexture"))
      material.coat_normal_scale = number_member(coat->Get("clearcoatNormalTexture"), "scale", 1);
  }
  if (const auto* sheen = find("KHR_materials_sheen")) {
    material.sheen = {clamp(color_member(*sheen, "sheenColorFactor", RGB(0.0f)), 0, 1),
                      texture(*sheen, "sheenColorTexture", TextureEncoding::srgb)};
    material.sheen_roughness = {unit_range(number_member(*sheen, "sheenRoughnessFactor", 0)),
                                texture(*sheen, "sheenRoughnessTexture", TextureEncoding::linear), Channel::alpha};
  }
  if (const auto* anisotropy = find("KHR_materials_anisotropy")) {
    const std::uint32_t map =
        texture(*anisotropy, "anisotropyTexture", TextureEncoding::linear, StandIn::along_tangent);
    material.anisotropy = {unit_range(number_member(*anisotropy, "anisotropyStrength", 0)), map, Channel::blue};
    material.anisotropy_rotation = number_member(*anisotropy, "anisotropyRotation", 0);
    material.anisotropy_direction = {RGB(1.0f), map};
  }
  if (const auto* film = find("KHR_materials_iridescence")) {
    material.iridescence = {unit_range(number_member(*film, "iridescenceFactor", 0)),
                            texture(*film, "iridescenceTexture", TextureEncoding::linear), Channel::red};
    material.iridescence_ior = std::max(1.0f, number_member(*film, "iridescenceIor", 1.3f));
    const float least = std::max(0.0f, number_member(*film, "iridescenceThicknessMinimum", 100));
    const float most = std::max(0.0f, number_member(*film, "iridescenceThicknessMaximum", 400));
    material.least_film = least;
    material.film = {most - least, texture(*film, "iridescenceThicknessTexture", TextureEncoding::linear),
                     Channel::green};
  }
  if (const auto* through = find("KHR_materials_diffuse_transmission")) {
    material.diffuse_transmission = {unit_range(number_member(*through, "diffuseTransmissionFactor", 0)),
                                     texture(*through, "diffuseTransmissionTexture", TextureEncoding::linear),
                                     Channel::alpha};
    material.transmittance = {clamp(color_member(*through, "diffuseTransmissionColorFactor", RGB(1.0f)), 0, 1),
                              texture(*through, "diffuseTransmissionColorTexture", TextureEncoding::srgb)};
  }
  if (const auto* old = find("KHR_materials_pbrSpecularGlossiness")) {
    material.reflectance = {clamp(color_member(*old, "diffuseFactor", RGB(1.0f)), 0, 1),
                            texture(*old, "diffuseTexture", TextureEncoding::srgb, StandIn::magenta)};
    material.metallic = {0, kNone, Channel::blue};
    const std::uint32_t map = texture(*old, "specularGlossinessTexture", TextureEncoding::srgb);
    material.specular_color = {
        positive(color_member(*old, "specularFactor", RGB(1.0f))) / kDefaultDielectricReflectance, map};
    const float gloss = unit_range(number_member(*old, "glossinessFactor", 1));
    const float roughness = 1 - gloss;
    material.roughness_u = {map == kNone ? roughness * roughness : gloss, map, Channel::gloss};
    material.roughness_v = material.roughness_u;
  }
}

void GltfMaterials::set_medium(const tinygltf::Material& source, const tinygltf::Value& volume, Material& material) {
  const float distance = number_member(volume, "attenuationDistance", 0);
  if (!(distance > 0)) return;
  const RGB color = clamp(color_member(volume, "attenuationColor", RGB(1.0f)), 1e-6f, 1);
  const RGB sigma_t = RGB(-std::log(color.r), -std::log(color.g), -std::log(color.b)) / distance;
  if (is_black(sigma_t)) return;
  Medium medium;
  medium.name = material.name;
  RGB albedo(0.0f);
  // Drafts under both names: the colour of light scattered any number of times, and its mean cosine.
  for (const char* name : {"KHR_materials_scatter", "KHR_materials_volume_scatter"}) {
    const auto* scatter = find_extension(source.extensions, name);
    if (!scatter) continue;
    const RGB plain = color_member(*scatter, "multiscatterColor", RGB(0.0f));
    medium.g = std::clamp(number_member(*scatter, "scatterAnisotropy", 0), -0.99f, 0.99f);
    albedo = albedo_of_multiscatter(clamp(color_member(*scatter, "multiscatterColorFactor", plain), 0, 1), medium.g);
  }
  medium.sigma_s = sigma_t * albedo;
  medium.sigma_a = sigma_t * (RGB(1.0f) - albedo);
  material.inside = static_cast<std::uint32_t>(description_.media.size());
  description_.media.push_back(std::move(medium));
}

void GltfMaterials::set_volume(const tinygltf::Material& source, Material& material) {
  const auto find = [&](const char* name) { return find_extension(source.extensions, name); };
  if (const auto* transmission = find("KHR_materials_transmission")) {
    material.transmission = {unit_range(number_member(*transmission, "transmissionFactor", 0)),
                             texture(*transmission, "transmissionTexture", TextureEncoding::linear), Channel::red};
    material.thin = true;
  }
  if (const auto* volume = find("KHR_materials_volume")) {
    const bool lets_light_in = material.transmission.value > 0 || material.diffuse_transmission.value > 0;
    if (number_member(*volume, "thicknessFactor", 0) > 0) {
      material.thin = false;
      if (lets_light_in) set_medium(source, *volume, material);
    }
  }
  if (const auto* dispersion = find("KHR_materials_dispersion"))
    material.dispersion = std::max(0.0f, number_member(*dispersion, "dispersion", 0));
}

namespace {

/// Whether an animation moves what a material of the file emits: then it is a lamp at moments when it is black, too, so
/// that lamps have the same names at all moments.
bool moves_emission(const GltfDocument& document, std::size_t material) {
  const std::string of_material = fmt::format("/materials/{}/", material);
  return std::any_of(document.pointers.begin(), document.pointers.end(), [&](const GltfPointer& pointer) {
    return pointer.property.starts_with(of_material) && pointer.property.find("emissive") != std::string::npos;
  });
}

}  // namespace

std::uint32_t GltfMaterials::add_emission(const tinygltf::Material& source, bool is_moved, Material& material) {
  Emission emission;
  emission.name = material.name;
  emission.two_sided = source.doubleSided;
  emission.radiance.value = color_of(source.emissiveFactor, RGB(0.0f));
  if (const auto* strength = find_extension(source.extensions, "KHR_materials_emissive_strength")) {
    emission.radiance.value *= std::max(0.0f, number_member(*strength, "emissiveStrength", 1));
  }
  if (!is_black(emission.radiance.value)) {
    emission.radiance.texture = node(reference(source.emissiveTexture), TextureEncoding::srgb, StandIn::none);
  }
  if (source.extensions.contains("KHR_materials_unlit")) {
    notes_.add("unlit material: it emits its colour");
    emission.radiance = material.reflectance;
    material.kind = MaterialKind::diffuse;
    material.reflectance = {RGB(0.0f), kNone};
    material.normal_map = {};
  }
  emission.radiance.value = emission.radiance.value / document_.light_units.radiance;
  if (is_black(emission.radiance.value) && !is_moved) return kNone;
  description_.emissions.push_back(std::move(emission));
  return static_cast<std::uint32_t>(description_.emissions.size() - 1);
}

GltfMaterialInfo GltfMaterials::add(std::size_t material_index, bool tinted) {
  static const tinygltf::Material default_material;
  const std::vector<tinygltf::Material>& all = document_.model->materials;
  const tinygltf::Material& source = material_index < all.size() ? all[material_index] : default_material;
  held_.grow(material_bytes());
  uv_sets_ = {-1, -1};
  // Normal maps use the first set.
  if (source.normalTexture.index >= 0) use_uv_set(reference(source.normalTexture).uv_set);
  Material material;
  material.name = source.name;
  material.single_sided = !source.doubleSided;
  set_base(source, material);
  set_extensions(source, material);
  if (tinted) material.reflectance.texture = times_vertex_color(material.reflectance.texture);
  set_alpha(source, material);
  GltfMaterialInfo info;
  info.emission = add_emission(source, moves_emission(document_, material_index), material);
  info.index = static_cast<std::uint32_t>(description_.materials.size());
  info.uv_sets = {std::max(0, uv_sets_.first), uv_sets_.second};
  description_.materials.push_back(std::move(material));
  return info;
}

}  // namespace glowworm
