#include "import/phong.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/content_hash.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

constexpr float kRayTracedSmoothExponent = 100;  ///< a traced reflection is a mirror from this Ns on
constexpr float kHighlightReflectance = 0.08f;   ///< reflectance at normal incidence for Ks = 1 in illumination model 2
constexpr float kDefaultDielectricReflectance = 0.04f;  ///< of index 1.5; KHR_materials_specular scales it

/// The material with every number clamped to its range.
PhongMaterial bounded(PhongMaterial p) {
  const PhongMaterial defaults;
  const auto color = [](RGB& c, RGB otherwise) {
    c = is_finite(c) ? RGB(std::max(0.0f, c.r), std::max(0.0f, c.g), std::max(0.0f, c.b)) : otherwise;
  };
  const auto number = [](float& x, float otherwise) { x = std::isfinite(x) ? x : otherwise; };
  color(p.diffuse, defaults.diffuse);
  color(p.specular, defaults.specular);
  color(p.emissive, defaults.emissive);
  color(p.filter, defaults.filter);
  number(p.exponent, defaults.exponent);
  number(p.opacity, defaults.opacity);
  number(p.ior, defaults.ior);
  p.filter = clamp(p.filter, 0, 1);
  p.exponent = std::max(0.0f, p.exponent);
  p.opacity = std::clamp(p.opacity, 0.0f, 1.0f);
  return p;
}

/// An image whose colours have another range (MTL's -mm).
class RangedImage final : public TextureImage {
 public:
  RangedImage(std::shared_ptr<const TextureImage> image, float base, float gain)
      : image_(std::move(image)), base_(base), gain_(gain) {}
  RGB color(Vec2 uv) const override {
    const RGB c = image_->color(uv);
    const auto ranged = [&](float x) { return std::max(0.0f, base_ + gain_ * x); };
    return {ranged(c.r), ranged(c.g), ranged(c.b)};
  }
  float alpha(Vec2 uv) const override { return image_->alpha(uv); }
  bool has_alpha() const override { return image_->has_alpha(); }
  int width() const override { return image_->width(); }
  int height() const override { return image_->height(); }
  std::uint64_t identity() const override {
    ContentHash hash;
    hash.add(image_->identity());
    hash.add(base_);
    hash.add(gain_);
    return hash.value();
  }

 private:
  std::shared_ptr<const TextureImage> image_;
  float base_, gain_;
};

/// The image of a texture; null if the material has none.
std::shared_ptr<const TextureImage> image_of(const PhongTexture& texture, TextureEncoding encoding, StandIn stand_in,
                                             const PhongContext& context) {
  if (texture.name.empty()) return nullptr;
  if (texture.by_second_uvs) context.notes.add("texture by a second set of texture coordinates: the first is used");
  TextureOptions options;
  options.wrap_u = texture.wrap_u;
  options.wrap_v = texture.wrap_v;
  options.encoding = encoding;
  return context.load(texture, options, stand_in);
}

std::uint32_t node_of(std::shared_ptr<const TextureImage> image, const PhongTexture& texture,
                      const PhongContext& context) {
  if (!image) return kNone;
  if (texture.base != 0 || texture.gain != 1)
    image = std::make_shared<RangedImage>(std::move(image), texture.base, texture.gain);
  const std::uint32_t id = add_image_node(context.description.textures, std::move(image));
  context.description.textures[id].uv_scale = texture.scale;
  context.description.textures[id].uv_offset = texture.offset;
  return id;
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

bool is_glass(const PhongMaterial& p) {
  if (p.ior <= 1.001f) return false;
  if (p.model == 6 || p.model == 7 || p.model == 9) return true;
  const bool clear = p.opacity < 1 || !(p.filter == RGB(1.0f)) || max_component(p.diffuse) < 0.1f;
  return p.model == 4 && clear;  // exporters write model 4 for opaque materials, too
}

void set_surface(Material& material, const PhongMaterial& p) {
  const bool traced = p.model >= 3 && p.model <= 9;
  const float alpha = traced && p.exponent >= kRayTracedSmoothExponent ? 0 : alpha_of_exponent(p.exponent);
  const bool textured = material.reflectance.texture != kNone;
  if (is_glass(p)) {
    material.kind = MaterialKind::dielectric;
    material.ior = p.ior;
    material.reflectance = ColorInput{RGB(1.0f), kNone};
    const float clearest = max_component(p.filter);
    material.transmittance.value =
        clearest > 0 ? sqrt(p.filter / clearest) : RGB(1.0f);  // light passes twice: on entry and exit
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

/// Sets physically based factors that the file gives.
void set_factors(Material& material, const PhongMaterial& p, const PhongContext& context) {
  if (!p.metallic && !p.roughness) return;
  if (material.kind != MaterialKind::diffuse && material.kind != MaterialKind::metallic_roughness) return;
  const float metallic = p.metallic.value_or(0), roughness = p.roughness.value_or(1);
  material.kind = MaterialKind::metallic_roughness;
  material.specular_color.value = RGB(1.0f);
  material.metallic.value = std::isfinite(metallic) ? std::clamp(metallic, 0.0f, 1.0f) : 0;
  const float perceptual = std::isfinite(roughness) ? std::clamp(roughness, 0.0f, 1.0f) : 1;
  material.roughness_u.value = material.roughness_v.value = perceptual * perceptual;
  if (p.has_metal_maps) context.notes.add("metallic or roughness texture, left out");
}

void set_alpha(Material& material, const PhongMaterial& p, const std::shared_ptr<const TextureImage>& diffuse,
               const PhongContext& context) {
  material.alpha.value = p.opacity;
  if (auto opacity = image_of(p.opacity_map, TextureEncoding::linear, StandIn::one, context)) {
    material.alpha.channel = opacity->has_alpha() ? Channel::alpha : Channel::mean;
    material.alpha.texture = node_of(std::move(opacity), p.opacity_map, context);
  } else if (diffuse && diffuse->has_alpha()) {
    material.alpha.channel = Channel::alpha;
    material.alpha.texture = material.reflectance.texture;
  }
}

std::uint32_t add_emission(const PhongMaterial& p, const Material& material, const PhongContext& context) {
  if (is_black(p.emissive)) return kNone;
  Emission emission;
  emission.name = material.name;
  emission.radiance.value = p.emissive;
  emission.radiance.texture =
      node_of(image_of(p.emissive_map, TextureEncoding::automatic, StandIn::none, context), p.emissive_map, context);
  context.description.emissions.push_back(std::move(emission));
  return static_cast<std::uint32_t>(context.description.emissions.size() - 1);
}

}  // namespace

std::uint32_t add_phong_material(const PhongMaterial& source, const PhongContext& context) {
  const PhongMaterial p = bounded(source);
  Material material;
  material.name = p.name;
  material.reflectance.value = clamp(p.diffuse, 0, 1);
  const auto diffuse = image_of(p.diffuse_map, TextureEncoding::automatic, StandIn::magenta, context);
  material.reflectance.texture = node_of(diffuse, p.diffuse_map, context);
  set_alpha(material, p, diffuse, context);
  set_surface(material, p);
  set_factors(material, p, context);
  material.normal_map.texture =
      node_of(image_of(p.normal_map, TextureEncoding::linear, StandIn::flat_normal, context), p.normal_map, context);
  const std::uint32_t emission = add_emission(p, material, context);
  context.description.materials.push_back(std::move(material));
  return emission;
}

}  // namespace glowworm
