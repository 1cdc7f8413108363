// Materials of glTF files.
#include <cmath>

#include "gltf_file.h"

namespace glowworm {
namespace {

using nlohmann::json;

class GltfMaterialTest : public GltfTest {
 protected:
  /// A material whose texture 0 has one row of two texels, and whose texture 1 the same, by the second coordinates.
  SceneDescription textured(const json& material, const std::vector<std::array<std::uint8_t, 4>>& texels) const {
    write("t.tga", tga_row(texels));
    GltfFile file;
    file.add("images", {{"uri", "t.tga"}});
    file.add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
    file.add("textures", {{"source", 0}, {"sampler", 0}});
    file.add_shown_triangle(material);
    return load(file);
  }
};

TEST_F(GltfMaterialTest, FactorsAndTheirDefaults) {
  const auto plain = with_material(json::object());
  EXPECT_EQ(plain.materials[0].kind, MaterialKind::metallic_roughness);
  EXPECT_EQ(plain.materials[0].metallic.value, 1);
  EXPECT_EQ(plain.materials[0].roughness_u.value, 1);
  EXPECT_EQ(plain.materials[0].reflectance.value, RGB(1.0f));
  const auto d = with_material(
      {{"name", "red"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.8, 0.1, 0.2, 0.5}}, {"metallicFactor", 0.25}, {"roughnessFactor", 0.5}}}});
  const Material& m = d.materials[0];
  EXPECT_EQ(m.name, "red");
  EXPECT_EQ(m.reflectance.value, RGB(0.8f, 0.1f, 0.2f));
  EXPECT_EQ(m.metallic.value, 0.25f);
  EXPECT_EQ(m.roughness_u.value, 0.25f) << "alpha is the square of roughness";
  EXPECT_EQ(m.roughness_v.value, 0.25f);
  EXPECT_EQ(m.alpha.value, 1) << "OPAQUE has no alpha";
}

TEST_F(GltfMaterialTest, TexturesOfMetalAndRoughness) {
  // Blue, green, red of the two texels: metallic 51/255, roughness 102/255.
  const auto d =
      textured({{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}, {"roughnessFactor", 0.5}}}},
               {{51, 102, 0, 255}, {51, 102, 0, 255}});
  EXPECT_NEAR(evaluate(d.textures, d.materials[0].metallic, {0.5f, 0.5f}), 0.2f, 1e-5);
  EXPECT_NEAR(evaluate(d.textures, d.materials[0].roughness_u, {0.5f, 0.5f}), 0.2f * 0.2f, 1e-5);
}

TEST_F(GltfMaterialTest, TheGammaOfAPngIsIgnored) {
  // One pixel of code 128, and a gAMA chunk that says it is linear.
  GltfFile file;
  file.add("images", {{"uri",
                       "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAABGdBTUEAAYagMeiWXwAAAAxJ"
                       "REFUeJxjaGhoAAADBAGBS9PSEAAAAABJRU5ErkJggg=="}});
  file.add("textures", {{"source", 0}});
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                           {"emissiveTexture", {{"index", 0}}},
                           {"emissiveFactor", {1, 1, 1}}});
  const auto d = load(file);
  const float srgb = std::pow((128 / 255.0f + 0.055f) / 1.055f, 2.4f);
  EXPECT_NEAR(evaluate(d.textures, d.materials[0].reflectance, {0.5f, 0.5f}).g, srgb, 1e-4f);
  EXPECT_NEAR(evaluate(d.textures, d.emissions[0].radiance, {0.5f, 0.5f}).g, srgb, 1e-4f);
}

TEST_F(GltfMaterialTest, AlphaModes) {
  const json base = {{"baseColorFactor", {1, 1, 1, 0.5}}};
  const auto mask = with_material({{"pbrMetallicRoughness", base}, {"alphaMode", "MASK"}, {"alphaCutoff", 0.75}});
  EXPECT_EQ(mask.materials[0].alpha.value, 0.5f);
  EXPECT_EQ(mask.materials[0].alpha_cutoff, 0.75f);
  const auto blend = with_material({{"pbrMetallicRoughness", base}, {"alphaMode", "BLEND"}});
  EXPECT_EQ(blend.materials[0].alpha.value, 0.5f);
  EXPECT_LT(blend.materials[0].alpha_cutoff, 0);
  const json old = {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {1, 1, 1, 0.25}}}}};
  for (const char* mode : {"BLEND", "MASK"})
    EXPECT_EQ(with_material({{"extensions", old}, {"alphaMode", mode}}).materials[0].alpha.value, 0.25f) << mode;
  const auto d = textured({{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}},
                          {{0, 0, 255, 255}, {0, 0, 255, 0}});
  EXPECT_NEAR(evaluate(d.textures, d.materials[0].alpha, {0.25f, 0.5f}), 1, 1e-5);
  EXPECT_NEAR(evaluate(d.textures, d.materials[0].alpha, {0.75f, 0.5f}), 0, 1e-5);
}

