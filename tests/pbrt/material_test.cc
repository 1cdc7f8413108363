#include <gtest/gtest.h>

#include <cmath>

#include "pbrt/pbrt_testing.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::expect_near;
using pbrt_testing::has_note;
using pbrt_testing::kTriangle;
using pbrt_testing::load_text;

/// The material that a triangle gets after `directives`.
Material material(const std::string& directives) {
  const SceneDescription scene = load_text("WorldBegin\n" + directives + "\n" + kTriangle);
  return scene.materials.at(scene.geometry.material.at(0));
}

TEST(PbrtMaterial, DefaultIsGreyDiffuse) {
  EXPECT_EQ(material("").kind, MaterialKind::diffuse);
  expect_near(material("").reflectance.value, RGB(0.5f));
  expect_near(material("Material \"diffuse\"").reflectance.value, RGB(0.5f));
}

TEST(PbrtMaterial, Diffuse) {
  const Material m = material("Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]");
  EXPECT_EQ(m.kind, MaterialKind::diffuse);
  expect_near(m.reflectance.value, {0.1f, 0.2f, 0.3f});
  expect_near(material("Material \"diffuse\" \"spectrum reflectance\" [300 .5 900 .5]").reflectance.value, RGB(0.5f));
  expect_near(material("Material \"diffuse\" \"rgb reflectance\" [2 -1 .5]").reflectance.value, {1, 0, 0.5f});
}

TEST(PbrtMaterial, RoughnessIsRemappedAsInVersion4) {
  const Material plain = material("Material \"conductor\" \"float roughness\" .04");
  EXPECT_FLOAT_EQ(plain.roughness_u.value, 0.2f);
  EXPECT_FLOAT_EQ(plain.roughness_v.value, 0.2f);
  const Material raw = material("Material \"conductor\" \"float roughness\" .04 \"bool remaproughness\" false");
  EXPECT_FLOAT_EQ(raw.roughness_u.value, 0.04f);
  const Material uv = material("Material \"dielectric\" \"float uroughness\" .25 \"float vroughness\" .01");
  EXPECT_FLOAT_EQ(uv.roughness_u.value, 0.5f);
  EXPECT_FLOAT_EQ(uv.roughness_v.value, 0.1f);
}

TEST(PbrtMaterial, RoughnessIsRemappedAsInVersion3) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin Material \"metal\" \"float roughness\" .1\n") + kTriangle + "WorldEnd");
  const float x = std::log(0.1f);
  EXPECT_NEAR(scene.materials.at(scene.geometry.material.at(0)).roughness_u.value,
              1.62142 + 0.819955 * x + 0.1734 * x * x + 0.0171201 * x * x * x + 0.000640711 * x * x * x * x, 1e-5);
}

TEST(PbrtMaterial, Conductors) {
  const Material copper = material("Material \"conductor\"");
  EXPECT_EQ(copper.kind, MaterialKind::conductor);
  EXPECT_FALSE(copper.use_reflectance);
  EXPECT_GT(copper.k.r, copper.k.b);  // reddish
  const Material given = material("Material \"conductor\" \"rgb eta\" [1 2 3] \"rgb k\" [4 5 6]");
  expect_near(given.eta, {1, 2, 3});
  expect_near(given.k, {4, 5, 6});
  const Material silver =
      material("Material \"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\"");
  EXPECT_LT(silver.eta.g, 0.2f);
  EXPECT_NEAR(silver.k.g, 3.4f, 0.3f);
  const Material inline_samples =
      material("Material \"conductor\" \"spectrum eta\" [300 1.5 900 1.5] \"spectrum k\" [300 4 900 4]");
  expect_near(inline_samples.eta, RGB(1.5f));
  expect_near(inline_samples.k, RGB(4.0f), 1e-4f);
  const Material reflecting = material("Material \"conductor\" \"rgb reflectance\" [.5 .5 .5]");
  expect_near(reflecting.eta, RGB(1.0f));
  expect_near(reflecting.k, RGB(2.0f));
}

TEST(PbrtMaterial, ConductorFromFiles) {
  const TemporaryFolder folder;
  folder.write("spds/x.eta.spd", "300 1.5 900 1.5");
  folder.write("spds/x.k.spd", "300 4 900 4");
  const SceneDescription scene = load_scene(folder.write(
      "s.pbrt", std::string("WorldBegin Material \"conductor\" \"spectrum eta\" \"spds/x.eta.spd\" \"spectrum k\" "
                            "\"spds/x.k.spd\"\n") +
                    kTriangle));
  expect_near(scene.materials.at(scene.geometry.material.at(0)).k, RGB(4.0f), 1e-4f);
}

