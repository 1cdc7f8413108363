#include "gltf_writer/light_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/image.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";

/// Makes the diffuse colour of KHR_materials_pbrSpecularGlossiness, which has the alpha, the base colour. It takes the
/// place of another one, which is for viewers without that extension.
void diffuse_to_base(json& material) {
  const json& extensions = material["extensions"];
  const auto found = extensions.find(kGlossiness);
  if (found == extensions.end() || !found->is_object()) return;
  json pbr = {{"baseColorFactor", found->value("diffuseFactor", json({1, 1, 1, 1}))}, {"metallicFactor", 0}};
  if (const auto texture = found->find("diffuseTexture"); texture != found->end()) pbr["baseColorTexture"] = *texture;
  material["pbrMetallicRoughness"] = pbr;
}

/// Removes all reflection.
void make_black(json& material) {
  json& pbr = material["pbrMetallicRoughness"];
  if (!pbr.is_object()) pbr = json::object();
  const json base = pbr.value("baseColorFactor", json({1, 1, 1, 1}));
  pbr["baseColorFactor"] = {0, 0, 0, base.at(3)};
  pbr["metallicFactor"] = 0;
  pbr["roughnessFactor"] = 1;
  if (!has_alpha(material)) pbr.erase("baseColorTexture");
  material["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0}};
}

}  // namespace

bool has_alpha(const json& material) { return material.value("alphaMode", "OPAQUE") != "OPAQUE"; }

LightWriter::LightWriter(const BakeLayout& layout, const EncodedLight& light, BakeFormat format, const BakeNotes& notes,
                         const GltfLightUnits& units)
    : layout_(layout),
      light_(light),
      format_(format),
      notes_(notes),
      gain_(std::exp2(notes.exposure)),
      glow_gain_(gain_ / units.radiance) {}

void LightWriter::add_textures(GlbFile& file) {
  if (format_ == BakeFormat::vertex) return;
  const auto side = static_cast<std::size_t>(layout_.atlas.side);
  for (int a = 0; a < layout_.atlas.count; ++a) {
    const auto first =
        light_.codes.begin() + static_cast<std::ptrdiff_t>(3 * side * side * static_cast<std::size_t>(a));
    std::vector<std::uint8_t> codes(first, first + static_cast<std::ptrdiff_t>(3 * side * side));
    textures_.push_back(file.add_texture(encode_png(layout_.atlas.side, layout_.atlas.side, 3, std::move(codes), {}),
                                         fmt::format("light {}", a)));
  }
}

json LightWriter::description() const {
  return {{"command", notes_.command_line},
          {kExposureStops, notes_.exposure},
          {kMetresPerUnit, notes_.metres_per_unit},
          {"unit", format_ == BakeFormat::lightmap ? "W m^-2" : "W sr^-1 m^-2"}};
}

int LightWriter::layer_of(std::uint32_t chart) const {
  return layout_.atlas.places[chart].atlas * kLightLevels + light_.level[chart];
}

Vec2 LightWriter::uv(std::uint32_t chart, std::size_t face, std::size_t corner) const {
  const Vec2 texel = layout_.atlas.places[chart].texel(layout_.charts[chart].corners[face][corner]);
  return texel * (1 / static_cast<float>(layout_.atlas.side));
}

Vec3 LightWriter::color_at(Vec2 uv, int layer) const {
  const int side = layout_.atlas.side, atlas = layer / kLightLevels;
  const float factor = light_.scale_of_level(layer % kLightLevels) / light_.scale;
  const auto code = [&](int x, int y, int channel) {
    const int row = std::clamp(y, 0, side - 1) + atlas * side;
    const std::size_t texel = layout_.texels.index(std::clamp(x, 0, side - 1), row);
    return srgb_decode(light_.codes[3 * texel + static_cast<std::size_t>(channel)]);
  };
  const float x = uv.x * static_cast<float>(side) - 0.5f, y = uv.y * static_cast<float>(side) - 0.5f;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const float s = x - std::floor(x), t = y - std::floor(y);
  Vec3 color;
  for (int c = 0; c < 3; ++c)
    color[c] = std::lerp(std::lerp(code(column, row, c), code(column + 1, row, c), s),
                         std::lerp(code(column, row + 1, c), code(column + 1, row + 1, c), s), t) *
               factor;
  return color;
}