TEST_F(GltfMaterialTest, EmissionByStrengthAndSide) {
  const json strength = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10.0}}}};
  const auto d = with_material({{"emissiveFactor", {1, 0.5, 0}}, {"extensions", strength}});
  ASSERT_EQ(d.emissions.size(), 1u);
  EXPECT_EQ(d.emissions[0].radiance.value, RGB(10, 5, 0));
  EXPECT_FALSE(d.emissions[0].two_sided);
  EXPECT_EQ(d.geometry.emission[0], 0u);
  EXPECT_TRUE(with_material({{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}}).emissions[0].two_sided);
  EXPECT_TRUE(with_material({{"emissiveFactor", {0, 0, 0}}}).emissions.empty());
}

TEST_F(GltfMaterialTest, Extensions) {
  const json extensions = {{"KHR_materials_ior", {{"ior", 1.33}}},
                           {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 0.5, 2}}}},
                           {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.75}, {"clearcoatRoughnessFactor", 0.5}}},
                           {"KHR_materials_transmission", {{"transmissionFactor", 0.9}}},
                           {"KHR_materials_made_up", {{"factor", 0.5}}}};
  const auto d = with_material({{"extensions", extensions}});
  const Material& m = d.materials[0];
  EXPECT_FLOAT_EQ(m.ior, 1.33f);
  EXPECT_EQ(m.specular.value, 0.5f);
  EXPECT_EQ(m.specular_color.value, RGB(1, 0.5f, 2));
  EXPECT_EQ(m.clearcoat.value, 0.75f);
  EXPECT_EQ(m.coat_roughness.value, 0.25f);
  EXPECT_FLOAT_EQ(m.transmission.value, 0.9f);
  EXPECT_TRUE(m.thin);
  EXPECT_THAT(d.notes, HasNote("KHR_materials_made_up is not supported"));
  const json solid = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                      {"KHR_materials_volume", {{"thicknessFactor", 0.1}}}};
  EXPECT_FALSE(with_material({{"extensions", solid}}).materials[0].thin);
}

TEST_F(GltfMaterialTest, VolumesAreMediaWhereLightGetsIn) {
  const auto made = [&](const json& volume, const json& other) {
    json extensions = other;
    extensions["KHR_materials_volume"] = volume;
    return with_material({{"extensions", extensions}});
  };
  const json diffuse = {{"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 1}}}};
  json clear = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
  const json tinted = {{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 1, 1}}};
  for (const json& surface : {diffuse, clear}) {
    const auto d = made(tinted, surface);
    EXPECT_EQ(d.materials[0].inside, 0u);
    EXPECT_NEAR(d.media.at(0).sigma_a.r, std::log(2) / 2, 1e-5);
    EXPECT_TRUE(d.notes.empty());
  }
  EXPECT_TRUE(made(tinted, json::object()).media.empty());
  EXPECT_TRUE(made({{"thicknessFactor", 1}}, diffuse).media.empty());
  EXPECT_TRUE(made({{"attenuationDistance", 2}, {"attenuationColor", {0.5, 1, 1}}}, clear).media.empty());

  clear["KHR_materials_volume_scatter"] = {{"multiscatterColor", {1, 0, 0.5}}, {"scatterAnisotropy", 0.5}};
  const auto d =
      made({{"thicknessFactor", 1}, {"attenuationDistance", 1}, {"attenuationColor", {0.5, 0.5, 0.5}}}, clear);
  const Medium& m = d.media.at(0);
  EXPECT_TRUE(d.notes.empty()) << d.notes[0];
  EXPECT_EQ(m.g, 0.5f);
  const RGB sum = m.sigma_a + m.sigma_s;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], std::log(2), 1e-5);
  EXPECT_NEAR(m.sigma_s.r / sum.r, 1, 1e-3);
  EXPECT_NEAR(m.sigma_s.g / sum.g, 0, 1e-2);
  // A half-space of albedo 0.912 reflects half of diffuse light if it scatters evenly, and one of 0.954 if g = 0.5.
  EXPECT_NEAR(m.sigma_s.b / sum.b, 0.954f, 1e-3);
}