TEST(PbrtMaterial, Dielectrics) {
  const Material glass = material("Material \"dielectric\"");
  EXPECT_EQ(glass.kind, MaterialKind::dielectric);
  EXPECT_EQ(glass.ior, 1.5f);
  EXPECT_EQ(glass.roughness_u.value, 0);
  expect_near(glass.reflectance.value, RGB(1.0f));
  expect_near(glass.transmittance.value, RGB(1.0f));
  EXPECT_FLOAT_EQ(material("Material \"dielectric\" \"float eta\" 1.33").ior, 1.33f);
  EXPECT_FLOAT_EQ(material("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").ior, 1.5168f);
  EXPECT_FLOAT_EQ(material("Material \"dielectric\" \"spectrum eta\" [300 1.7 900 1.7]").ior, 1.7f);
  const Material pane = material("Material \"thindielectric\" \"float eta\" 1.4");
  EXPECT_EQ(pane.kind, MaterialKind::thin_dielectric);
  EXPECT_FLOAT_EQ(pane.ior, 1.4f);
}

TEST(PbrtMaterial, Coats) {
  const Material diffuse = material(
      "Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float roughness\" .25 \"float eta\" 1.3 "
      "\"float thickness\" .5 \"integer maxdepth\" 5");
  EXPECT_EQ(diffuse.kind, MaterialKind::coated_diffuse);
  expect_near(diffuse.reflectance.value, {0.1f, 0.2f, 0.3f});
  EXPECT_FLOAT_EQ(diffuse.roughness_u.value, 0.5f);
  EXPECT_FLOAT_EQ(diffuse.ior, 1.3f);
  EXPECT_FLOAT_EQ(diffuse.coat_thickness, 0.5f);
  EXPECT_EQ(diffuse.coat_bounces, 3);
  const Material conductor = material(
      "Material \"coatedconductor\" \"rgb conductor.eta\" [1 1 1] \"rgb conductor.k\" [3 3 3] "
      "\"float conductor.roughness\" .04 \"float interface.roughness\" .01 \"float interface.eta\" 1.6");
  EXPECT_EQ(conductor.kind, MaterialKind::coated_conductor);
  expect_near(conductor.k, RGB(3.0f));
  EXPECT_FLOAT_EQ(conductor.roughness_u.value, 0.2f);
  EXPECT_FLOAT_EQ(conductor.coat_roughness.value, 0.1f);
  EXPECT_EQ(conductor.coat_bounces, 5);
  EXPECT_FLOAT_EQ(conductor.ior, 1.6f);
}

TEST(PbrtMaterial, DiffuseTransmission) {
  const Material m = material(
      "Material \"diffusetransmission\" \"rgb reflectance\" [.2 .2 .2] \"rgb transmittance\" [.4 .4 .4] \"float "
      "scale\" .5");
  EXPECT_EQ(m.kind, MaterialKind::diffuse);
  expect_near(m.reflectance.value, RGB(0.1f));
  expect_near(m.transmittance.value, RGB(0.2f));
}

TEST(PbrtMaterial, NamesMayBeDefinedLater) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin NamedMaterial \"m\"\n") + kTriangle +
                "MakeNamedMaterial \"m\" \"string type\" \"diffuse\" \"rgb reflectance\" [.1 .2 .3]\n");
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  EXPECT_EQ(m.name, "m");
  expect_near(m.reflectance.value, {0.1f, 0.2f, 0.3f});
}

TEST(PbrtMaterial, Mix) {
  const SceneDescription scene = load_text(
      std::string(
          "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" "
          "\"string type\" \"conductor\" Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25\n") +
      kTriangle);
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  ASSERT_EQ(m.kind, MaterialKind::mix);
  EXPECT_EQ(scene.materials.at(m.mix_a).name, "a");
  EXPECT_EQ(scene.materials.at(m.mix_b).name, "b");
  EXPECT_EQ(m.mix_amount.value, 0.25f);
}

