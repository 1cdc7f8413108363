// Baked files of scenes: materials, colours of vertices, and pictures of the files against those of the scenes.
#include "gltf_writer/scene_glb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "bake/fill.h"
#include "bake_stage.h"
#include "bake_testing.h"
#include "builtin/builtin.h"
#include "import/import.h"
#include "scene/scene_parts.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

/// The JSON of a GLB file.
nlohmann::json json_of(const std::string& glb) {
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, sizeof size);
  return nlohmann::json::parse(glb.substr(20, size));
}

/// A room with surfaces of materials that reflect more or less than their base colours, by names.
SceneDescription room_of_materials() {
  SceneDescription d = two_rooms();
  Material plastic, coat, metal, tinted, mix;
  plastic.name = "plastic";
  plastic.kind = MaterialKind::metallic_roughness;
  coat.name = "coat";
  coat.kind = MaterialKind::coated_diffuse;
  metal.name = "metal";
  metal.kind = MaterialKind::coated_conductor;
  for (Material* m : {&plastic, &coat, &metal}) m->roughness_u.value = m->roughness_v.value = 0.5f;
  tinted.name = "tinted";
  tinted.reflectance = {RGB(1.0f), static_cast<std::uint32_t>(d.textures.size())};
  d.textures.emplace_back().kind = TextureKind::vertex_color;
  mix.name = "mix";
  mix.kind = MaterialKind::mix;
  mix.mix_a = mix.mix_b = 0;
  for (const Material& m : {plastic, coat, metal, tinted, mix}) {
    const auto number = static_cast<std::uint32_t>(d.materials.size());
    d.materials.push_back(m);
    add_quad(d, {1.2f, 0.3f * static_cast<float>(number), 1}, {0, 0, 0.5f}, {0.2f, 0, 0}, number);
  }
  d.materials[0].reflectance.value = {0.8f, 0.4f, 0.2f};
  d.geometry.colors.assign(d.geometry.positions.size(), {{0.25f, 0.75f, 0.5f}, 1});
  return d;
}

TEST(BakedVertices, ShowTheRadianceOfEveryMaterial) {
  const BakeStage room(room_of_materials(), {64, 0});
  const Scene& scene = *room.stage.scene;
  const std::vector<RGB> radiance = room.light(by_gathering(1, 4), TexelLight::radiance);
  const std::vector<RGB> tint = room.light(by_gathering(1, 4), TexelLight::tint);
  std::map<std::string, RGB> base;
  const nlohmann::json file =
      json_of(glb_of_scene(scene, room.layout, encode_light(room.layout, tint, {1}), BakeFormat::vertex, {}));
  for (const auto& m : file.at("materials")) {
    const auto c = m.at("pbrMetallicRoughness").at("baseColorFactor").get<std::vector<float>>();
    if (m.contains("name")) base[m.at("name")] = {c.at(0), c.at(1), c.at(2)};
  }
  std::map<std::string, std::size_t> texels;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const std::uint32_t f = room.layout.texels.face[i];
    if (f == kNone) continue;
    const std::string& name = scene.materials()[scene.geometry().material[room.layout.faces[f].triangle]].name;
    if (name.empty()) continue;
    ++texels[name];
    const RGB shown = base.at(name) * tint[i] * kInversePi;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], radiance[i][c], 1e-3f * radiance[i][c] + 1e-6f) << name;
  }
  EXPECT_EQ(texels.size(), 5u);
}

TEST(BakedMaterials, GlowOnTheSideThatEmits) {
  const BakeStage room(room_with_panel({0.02f, 0.03f, 0.01f}, true), {64, 0});
  std::size_t sides = 0;
  for (const BakeFace& face : room.layout.faces) sides += room.stage.scene->geometry().material[face.triangle] == 1;
  ASSERT_EQ(sides, 4u) << "two triangles from both sides";
  const EncodedLight even = encode_light(room.layout, std::vector<RGB>(room.layout.texels.face.size(), RGB(0.5f)), {1});
  std::size_t glowing = 0, panels = 0;
  const nlohmann::json file = json_of(glb_of_scene(*room.stage.scene, room.layout, even, BakeFormat::lightmap, {}));
  for (const auto& m : file.at("materials")) {
    if (m.at("pbrMetallicRoughness").at("baseColorFactor").at(1) != 0.25f) continue;
    ++panels;
    glowing += m.contains("emissiveFactor");
  }
  EXPECT_EQ(panels, 2u);
  EXPECT_EQ(glowing, 1u);
}