TEST_F(GltfMaterialTest, UnlitSurfacesEmitTheirColour) {
  const auto d = with_material({{"pbrMetallicRoughness", {{"baseColorFactor", {0.2, 0.4, 0.6, 1}}}},
                                {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  ASSERT_EQ(d.emissions.size(), 1u);
  EXPECT_EQ(d.emissions[0].radiance.value, RGB(0.2f, 0.4f, 0.6f));
  EXPECT_EQ(d.materials[0].reflectance.value, RGB(0.0f));
}

TEST_F(GltfMaterialTest, NormalTexturesWithScale) {
  const auto d = textured({{"normalTexture", {{"index", 0}, {"scale", 0.5}}}}, {{255, 128, 128, 255}});
  const RGB stored = evaluate(d.textures, d.materials[0].normal_map, {0.5f, 0.5f});
  EXPECT_NEAR(stored.r, 128 / 255.0f, 1e-5) << "numbers, not colours";
  EXPECT_NEAR(stored.b, 1, 1e-5);
  EXPECT_EQ(d.materials[0].normal_scale, 0.5f);
}

TEST_F(GltfMaterialTest, TextureTransformsAgreeWithTheirDefinition) {
  const std::vector<std::array<std::uint8_t, 4>> texels = {{0, 0, 0, 255}};
  struct Case {
    float rotation, scale_u, scale_v, offset_u, offset_v;
  };
  for (const Case& c : {Case{0, 2, 3, 0.25f, 0.5f}, Case{0.7f, 1, 1, 0.1f, 0.2f}, Case{-1.1f, 2, 0.5f, 0.3f, 0.6f}}) {
    const json transform = {
        {"rotation", c.rotation}, {"scale", {c.scale_u, c.scale_v}}, {"offset", {c.offset_u, c.offset_v}}};
    auto d =
        textured({{"pbrMetallicRoughness",
                   {{"baseColorTexture", {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}}}}}},
                 texels);
    // An image that shows where it is looked at, in glTF's coordinates.
    struct Coordinates final : TextureImage {
      RGB color(Vec2 uv) const override { return {uv.x, 1 - uv.y, 0}; }
      float alpha(Vec2) const override { return 1; }
      bool has_alpha() const override { return false; }
      int width() const override { return 1; }
      int height() const override { return 1; }
    };
    for (TextureNode& node : d.textures) {
      if (node.image) node.image = std::make_shared<Coordinates>();
    }
    const float u = 0.3f, v = 0.9f;
    const float su = c.scale_u * u, sv = c.scale_v * v, cosine = std::cos(c.rotation), sine = std::sin(c.rotation);
    const RGB seen = evaluate(d.textures, d.materials[0].reflectance, {u, 1 - v});
    EXPECT_NEAR(seen.r, c.offset_u + cosine * su + sine * sv, 1e-5);
    EXPECT_NEAR(seen.g, c.offset_v - sine * su + cosine * sv, 1e-5);
  }
}

TEST_F(GltfMaterialTest, SecondTextureCoordinates) {
  write("t.tga", tga_row({{0, 0, 255, 255}}));
  GltfFile file;
  file.add("images", {{"uri", "t.tga"}});
  file.add("textures", {{"source", 0}});
  const int second = file.add_accessor<float>({0.5, 0.5, 1, 0.5, 0.5, 1}, 5126, "VEC2", 3);
  const int material =
      file.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}});
  file.add("nodes", {{"mesh", file.add_triangle({{"material", material}, {"attributes", {{"TEXCOORD_1", second}}}})}});
  const auto d = load(file);
  EXPECT_EQ(d.geometry.uvs[d.geometry.triangles[0][0]].x, 0.5f);
  EXPECT_EQ(d.geometry.uvs[d.geometry.triangles[0][0]].y, 0.5f);
}

TEST_F(GltfMaterialTest, TexturesOfOneMaterialByTwoSets) {
  write("t.tga", tga_row({{0, 0, 255, 255}, {255, 0, 0, 255}}));  // red, blue
  GltfFile file;
  file.add("images", {{"uri", "t.tga"}});
  file.add("samplers", {{"magFilter", 9728}});
  file.add("textures", {{"source", 0}, {"sampler", 0}});
  const int second = file.add_accessor<float>({0.75, 0.5, 0.75, 0.5, 0.75, 0.5}, 5126, "VEC2", 3);
  const int material = file.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                              {"emissiveTexture", {{"index", 0}, {"texCoord", 1}}},
                                              {"emissiveFactor", {1, 1, 1}}});
  file.add("nodes", {{"mesh", file.add_triangle({{"material", material}, {"attributes", {{"TEXCOORD_1", second}}}})}});
  const auto d = load(file);
  EXPECT_THAT(d.notes, testing::Not(HasNote("coordinates")));
  const TexturePoint at = texture_point(d.geometry, 0, {0.2f, 0.2f});
  EXPECT_GT(evaluate(d.textures, d.materials[0].reflectance, at).r, 0.9f);
  EXPECT_GT(evaluate(d.textures, d.emissions[0].radiance, at).b, 0.9f);
}