TEST(PbrtMaterial, MetallicRoughness) {
  const Material m = material(
      "Material \"metallicroughness\" \"rgb reflectance\" [.1 .2 .3] \"float metallic\" .25 \"float roughness\" .5 "
      "\"float eta\" 1.4 \"float specular\" .75 \"rgb specularcolor\" [1 .5 .5] \"float transmission\" .2 "
      "\"bool thin\" true \"float clearcoat\" .6 \"float clearcoatroughness\" .1 \"rgb sheen\" [.2 .2 .2] "
      "\"float sheenroughness\" .3 \"float anisotropy\" .4 \"float anisotropyrotation\" 90");
  EXPECT_EQ(m.kind, MaterialKind::metallic_roughness);
  expect_near(m.reflectance.value, {0.1f, 0.2f, 0.3f});
  EXPECT_FLOAT_EQ(m.metallic.value, 0.25f);
  EXPECT_FLOAT_EQ(m.roughness_u.value, 0.25f);  // GGX's alpha is the square of the roughness
  EXPECT_FLOAT_EQ(m.roughness_v.value, 0.25f);
  EXPECT_FLOAT_EQ(m.ior, 1.4f);
  EXPECT_FLOAT_EQ(m.specular.value, 0.75f);
  expect_near(m.specular_color.value, {1, 0.5f, 0.5f});
  EXPECT_FLOAT_EQ(m.transmission.value, 0.2f);
  EXPECT_TRUE(m.thin);
  EXPECT_FLOAT_EQ(m.clearcoat.value, 0.6f);
  EXPECT_FLOAT_EQ(m.coat_roughness.value, 0.01f);
  expect_near(m.sheen.value, RGB(0.2f));
  EXPECT_FLOAT_EQ(m.sheen_roughness.value, 0.3f);
  EXPECT_FLOAT_EQ(m.anisotropy.value, 0.4f);
  EXPECT_FLOAT_EQ(m.anisotropy_rotation, kPi / 2);
}

TEST(PbrtMaterial, ARoughnessTextureOfMetallicRoughnessIsSquared) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin Texture \"r\" \"float\" \"checkerboard\" \"float tex1\" .5 \"float tex2\" .5\n"
                            "Material \"metallicroughness\" \"texture roughness\" \"r\"\n") +
                kTriangle);
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  EXPECT_FLOAT_EQ(evaluate(scene.textures, m.roughness_u, {0.3f, 0.3f}), 0.25f);
}

TEST(PbrtMaterial, Textures) {
  const SceneDescription scene = load_text(
      std::string("WorldBegin Texture \"k\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]\n"
                  "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"k\" \"float scale\" 2\n"
                  "Texture \"c\" \"spectrum\" \"checkerboard\" \"texture tex1\" \"s\" \"rgb tex2\" [0 0 1] "
                  "\"float uscale\" 4 \"float vscale\" 2 \"float udelta\" 1\n"
                  "Texture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"c\" \"rgb tex2\" [1 1 1] \"float amount\" .5\n"
                  "Material \"diffuse\" \"texture reflectance\" \"m\"\n") +
      kTriangle);
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  ASSERT_NE(m.reflectance.texture, kNone);
  // (0.05, 0.1): at (1.2, 0.2) of the board, an odd cell; (0.3, 0.1): at (2.2, 0.2), an even one.
  expect_near(evaluate(scene.textures, m.reflectance, {0.05f, 0.1f}), {0.5f, 0.5f, 1});
  expect_near(evaluate(scene.textures, m.reflectance, {0.3f, 0.1f}), {0.6f, 0.7f, 0.8f});
}

TEST(PbrtMaterial, ColourTexturesAreScaledByFloatTexturesOrColours) {
  for (const char* factor :
       {"\"float\" \"constant\" \"float value\" .5", "\"spectrum\" \"constant\" \"rgb value\" [.5 .5 .5]"}) {
    const Material m = material(std::string("Texture \"f\" ") + factor +
                                " Texture \"k\" \"spectrum\" \"scale\" \"rgb tex\" [.2 .4 .6] \"texture scale\" \"f\" "
                                "Material \"diffuse\" \"texture reflectance\" \"k\"");
    expect_near(m.reflectance.value, {0.1f, 0.2f, 0.3f});
  }
}