void LightWriter::scale_glow(json& material) const {
  if (glow_gain_ == 1) return;
  // What is unlit shows its base colour, which ends at 1, and emits nothing else.
  if (material.contains("extensions") && material["extensions"].contains(kUnlit)) {
    json& pbr = material["pbrMetallicRoughness"];
    if (!pbr.is_object()) pbr = json::object();
    json& color = pbr["baseColorFactor"];
    if (!color.is_array()) color = {1, 1, 1, 1};
    for (std::size_t c = 0; c < 3; ++c) color.at(c) = std::clamp(color.at(c).get<float>() * glow_gain_, 0.0f, 1.0f);
    return;
  }
  const json glow = material.value("emissiveFactor", json({0, 0, 0}));
  if (glow == json({0, 0, 0})) return;
  json& strength = material["extensions"][kEmissiveStrength]["emissiveStrength"];
  strength = (strength.is_number() ? strength.get<float>() : 1.0f) * glow_gain_;
}

void LightWriter::light_material(json& material, int layer, int uv_set) const {
  const auto atlas = static_cast<std::size_t>(layer / kLightLevels);
  const float scale = light_.scale_of_level(layer % kLightLevels) * gain_;
  json& extensions = material["extensions"];
  if (!extensions.is_object()) extensions = json::object();
  if (format_ == BakeFormat::lightmap) {
    const json texture = {{"index", textures_[atlas]}, {"texCoord", uv_set}};
    extensions["MOZ_lightmap"] = texture;
    extensions["MOZ_lightmap"]["intensity"] = scale;
    scale_glow(material);
    if (!material.contains("extras") || material["extras"].is_object())
      material["extras"]["lightmap"] = {{"texture", texture["index"]}, {"texCoord", uv_set}, {"intensity", scale}};
  } else {
    diffuse_to_base(material);
    for (auto i = extensions.begin(); i != extensions.end();)
      i = i.key().starts_with("KHR_materials_") ? extensions.erase(i) : std::next(i);
    for (const char* key : {"emissiveFactor", "emissiveTexture", "normalTexture", "occlusionTexture"})
      material.erase(key);
    if (material.contains("pbrMetallicRoughness")) material["pbrMetallicRoughness"].erase("metallicRoughnessTexture");
  }
  if (format_ == BakeFormat::vertex) {
    extensions[kUnlit] = json::object();
    return;
  }
  const json texture = {{"index", textures_[atlas]}, {"texCoord", uv_set}};
  // Alpha needs the base colour's texture for itself.
  if (format_ == BakeFormat::unlit && !has_alpha(material)) {
    extensions[kUnlit] = json::object();
    material["pbrMetallicRoughness"]["baseColorFactor"] = {scale, scale, scale, 1};
    material["pbrMetallicRoughness"]["baseColorTexture"] = texture;
  } else if (format_ != BakeFormat::lightmap) {
    make_black(material);
    extensions[kEmissiveStrength] = {{"emissiveStrength", scale}};
    material["emissiveFactor"] = {1, 1, 1};
    material["emissiveTexture"] = texture;
  }
  if (atlas >= notes_.textures.size() || (material.contains("extras") && !material["extras"].is_object())) return;
  const BakeNotes::TextureFile& beside = notes_.textures[atlas];
  json& extra = material["extras"]["light"];
  extra = {{"file", beside.name}, {"texCoord", uv_set}};
  if (beside.range > 0) extra["rgbm"] = beside.range;
}

}  // namespace glowworm