TEST_F(GltfMaterialTest, VertexColoursMultiplyBaseColourAndAlpha) {
  GltfFile file;
  const int colors =
      file.add_accessor<std::uint8_t>({51, 102, 255, 255, 51, 102, 255, 255, 51, 102, 255, 0}, 5121, "VEC4", 3);
  file.json["accessors"][0]["normalized"] = true;
  const int white = file.add_accessor<float>({1, 1, 1, 1, 1, 1, 1, 1, 1}, 5126, "VEC3", 3);
  const int material = file.add(
      "materials", {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1, 1, 0.5}}}}});
  for (const int of : {colors, white})
    file.add("nodes", {{"mesh", file.add_triangle({{"material", material}, {"attributes", {{"COLOR_0", of}}}})}});
  const auto d = load(file);
  const auto seen = [&](std::uint32_t triangle, Vec2 w) {
    const Material& m = d.materials.at(d.geometry.material[triangle]);
    const TexturePoint at = texture_point(d.geometry, triangle, w);
    return std::pair(evaluate(d.textures, m.reflectance, at), evaluate(d.textures, m.alpha, at));
  };
  const auto [tinted, alpha] = seen(0, {0.3f, 0.2f});
  EXPECT_NEAR(tinted.r, 0.5f * 0.2f, 1e-5f);
  EXPECT_NEAR(tinted.g, 0.4f, 1e-5f);
  EXPECT_NEAR(alpha, 0.5f * 0.8f, 1e-5f);
  EXPECT_EQ(seen(1, {0.3f, 0.2f}).first, RGB(0.5f, 1, 1));
}

TEST_F(GltfMaterialTest, SidesThatCamerasSee) {
  EXPECT_TRUE(with_material(json::object()).materials[0].single_sided);
  EXPECT_FALSE(with_material({{"doubleSided", true}}).materials[0].single_sided);
}

TEST_F(GltfMaterialTest, LayersOfExtensions) {
  const json map = {{"index", 0}};
  const json extensions = {
      {"KHR_materials_sheen",
       {{"sheenColorFactor", {1, 0.5, 0.25}}, {"sheenRoughnessFactor", 0.5}, {"sheenRoughnessTexture", map}}},
      {"KHR_materials_anisotropy",
       {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 1.5}, {"anisotropyTexture", map}}},
      {"KHR_materials_iridescence",
       {{"iridescenceFactor", 1},
        {"iridescenceIor", 1.8},
        {"iridescenceThicknessMinimum", 200},
        {"iridescenceThicknessMaximum", 700},
        {"iridescenceThicknessTexture", map}}},
      {"KHR_materials_diffuse_transmission",
       {{"diffuseTransmissionFactor", 0.5}, {"diffuseTransmissionColorFactor", {1, 0.5, 0}}}},
      {"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}, {"scale", 0.5}}}}},
      {"KHR_materials_transmission", {{"transmissionFactor", 1}}},
      {"KHR_materials_dispersion", {{"dispersion", 2}}},
      {"KHR_materials_volume",
       {{"thicknessFactor", 1}, {"attenuationDistance", 0.5}, {"attenuationColor", {0.25, 0.5, 1}}}}};
  // Blue, green, red and alpha.
  const auto d = textured({{"extensions", extensions}}, {{255, 102, 51, 51}, {255, 102, 51, 51}});
  EXPECT_EQ(d.notes.size(), 0u) << testing::PrintToString(d.notes);
  const Material& m = d.materials[0];
  const auto value = [&](const FloatInput& input) { return evaluate(d.textures, input, {0.5f, 0.5f}); };
  EXPECT_EQ(m.sheen.value, RGB(1, 0.5f, 0.25f));
  EXPECT_NEAR(value(m.sheen_roughness), 0.5f * 0.2f, 1e-5f) << "alpha";
  EXPECT_NEAR(value(m.anisotropy), 0.5f, 1e-5f) << "blue";
  EXPECT_EQ(m.anisotropy_rotation, 1.5f);
  EXPECT_NE(m.anisotropy_direction.texture, kNone);
  EXPECT_EQ(value(m.iridescence), 1);
  EXPECT_EQ(m.iridescence_ior, 1.8f);
  EXPECT_NEAR(m.least_film + value(m.film), 200 + 0.4f * 500, 1e-2f) << "green";
  EXPECT_EQ(value(m.diffuse_transmission), 0.5f);
  EXPECT_EQ(m.transmittance.value, RGB(1, 0.5f, 0));
  EXPECT_NE(m.coat_normal_map.texture, kNone);
  EXPECT_EQ(m.coat_normal_scale, 0.5f);
  EXPECT_EQ(m.dispersion, 2);
  ASSERT_EQ(m.inside, 0u);
  EXPECT_EQ(m.outside, kUnnamed);
  const Medium& volume = d.media.at(0);
  EXPECT_NEAR(std::exp(-volume.sigma_a.r * 0.5f), 0.25f, 1e-5f) << "Beer's law at the given distance";
  EXPECT_NEAR(std::exp(-volume.sigma_a.g * 0.5f), 0.5f, 1e-5f);
  EXPECT_EQ(volume.sigma_a.b, 0);
  EXPECT_EQ(volume.sigma_s, RGB(0.0f));
}