TEST(PbrtMaterial, ConstantTexturesNeedNoNode) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin Texture \"k\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]\n"
                            "Texture \"r\" \"float\" \"constant\" \"float value\" .04\n"
                            "Material \"coateddiffuse\" \"texture reflectance\" \"k\" \"texture roughness\" \"r\"\n") +
                kTriangle);
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  expect_near(m.reflectance.value, {0.1f, 0.2f, 0.3f});
  EXPECT_EQ(m.reflectance.texture, kNone);
  EXPECT_FLOAT_EQ(m.roughness_u.value, 0.2f);
  EXPECT_TRUE(scene.textures.empty());
}

TEST(PbrtMaterial, ImageTextures) {
  const TemporaryFolder folder;
  // Two pixels: sRGB 188 is 0.5 linear, to a part in 256.
  folder.write("tex/a.tga", pbrt_testing::tga_row(2, std::string_view("\xbc\xbc\xbc\x00\x00\xff", 6)));
  const auto load = [&](const std::string& parameters) {
    return load_scene(folder.write("s.pbrt",
                                   "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" "
                                   "\"tex/a.tga\" " +
                                       parameters + " Material \"diffuse\" \"texture reflectance\" \"t\"\n" +
                                       kTriangle));
  };
  const auto at = [](const SceneDescription& scene, Vec2 uv) {
    return evaluate(scene.textures, scene.materials.at(scene.geometry.material.at(0)).reflectance, uv);
  };
  const SceneDescription plain = load("");
  expect_near(at(plain, {0.25f, 0.5f}), RGB(0.5f), 3e-3f);
  expect_near(at(plain, {0.75f, 0.5f}), {1, 0, 0}, 1e-3f);
  expect_near(at(plain, {1.25f, 0.5f}), RGB(0.5f), 3e-3f);
  expect_near(at(load("\"string encoding\" \"linear\""), {0.25f, 0.5f}), RGB(188 / 255.0f), 1e-3f);
  expect_near(at(load("\"string encoding\" \"gamma 2\""), {0.25f, 0.5f}), RGB(0.5436f), 2e-3f);
  expect_near(at(load("\"bool invert\" true \"float scale\" .5"), {0.75f, 0.5f}), {0.5f, 1, 1}, 1e-3f);
  expect_near(at(load("\"string wrap\" \"clamp\""), {1.25f, 0.5f}), {1, 0, 0}, 1e-3f);
  expect_near(at(load("\"string wrap\" \"black\""), {1.75f, 0.5f}), {0, 0, 0}, 1e-3f);
  expect_near(at(load("\"float uscale\" .5"), {0.5f, 0.5f}), RGB(0.5f), 3e-3f);
  folder.write("s2.pbrt", "");
}

TEST(PbrtMaterial, FloatTexturesOfImagesWithAlphaShowIt) {
  const TemporaryFolder folder;
  folder.write("a.tga", pbrt_testing::tga_row(1, std::string_view("\xff\xff\xff\x33", 4)));  // alpha 0.2
  const auto alpha = [&](const std::string& image_parameters, const std::string& other_texture = "") {
    const SceneDescription scene = load_scene(folder.write(
        "s.pbrt", "WorldBegin Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"a.tga\" " + image_parameters +
                      "\n" + other_texture + " Shape \"disk\" \"texture alpha\" \"t\""));
    return evaluate(scene.textures, scene.materials.at(scene.geometry.material.at(0)).alpha, {0.25f, 0.25f});
  };
  EXPECT_NEAR(alpha(""), 0.2f, 1e-5f);
  EXPECT_NEAR(alpha("\"float scale\" .5"), 0.1f, 1e-5f);
  EXPECT_NEAR(alpha("\"bool invert\" true"), 0.8f, 1e-5f);
  EXPECT_NEAR(alpha("\"bool invert\" true \"float scale\" .5"), 0.9f, 1e-5f);
  EXPECT_EQ(alpha("\"bool invert\" true \"float scale\" 9"), 0);
  const std::string tex1 = " \"texture tex1\" \"t\" \"float tex2\" .5";
  EXPECT_NEAR(alpha("", "Texture \"t\" \"float\" \"scale\"" + tex1), 0.1f, 1e-5f);
  EXPECT_NEAR(alpha("", "Texture \"t\" \"float\" \"mix\"" + tex1), 0.35f, 1e-5f);
  EXPECT_NEAR(alpha("", "Texture \"t\" \"float\" \"checkerboard\"" + tex1), 0.2f, 1e-5f);
}