TEST(BakedVertices, HaveTheLightOfTheirPlaces) {
  const BakeStage cornell(builtin_scene("cornell"), {256, 0});
  const auto level = [](Vec3 p) { return 0.2f + 0.3f * p.x + 0.2f * p.y; };
  std::vector<RGB> light(cornell.layout.texels.face.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    if (cornell.grid->has(i)) light[i] = RGB(level(cornell.grid->position[i]));
  std::vector<std::uint8_t> known(light.size());
  for (std::size_t i = 0; i < light.size(); ++i) known[i] = cornell.grid->has(i);
  fill_gaps(cornell.layout.texels, known, light);
  const std::string glb = glb_of_scene(*cornell.stage.scene, cornell.layout, encode_light(cornell.layout, light, {1}),
                                       BakeFormat::vertex, {});
  std::uint32_t json_size = 0;
  std::memcpy(&json_size, glb.data() + 12, sizeof json_size);
  const nlohmann::json json = json_of(glb);
  const auto vectors = [&](const nlohmann::json& accessor) {
    const nlohmann::json& a = json.at("accessors").at(accessor.get<std::size_t>());
    std::vector<Vec3> out(a.at("count").get<std::size_t>());
    const auto offset =
        json.at("bufferViews").at(a.at("bufferView").get<std::size_t>()).at("byteOffset").get<std::size_t>();
    std::memcpy(out.data(), glb.data() + 28 + json_size + offset, out.size() * sizeof(Vec3));
    return out;
  };
  std::size_t vertices = 0;
  for (const auto& mesh : json.at("meshes"))
    for (const auto& primitive : mesh.at("primitives")) {
      const auto& attributes = primitive.at("attributes");
      EXPECT_FALSE(attributes.contains("TEXCOORD_0")) << "no texture is read there";
      const bool lamp = !attributes.contains("COLOR_0");
      EXPECT_EQ(lamp, mesh.at("name") == "lamp");
      if (lamp) continue;
      const std::vector<Vec3> places = vectors(attributes.at("POSITION")), colors = vectors(attributes.at("COLOR_0"));
      ASSERT_EQ(places.size(), colors.size());
      for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(colors[i].y, level(places[i]), 0.01f) << places[i].x;
      vertices += places.size();
    }
  EXPECT_GT(vertices, 50u);
}

/// The scene of a GLB file, as a bake reads it.
SceneDescription scene_of_glb(const std::string& glb) {
  const TemporaryFolder folder;
  ImportOptions options;
  options.light_uvs = true;
  return load_scene(folder.write("lit.glb", glb), options);
}

TEST(BakedMaterials, GiveBackWhatLampsEmit) {
  const BakeStage room(room_with_panel({0.02f, 0.03f, 0.01f}, true), {64, 0});
  const EncodedLight even = encode_light(room.layout, std::vector<RGB>(room.layout.texels.face.size(), RGB(0.5f)), {1});
  BakeNotes notes;
  notes.exposure = 3;
  const SceneDescription again =
      scene_of_glb(glb_of_scene(*room.stage.scene, room.layout, even, BakeFormat::lightmap, notes));
  const std::vector<Emission>& lamps = room.stage.scene->emissions();
  EXPECT_EQ(again.emissions.size(), lamps.size());
  for (const Emission& lamp : lamps)
    EXPECT_TRUE(std::any_of(again.emissions.begin(), again.emissions.end(), [&](const Emission& e) {
      return std::abs(luminance(e.radiance.value) / luminance(lamp.radiance.value) - 1) < 1e-5f;
    })) << luminance(lamp.radiance.value);
}

TEST(BakedVertices, LieInTheCoordinatesOfTheFile) {
  SceneDescription d = builtin_scene("cornell");
  translate(d, kFarAway);
  const BakeStage far(d, {64, 0});
  const std::vector<RGB> light(far.layout.texels.face.size(), RGB(1.0f));
  const Scene read(scene_of_glb(
      glb_of_scene(*far.stage.scene, far.layout, encode_light(far.layout, light, {1}), BakeFormat::vertex, {})));
  EXPECT_EQ(narrow(read.outside(read.bounds().min)), d.geometry.bounds().min);
  EXPECT_EQ(narrow(read.outside(read.bounds().max)), d.geometry.bounds().max);
  EXPECT_EQ(narrow(read.outside(read.cameras()[0].to_world.translation)), d.cameras[0].to_world.translation);
}

TEST(BakedMaterials, AreAsTransparentAsTheirSources) {
  SceneDescription d = two_rooms();
  d.materials.resize(4);
  d.materials[1].name = "veil";
  d.materials[1].alpha.value = 0.5f;
  d.materials[2].name = "net";
  d.materials[2].alpha.value = 0.75f;
  d.materials[2].alpha_cutoff = 0.25f;
  d.materials[3].name = "shade";
  d.materials[3].alpha.value = 0.5f;
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0}, 1);
  add_quad(d, {1, 0.5f, 0.5f}, {0, 1, 0}, {0.5f, 0, 0}, 2);
  add_quad(d, {1, 0.5f, 1.5f}, {0, 1, 0}, {0.5f, 0, 0}, 3, add_emission(d, RGB(20.0f)));
  const BakeStage rooms(std::move(d), {64, 0});
  const EncodedLight even =
      encode_light(rooms.layout, std::vector<RGB>(rooms.layout.texels.face.size(), RGB(0.5f)), {1});
  for (const BakeFormat format : {BakeFormat::emissive, BakeFormat::unlit, BakeFormat::lightmap, BakeFormat::vertex}) {
    const SceneDescription read = scene_of_glb(glb_of_scene(*rooms.stage.scene, rooms.layout, even, format, {}));
    std::size_t veils = 0, nets = 0, shades = 0;
    for (const Material& m : read.materials) {
      veils += m.name == "veil";
      nets += m.name == "net";
      shades += m.name == "shade";
      EXPECT_EQ(m.alpha.value, m.name == "veil" || m.name == "shade" ? 0.5f : m.name == "net" ? 0.75f : 1.0f) << m.name;
      EXPECT_EQ(m.alpha_cutoff, m.name == "net" ? 0.25f : -1.0f) << m.name;
    }
    EXPECT_GT(veils, 0u);
    EXPECT_GT(nets, 0u);
    EXPECT_GT(shades, 0u);
  }
}