TEST_F(GltfMaterialTest, SpecularAndGlossinessOfOneTexture) {
  const json old = {{"diffuseFactor", {0.5, 0.4, 0.3, 1}},
                    {"specularFactor", {0.5, 0.5, 0.5}},
                    {"glossinessFactor", 0.5},
                    {"specularGlossinessTexture", {{"index", 0}}}};
  const auto d = textured({{"extensions", {{"KHR_materials_pbrSpecularGlossiness", old}}}}, {{255, 255, 255, 204}});
  const Material& m = d.materials[0];
  EXPECT_NEAR(0.04f * evaluate(d.textures, m.specular_color, {0.5f, 0.5f}).r, 0.5f, 1e-5f);
  EXPECT_NEAR(evaluate(d.textures, m.roughness_u, {0.5f, 0.5f}), 0.6f * 0.6f, 1e-5f) << "(1 - 0.5 * 0.8)^2";
  EXPECT_EQ(d.notes.size(), 0u);
}

TEST_F(GltfMaterialTest, PicturesThatAreNotReadAreNamed) {
  GltfFile file;
  file.add("images", {{"uri", "data:image/ktx2;base64,q0tUWCAyMLsNChoK"}, {"mimeType", "image/ktx2"}});
  file.add("textures", {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}});
  file.json["extensionsUsed"] = {"KHR_texture_basisu"};
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const auto d = load(file);
  EXPECT_THAT(d.notes, HasNote("KHR_texture_basisu is not supported"));
  EXPECT_THAT(d.notes, HasNote("KTX"));
}

TEST_F(GltfMaterialTest, ImagesInsideOfTheFile) {
  // A BMP of 24 bits: blue to the left, red to the right.
  constexpr std::uint32_t kSide = 640;
  std::string bmp = "BM";
  append_bytes<std::uint32_t>(bmp, {54 + 3 * kSide * kSide, 0, 54, 40, kSide, kSide});
  append_bytes<std::uint16_t>(bmp, {1, 24});
  append_bytes<std::uint32_t>(bmp, {0, 3 * kSide * kSide, 2835, 2835, 0, 0});
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const bool left = i % kSide < kSide / 2;
    append_bytes<std::uint8_t>(
        bmp, {static_cast<std::uint8_t>(left ? 255 : 0), 0, static_cast<std::uint8_t>(left ? 0 : 255)});
  }
  GltfFile file;
  const int view = file.add_view(std::vector<char>(bmp.begin(), bmp.end()));
  file.add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  file.add("textures", {{"source", 0}});
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  ImportOptions options;
  for (const std::uint64_t megabytes : {0, 5}) {  // held whole, and not
    options.budget = loading_budget(megabytes << 20);
    const auto d = load_scene(write("i.glb", file.glb()), options);
    EXPECT_EQ(d.notes.size(), 0u) << testing::PrintToString(d.notes);
    EXPECT_NEAR(evaluate(d.textures, d.materials[0].reflectance, {0.25f, 0.5f}).b, 1, 1e-5);
    EXPECT_NEAR(evaluate(d.textures, d.materials[0].reflectance, {0.75f, 0.5f}).r, 1, 1e-5);
  }
}

}  // namespace
}  // namespace glowworm