TEST(PbrtMaterial, FloatTexturesOfVersion3ShowColoursOfImages) {
  const TemporaryFolder folder;
  folder.write("a.tga", pbrt_testing::tga_row(1, std::string_view("\xff\xff\xff\x33", 4)));  // alpha 0.2
  const SceneDescription scene = load_scene(
      folder.write("s.pbrt",
                   "WorldBegin Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"a.tga\" \"float scale\" .5\n"
                   "Shape \"disk\" \"texture alpha\" \"t\" WorldEnd"));
  EXPECT_NEAR(evaluate(scene.textures, scene.materials.at(scene.geometry.material.at(0)).alpha, {0.25f, 0.25f}), 0.5f,
              1e-5f);
}

TEST(PbrtMaterial, MissingDataTexturesChangeNothing) {
  const auto d = load_text(
      "WorldBegin Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"gone.png\" \"float scale\" 0.25\n"
      "AreaLightSource \"diffuse\" \"string filename\" \"gone.png\"\n"
      "Material \"conductor\" \"texture roughness\" \"t\" \"bool remaproughness\" false \"string normalmap\" "
      "\"gone.png\"\nShape \"sphere\"\n");
  const Material& m = d.materials.at(d.geometry.material.at(0));
  EXPECT_EQ(evaluate(d.textures, m.roughness_u, {0.5f, 0.5f}), 0.25f);
  EXPECT_EQ(evaluate(d.textures, m.normal_map, {0.5f, 0.5f}), RGB(0.5f, 0.5f, 1));
  EXPECT_EQ(evaluate(d.textures, d.emissions.at(0).radiance, {0.5f, 0.5f}), RGB(0.0f));
  std::string notes;
  for (const std::string& note : d.notes) notes += note;
  EXPECT_NE(notes.find("gone.png' is left out: "), std::string::npos) << notes;
}

TEST(PbrtMaterial, AMissingImageIsMagentaAndNoted) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"gone.png\"\n"
                            "Material \"diffuse\" \"texture reflectance\" \"t\"\n") +
                kTriangle);
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  const RGB color = evaluate(scene.textures, m.reflectance, {0.5f, 0.5f});
  EXPECT_GT(color.r, 0.5f);
  EXPECT_EQ(color.g, 0);
  bool noted = false;
  for (const std::string& note : scene.notes) noted = noted || note.find("gone.png") != std::string::npos;
  EXPECT_TRUE(noted);
}

TEST(PbrtMaterial, AlphaBelongsToTheShape) {
  const SceneDescription scene = load_text(
      std::string(
          "WorldBegin Texture \"a\" \"float\" \"checkerboard\"\nMaterial \"diffuse\" \"rgb reflectance\" [1 0 0]\n") +
      kTriangle +
      "Shape \"disk\" \"texture alpha\" \"a\" Shape \"disk\" \"float alpha\" .5 Shape \"sphere\" \"float alpha\" .5");
  const auto& of = scene.geometry.material;
  const Material& plain = scene.materials.at(of.front());
  EXPECT_EQ(plain.alpha.value, 1);
  const Material& textured = scene.materials.at(of.at(1));
  EXPECT_NE(textured.alpha.texture, kNone);
  EXPECT_EQ(textured.reflectance.value.r, 1);
  EXPECT_EQ(scene.materials.at(of.back()).alpha.value, 0.5f);
  EXPECT_EQ(of.back(), of.at(1 + 128));  // shapes of the same alpha share a material
}

TEST(PbrtMaterial, ShapesMayBeHiddenFromCameras) {
  const SceneDescription scene =
      load_text(std::string("WorldBegin Material \"diffuse\" \"rgb reflectance\" [1 0 0]\n") + kTriangle +
                "Shape \"disk\" \"bool seenbycameras\" false");
  EXPECT_TRUE(scene.notes.empty());
  const auto& of = scene.geometry.material;
  EXPECT_FALSE(scene.materials.at(of.front()).unseen);
  EXPECT_TRUE(scene.materials.at(of.back()).unseen);
  EXPECT_EQ(scene.materials.at(of.back()).reflectance.value.r, 1);
}