/// The mean picture of a view of the scene, and of its bake as read from the file.
class BakedFile : public testing::TestWithParam<BakeFormat> {};

TEST_P(BakedFile, ShowsTheSceneAsItIs) {
  const BakeStage cornell(builtin_scene("cornell"), {128, 0});
  const TexelLight what = GetParam() == BakeFormat::lightmap ? TexelLight::irradiance : TexelLight::radiance;
  const std::vector<RGB> light = cornell.light(by_gathering(4, 32), what);
  const float scale = GetParam() == BakeFormat::unlit ? 1.0f : 0.0f;
  const std::string glb =
      glb_of_scene(*cornell.stage.scene, cornell.layout, encode_light(cornell.layout, light, {scale}), GetParam(), {});
  const Stage baked(scene_of_glb(glb));
  EXPECT_EQ(baked.scene->geometry().triangle_count(), cornell.stage.scene->geometry().triangle_count());
  EXPECT_EQ(baked.scene->camera("").name, "main");
  if (GetParam() == BakeFormat::lightmap) {
    // A lightmap is no light to us. A bake of the file uses its texture coordinates.
    const BakeLayout again = lay_out(baked.scene, baked.tracer, {64, 0});
    EXPECT_LT(again.charts.size(), baked.scene->geometry().objects.size());
    EXPECT_THAT(again.notes, testing::IsEmpty());
    return;
  }
  const std::vector<RGB> shown = pixels(baked.render(by_path(48, 64)));
  const std::vector<RGB> seen = pixels(cornell.stage.render(by_path(48, 512)));
  // A base colour ends at 1, below the lamp's radiance.
  const float most = GetParam() == BakeFormat::unlit ? 0.4f : 1e9f;
  std::vector<RGB> shown_below, seen_below;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (max_component(seen[i]) < most) {
      shown_below.push_back(shown[i]);
      seen_below.push_back(seen[i]);
    }
  EXPECT_GT(seen_below.size(), seen.size() * 9 / 10);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(mean(shown_below).value[c], mean(seen_below).value[c], 0.01 * mean(seen_below).value[c]);
}

INSTANTIATE_TEST_SUITE_P(Formats, BakedFile,
                         testing::Values(BakeFormat::emissive, BakeFormat::unlit, BakeFormat::lightmap));

}  // namespace
}  // namespace glowworm