TEST(PbrtMaterial, BumpAndNormalMaps) {
  const TemporaryFolder folder;
  folder.write("n.tga", pbrt_testing::tga_row(1, "\xff\x80\x80"));
  const SceneDescription scene = load_scene(folder.write(
      "s.pbrt", std::string("WorldBegin Texture \"d\" \"float\" \"checkerboard\" \"float tex1\" .1\n"
                            "Material \"diffuse\" \"texture displacement\" \"d\" \"string normalmap\" \"n.tga\"\n") +
                    kTriangle));
  const Material& m = scene.materials.at(scene.geometry.material.at(0));
  ASSERT_NE(m.bump.texture, kNone);
  EXPECT_NEAR(evaluate(scene.textures, m.bump, {0.5f, 0.5f}), 0.1f, 1e-6);
  ASSERT_NE(m.normal_map.texture, kNone);
  // Linear: no sRGB curve over normals.
  expect_near(evaluate(scene.textures, m.normal_map, {0.5f, 0.5f}), {128 / 255.0f, 128 / 255.0f, 1}, 1e-3f);
}

TEST(PbrtMaterial, Version3Names) {
  expect_near(material("Material \"matte\" \"rgb Kd\" [.1 .2 .3]").reflectance.value, {0.1f, 0.2f, 0.3f});
  EXPECT_FLOAT_EQ(material("Material \"glass\" \"float index\" 1.3").ior, 1.3f);
  EXPECT_FLOAT_EQ(material("Material \"glass\" \"float eta\" 1.4").ior, 1.4f);
  const Material mirror = material("Material \"mirror\" \"rgb Kr\" [.8 .8 .8]");
  EXPECT_EQ(mirror.kind, MaterialKind::conductor);
  EXPECT_TRUE(mirror.use_reflectance);
  expect_near(mirror.reflectance.value, RGB(0.8f));
  EXPECT_EQ(material("Material \"metal\"").kind, MaterialKind::conductor);
  const Material plastic = material("Material \"plastic\" \"color Kd\" [.1 .1 .1] \"float roughness\" .04");
  EXPECT_EQ(plastic.kind, MaterialKind::coated_diffuse);
  expect_near(plastic.reflectance.value, RGB(0.1f));
  const Material bumped =
      material("Texture \"d\" \"float\" \"checkerboard\" Material \"matte\" \"texture bumpmap\" \"d\"");
  EXPECT_NE(bumped.bump.texture, kNone);
  expect_near(
      material(
          "Texture \"k\" \"color\" \"constant\" \"color value\" [.1 .2 .3] Material \"matte\" \"texture Kd\" \"k\"")
          .reflectance.value,
      {0.1f, 0.2f, 0.3f});
}

TEST(PbrtMaterial, NamesOfVersion3EndWithTheirBlock) {
  const auto named = [](const std::string& name, const std::string& value) {
    return "MakeNamedMaterial \"" + name + "\" \"string type\" \"matte\" \"rgb Kd\" [" + value + "]\n";
  };
  const auto texture = [](const std::string& value) {
    return "Texture \"t\" \"color\" \"constant\" \"rgb value\" [" + value + "]\n";
  };
  const std::string red = "1 0 0", green = "0 1 0", blue = "0 0 1";
  const std::string outer = "WorldBegin\n" + named("m", red) + texture(red);
  const std::string inner = named("m", blue) + "TransformBegin\n" + named("m", green) + texture(green) +
                            "TransformEnd\n" + named("only", green) + "NamedMaterial \"m\"\n" + kTriangle;
  const std::string after = std::string("NamedMaterial \"m\"\n") + kTriangle +
                            "Material \"matte\" \"texture Kd\" \"t\"\n" + kTriangle + "NamedMaterial \"only\"\n" +
                            kTriangle;
  const auto color = [](const SceneDescription& scene, std::size_t triangle) {
    return scene.materials.at(scene.geometry.material.at(triangle)).reflectance.value;
  };
  const SceneDescription v3 = load_text(outer + "AttributeBegin\n" + inner + "AttributeEnd\n" + after + "WorldEnd\n");
  for (const std::size_t triangle : {0, 3}) expect_near(color(v3, triangle), {0, 1, 0});
  for (const std::size_t triangle : {1, 2}) expect_near(color(v3, triangle), {1, 0, 0});
  const SceneDescription object =
      load_text(outer + "ObjectBegin \"o\"\n" + inner + "ObjectEnd\n" + after + "WorldEnd\n");
  for (const std::size_t triangle : {0, 1}) expect_near(color(object, triangle), {1, 0, 0});
  // In pbrt-v4, names last until the end of the file.
  const SceneDescription v4 = load_text(outer + "AttributeBegin\n" + inner + "AttributeEnd\n" + after);
  for (std::size_t triangle = 0; triangle < 2; ++triangle) expect_near(color(v4, triangle), {0, 1, 0});
}

TEST(PbrtMaterial, Version3MixesByTheMeanOfAColourTexture) {
  const std::string mix =
      "MakeNamedMaterial \"a\" \"string type\" \"matte\" Material \"mix\" \"string namedmaterial1\" \"a\" "
      "\"string namedmaterial2\" \"a\" \"texture amount\" \"t\"";
  const Material m = material("Texture \"t\" \"color\" \"constant\" \"color value\" [.1 .2 .6] " + mix);
  EXPECT_NEAR(m.mix_amount.value, 0.3f, 1e-6f);
  EXPECT_FLOAT_EQ(material("Texture \"t\" \"float\" \"constant\" \"float value\" .4 " + mix).mix_amount.value, 0.4f);
  EXPECT_NE(material("Texture \"t\" \"color\" \"checkerboard\" " + mix).mix_amount.texture, kNone);
}

TEST(PbrtMaterial, SigmaMayBeATexture) {
  const std::string matte = " Material \"matte\" \"texture sigma\" \"s\"";
  const auto noted = [&](const std::string& value) {
    return has_note(load_text("WorldBegin Texture \"s\" \"float\" \"constant\" \"float value\" " + value + matte),
                    "not supported, read as 0: sigma of a diffuse material");
  };
  EXPECT_TRUE(noted("20"));
  EXPECT_FALSE(noted("0"));
}

TEST(PbrtMaterial, OpacityOfUberIsItsAlpha) {
  const std::string grey = "Material \"uber\" \"rgb opacity\" [.1 .2 .6] ";
  EXPECT_NEAR(material(grey).alpha.value, 0.3f, 1e-6f);
  const SceneDescription both = load_text("WorldBegin " + grey + "Shape \"disk\" \"float alpha\" .5");
  EXPECT_NEAR(both.materials.at(both.geometry.material.at(0)).alpha.value, 0.15f, 1e-6f);
  const std::string board =
      "WorldBegin Texture \"t\" \"color\" \"checkerboard\" Material \"uber\" \"texture opacity\" \"t\" ";
  const SceneDescription mask = load_text(board + kTriangle);
  EXPECT_NE(mask.materials.at(mask.geometry.material.at(0)).alpha.texture, kNone);
  // The mesh has no coordinates of its own.
  EXPECT_EQ(mask.geometry.uvs.at(mask.geometry.triangles.at(0)[1]).x, 1);
  const SceneDescription twice = load_text(
      "WorldBegin Texture \"a\" \"float\" \"checkerboard\" \"float tex1\" .5 \"float tex2\" .5 Texture \"t\" \"color\" "
      "\"checkerboard\" \"rgb tex1\" [.4 .4 .4] \"rgb tex2\" [.4 .4 .4] Material \"uber\" \"texture opacity\" \"t\" "
      "Shape \"disk\" \"texture alpha\" \"a\"");
  const FloatInput alpha = twice.materials.at(twice.geometry.material.at(0)).alpha;
  EXPECT_NEAR(evaluate(twice.textures, alpha, {0.3f, 0.3f}), 0.2f, 1e-6f);
}

TEST(PbrtMaterial, Version3Coats) {
  expect_near(material("Material \"substrate\"").reflectance.value, RGB(0.5f));
  expect_near(material("Material \"uber\"").reflectance.value, RGB(0.25f));
  EXPECT_FLOAT_EQ(material("Material \"uber\" \"float index\" 1.3").ior, 1.3f);
  EXPECT_FLOAT_EQ(material("Material \"uber\" \"float index\" 1.3 \"float eta\" 1.4").ior, 1.4f);
  const char* note = "not supported, read as 0: Kr and Kt of an uber material";
  EXPECT_TRUE(has_note(load_text("WorldBegin Material \"uber\" \"rgb Kt\" [.5 .5 .5]"), note));
  EXPECT_FALSE(has_note(load_text("WorldBegin Material \"uber\" \"rgb Kt\" [0 0 0]"), note));
}

TEST(PbrtMaterial, UnsupportedKindsAreReplacedAndNoted) {
  const SceneDescription scene = load_text(
      std::string("WorldBegin Material \"subsurface\" \"rgb reflectance\" [.3 .4 .5] \"float mfp\" 1\n") + kTriangle);
  EXPECT_TRUE(has_note(scene, "not supported, replaced by a diffuse one: material \"subsurface\" ("));
  EXPECT_EQ(scene.notes.size(), 1u);
  expect_near(scene.materials.at(scene.geometry.material.at(0)).reflectance.value, {0.3f, 0.4f, 0.5f});
  const SceneDescription texture = load_text("WorldBegin Texture \"t\" \"float\" \"windy\"");
  EXPECT_TRUE(has_note(texture, "not supported, replaced by mid-grey: texture \"windy\""));
}

TEST(PbrtMaterial, ParametersThatNothingReadsAreNoted) {
  const SceneDescription scene = load_text("WorldBegin Material \"diffuse\" \"rgb reflectnce\" [1 0 0]");
  EXPECT_TRUE(has_note(scene, "not used: parameter \"reflectnce\" of material \"diffuse\""));
}

TEST(PbrtMaterial, MistakesAreErrorsWithPlaces) {
  const struct {
    const char *text, *message;
  } kCases[] = {
      {"Material \"difuse\"", "scene.pbrt:1:1: unknown material \"difuse\""},
      {"NamedMaterial \"m\"", "scene.pbrt:1:1: there is no material \"m\""},
      {"MakeNamedMaterial \"m\"", "scene.pbrt:1:1: the material \"m\" has no type"},
      {"Material \"diffuse\" \"texture reflectance\" \"t\"", "scene.pbrt:1:20: there is no spectrum texture \"t\""},
      {"Texture \"t\" \"float\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"t\"",
       "It is of the other type: define it as \"spectrum\"."},
      {"Texture \"t\" \"integer\" \"constant\"", "scene.pbrt:1:1: a texture of type \"integer\""},
      {"Texture \"t\" \"float\" \"imagemap\"", "scene.pbrt:1:1: an imagemap without a file name"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"a\" \"string wrap\" \"zig\"", "wrap \"zig\""},
      {"Material \"mix\"", "scene.pbrt:1:1: a mix needs the names of two materials"},
      {"MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"]",
       "the mix \"m\" contains itself"},
      {"Material \"dielectric\" \"float eta\" 0", "scene.pbrt:1:23: an index of refraction must be positive"},
      {"Material \"dielectric\" \"rgb eta\" [3 -1 3]", "scene.pbrt:1:23: an index of refraction must be positive"},
      {"Material \"dielectric\" \"spectrum eta\" \"no.spd\"",
       "scene.pbrt:1:23: \"no.spd\" is neither a known spectrum nor a readable file"},
      {"Material \"conductor\" \"rgb eta\" [1 -1 1]", "scene.pbrt:1:22: \"eta\" of a conductor is (1, -1, 1)"},
      {"Material \"conductor\" \"rgb k\" [1 -1 1]", "scene.pbrt:1:22: \"k\" of a conductor is (1, -1, 1)"},
      {"Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb eta\" [1 1 1]",
       "scene.pbrt:1:1: a conductor with both reflectance and eta or k"},
      {"Material \"diffuse\" \"spectrum reflectance\" [500 1 400 1]",
       "the wavelengths of \"reflectance\" do not ascend"},
      {"Material \"diffuse\" \"string reflectance\" \"red\"", "expected a colour or spectrum"},
      {"ColorSpace \"prophoto\"", "scene.pbrt:1:1: unknown colour space \"prophoto\""},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_NE(error_of(text).find(message), std::string::npos) << text << "\n" << error_of(text);
  }
}

TEST(PbrtMaterial, ColourSpaces) {
  // Whites are white in all of them; Rec. 2020's pure green is outside of Rec. 709 and gets clamped.
  for (const char* space : {"srgb", "rec2020", "dci-p3", "aces2065-1"}) {
    const std::string text = std::string("ColorSpace \"") + space + "\" Material \"diffuse\" \"rgb reflectance\" ";
    expect_near(material(text + "[.5 .5 .5]").reflectance.value, RGB(0.5f), 2e-4f);
  }
  const Material green = material("ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [0 .5 0]");
  EXPECT_EQ(green.reflectance.value.r, 0);
  EXPECT_NEAR(green.reflectance.value.g, 0.56645f, 1e-4);
}

}  // namespace
}  // namespace glowworm
