// OBJ files with their materials.
#include <algorithm>
#include <cmath>
#include <set>

#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

class ObjTest : public FileTest {
 protected:
  /// A triangle of one material, which the MTL text after "newmtl m" describes.
  SceneDescription with_material(const std::string& mtl) {
    write("m.mtl", "newmtl m\n" + mtl);
    return load_scene(write("m.obj", std::string("mtllib m.mtl\n") + kTriangle + "usemtl m\nf 1 2 3\n"));
  }
  static const Material& material_of(const SceneDescription& d) { return d.materials.at(d.geometry.material.at(0)); }
};

TEST_F(ObjTest, QuadsBecomeTwoTrianglesWoundAsWritten) {
  const auto d = load_scene(write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 2u);
  EXPECT_EQ(d.geometry.positions.size(), 4u);
  for (std::uint32_t t = 0; t < 2; ++t) {
    EXPECT_EQ(d.geometry.normal(t), (Vec3{0, 0, 1}));
    EXPECT_EQ(d.geometry.emission[t], kNone);
  }
  EXPECT_EQ(d.name, "a");
}

TEST_F(ObjTest, NegativeIndicesNormalsAndTextureCoordinates) {
  const auto d = load_scene(write(
      "a.obj", std::string(kTriangle) + "vt 0 0\nvt 1 0\nvt 0.25 0.75\nvn 0 0 2\nf -3/-3/-1 -2/-2/-1 -1/-1/-1\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  const auto [a, b, c] = d.geometry.triangles[0];
  EXPECT_EQ(d.geometry.normals[a], (Vec3{0, 0, 1}));
  EXPECT_EQ(d.geometry.uvs[c].x, 0.25f);
  EXPECT_EQ(d.geometry.uvs[c].y, 0.75f);
}

TEST_F(ObjTest, NormalsDecideWhereTheOutsideIs) {
  const auto d = load_scene(write("a.obj", std::string(kTriangle) + "vn 0 0 -1\nf 1//1 2//1 3//1\n"));
  EXPECT_EQ(d.geometry.normal(0), (Vec3{0, 0, -1}));
  EXPECT_THAT(d.notes, HasNote("wound against its normals"));
}

TEST_F(ObjTest, SmoothingGroupsGiveSmoothNormalsOverFlatEdgesOnly) {
  // Three quads in a row: the first edge bends by 11 degrees, the second by 90.
  const std::string obj =
      "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 2 0 -0.2\nv 2 1 -0.2\nv 2 0 -2\nv 2 1 -2\ns 1\n"
      "f 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n";
  const auto d = load_scene(write("a.obj", obj));
  ASSERT_EQ(d.geometry.triangle_count(), 6u);
  const float bent = 0.2f / std::hypot(1.0f, 0.2f);
  for (std::size_t i = 0; i < d.geometry.positions.size(); ++i) {
    if (d.geometry.positions[i].x != 1) continue;
    EXPECT_GT(d.geometry.normals[i].x, 0.1f * bent);
    EXPECT_LT(d.geometry.normals[i].x, 0.9f * bent);
  }
  for (std::size_t i = 0; i < d.geometry.positions.size(); ++i) {
    if (d.geometry.positions[i].z == -2) {
      EXPECT_GT(d.geometry.normals[i].x, 0.999f);
    }
  }
}

TEST_F(ObjTest, SmoothingGroupsGoOnOverMaterialsAndGroups) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 0 0.2\ns 1\nusemtl a\nf 1 2 3\n";
  const auto shared_normals = [&](const std::string& between) {
    const auto d = load_scene(write("a.obj", vertices + between + "f 2 4 3\n"));
    EXPECT_EQ(d.geometry.triangle_count(), 2u);
    std::vector<Vec3> normals;
    for (const auto& triangle : d.geometry.triangles)
      for (const std::uint32_t i : triangle)
        if (d.geometry.positions[i] == Vec3{1, 1, 0}) normals.push_back(d.geometry.normals[i]);
    EXPECT_EQ(normals.size(), 2u);
    return normals;
  };
  for (const char* between : {"", "usemtl b\n", "g other\n", "g other\nusemtl b\n"}) {
    const auto normals = shared_normals(between);
    EXPECT_EQ(normals[0], normals[1]) << between;
    EXPECT_LT(normals[0].x, -0.05f) << between;
  }
  // An object is smoothed alone.
  const auto normals = shared_normals("o other\n");
  EXPECT_EQ(normals[0].x, 0);
  const auto d = load_scene(write("b.obj", vertices + "g other\nusemtl b\nf 2 4 3\n"));
  EXPECT_NE(d.geometry.material[0], d.geometry.material[1]);
  EXPECT_EQ(d.geometry.objects.back().name, "other");
  EXPECT_EQ(d.geometry.objects.back().first_triangle, 1u);
}

TEST_F(ObjTest, DiffuseAndEmissiveColours) {
  const auto d = with_material("Kd 0.1 0.2 0.3\nKe 17 12 4\n");
  EXPECT_EQ(material_of(d).kind, MaterialKind::diffuse);
  EXPECT_EQ(material_of(d).reflectance.value, RGB(0.1f, 0.2f, 0.3f));
  ASSERT_EQ(d.emissions.size(), 1u);
  ASSERT_EQ(d.geometry.emission[0], 0u);
  EXPECT_EQ(d.emissions[0].radiance.value, RGB(17, 12, 4));
  EXPECT_FALSE(d.emissions[0].two_sided);
}

TEST_F(ObjTest, EmissiveMapsNeedNoColour) {
  write("light.tga", tga_row({{0, 0, 255, 255}}));
  const auto radiance = [&](const std::string& mtl) {
    const auto d = with_material(mtl);
    return d.emissions.empty() ? RGB(0.0f) : evaluate(d.textures, d.emissions[0].radiance, {0.5f, 0.5f});
  };
  EXPECT_EQ(radiance("map_Ke light.tga\n"), RGB(1, 0, 0));
  for (const char* mtl : {"Ke 2 2 2\nmap_Ke light.tga\n", "map_Ke light.tga\nKe 2 2 2\n"}) {
    EXPECT_EQ(radiance(mtl), RGB(2, 0, 0)) << mtl;
  }
  EXPECT_EQ(radiance("Ke 0 0 0\nmap_Ke light.tga\n"), RGB(0.0f));
  EXPECT_EQ(radiance("map_Ke light.tga\nnewmtl n\nmap_Ke light.tga\nKe 3 3 3\nnewmtl m\nmap_Ke light.tga\n"),
            RGB(1, 0, 0));
}

TEST_F(ObjTest, WhatTheExtensionOfMtlAddsIsNoted) {
  write("leaf.tga", tga_row({{0, 0, 255, 255}}));
  const auto d = with_material(
      "Kd 1 1 1\nPc 0.5\nPcr 0\nPs 1\naniso 0\nanisor 0.25\nmap_Pc c.png\nmap_Pcr c.png\nmap_Ps c.png\n"
      "map_Kd -imfchan r leaf.tga\n");
  for (const char* name : {"Pc", "Ps", "anisor", "map_Pc", "map_Pcr", "map_Ps"}) {
    EXPECT_THAT(d.notes, HasNote("MTL '" + std::string(name) + "' is not supported, left out"));
  }
  EXPECT_THAT(d.notes, HasNote("MTL texture option '-imfchan' is not supported"));
  EXPECT_EQ(d.notes.size(), 7u) << testing::PrintToString(d.notes);
}

TEST_F(ObjTest, IlluminationModelsBecomeMirrorGlassAndGloss) {
  const Material mirror = material_of(with_material("Kd 0.01 0.01 0.01\nKs 0.95 0.9 0.85\nNs 1000\nillum 5\n"));
  EXPECT_EQ(mirror.kind, MaterialKind::conductor);
  EXPECT_TRUE(mirror.use_reflectance);
  EXPECT_EQ(mirror.reflectance.value, RGB(0.95f, 0.9f, 0.85f));
  EXPECT_EQ(mirror.roughness_u.value, 0);

  const Material metal = material_of(with_material("Kd 0 0 0\nKs 0.9 0.9 0.9\nNs 48\nillum 3\n"));
  EXPECT_EQ(metal.kind, MaterialKind::conductor);
  EXPECT_FLOAT_EQ(metal.roughness_u.value, 0.2f);
  EXPECT_FLOAT_EQ(metal.roughness_v.value, 0.2f);

  // A triangle encloses nothing: a pane, which light passes once.
  const Material glass = material_of(with_material("Kd 0 0 0\nKs 0.3 0.3 0.3\nTf 0.125 0.18 0.5\nNi 1.33\nillum 7\n"));
  EXPECT_EQ(glass.kind, MaterialKind::thin_dielectric);
  EXPECT_FLOAT_EQ(glass.ior, 1.33f);
  EXPECT_FLOAT_EQ(glass.transmittance.value.r, 0.25f);
  EXPECT_FLOAT_EQ(glass.transmittance.value.g, 0.36f);
  EXPECT_FLOAT_EQ(glass.transmittance.value.b, 1.0f);
  EXPECT_EQ(glass.reflectance.value, RGB(1.0f));

  const Material gloss = material_of(with_material("Kd 0.5 0.5 0.5\nKs 0.5 0.5 0.5\nNs 198\nillum 2\n"));
  EXPECT_EQ(gloss.kind, MaterialKind::metallic_roughness);
  EXPECT_EQ(gloss.metallic.value, 0);
  EXPECT_FLOAT_EQ(gloss.specular_color.value.r, 1.0f);  // 0.08 * 0.5 is the 0.04 that it scales
  EXPECT_FLOAT_EQ(gloss.roughness_u.value, 0.1f);

  // Model 4 as exporters write it for what is opaque, and highlights that model 1 does not have.
  EXPECT_EQ(material_of(with_material("Kd 0.5 0.5 0.5\nNi 1.5\nillum 4\n")).kind, MaterialKind::diffuse);
  EXPECT_EQ(material_of(with_material("Kd 0.5 0.5 0.5\nKs 1 1 1\nNs 9\nillum 1\n")).kind, MaterialKind::diffuse);
}

TEST_F(ObjTest, SheetsOfGlassArePanes) {
  write("m.mtl", "newmtl g\nKd 0 0 0\nTf 0.25 1 1\nNi 1.5\nillum 6\nnewmtl rim\nKd 0 0 0\nNi 1.5\nillum 7\n");
  const auto materials = [&](const std::string& faces) {
    const auto d =
        load_scene(write("a.obj",
                         "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0.01\nv 1 0 0.01\nv 1 1 0.01\n"
                         "v 0 1 0.01\nv 0.5 0.5 0.1\nusemtl g\n" +
                             faces));
    std::set<MaterialKind> kinds;
    for (const std::uint32_t m : d.geometry.material) kinds.insert(d.materials.at(m).kind);
    EXPECT_EQ(kinds.size(), 1u) << faces;
    if (kinds.contains(MaterialKind::thin_dielectric)) {
      EXPECT_EQ(d.materials.at(d.geometry.material[0]).transmittance.value, RGB(0.25f, 1, 1));
      EXPECT_THAT(d.notes, HasNote("taken as a thin pane"));
    }
    return *kinds.begin();
  };
  const std::string rims = "usemtl rim\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  EXPECT_EQ(materials("f 1 2 3 4\n"), MaterialKind::thin_dielectric);
  EXPECT_EQ(materials("f 1 2 3 4\nf 4 3 2 1\n"), MaterialKind::thin_dielectric) << "from both sides";
  EXPECT_EQ(materials("f 1 2 3 4\nf 8 7 6 5\n"), MaterialKind::thin_dielectric) << "two sheets that share nothing";
  EXPECT_EQ(materials("f 4 3 2 1\nf 5 6 7 8\n" + rims), MaterialKind::dielectric) << "a plate of two materials";
  const std::string wave = "f 1 2 9\nf 2 3 9\nf 3 4 9\nf 4 1 9\n";
  EXPECT_EQ(materials(wave), MaterialKind::thin_dielectric) << "a roof";
  EXPECT_EQ(materials(wave + "f 4 3 2 1\n"), MaterialKind::dielectric) << "a closed roof";
  EXPECT_EQ(materials(wave + "f 4 3 2\n"), MaterialKind::thin_dielectric) << "half open below";
}

TEST_F(ObjTest, OpacityByNumberAndTransparency) {
  EXPECT_FLOAT_EQ(material_of(with_material("Kd 1 1 1\nd 0.25\n")).alpha.value, 0.25f);
  EXPECT_FLOAT_EQ(material_of(with_material("Kd 1 1 1\nTr 0.25\n")).alpha.value, 0.75f);
}

TEST_F(ObjTest, TransparencyOfOneIsOpaqueButForGlass) {
  const auto opacity = [&](const std::string& mtl) {
    return material_of(with_material("Kd 1 1 1\n" + mtl)).alpha.value;
  };
  for (const char* mtl : {"d 1\nTr 1\n", "Tr 1\nd 1\n", "Tr 1\n", "Tr 1\nillum 2\n", "d 1\nTr 0\n", "Tr 0\n"})
    EXPECT_EQ(opacity(mtl), 1) << mtl;
  EXPECT_EQ(opacity("Tr 1\nd 0.25\n"), 0.25f) << "of the two, d counts";
  EXPECT_EQ(opacity("illum 4\nTr 1\n"), 0);
  EXPECT_EQ(opacity("Tr 1\nillum 9\n"), 0);
  EXPECT_EQ(opacity("Tr 1\nnewmtl n\nd 0.5\n"), 1) << "each material alone";
  EXPECT_THAT(with_material("Tr 1\n").notes, HasNote("'Tr' of 1"));
}

/// What editors and programs of other systems add and leave out.
TEST_F(ObjTest, MarksLineEndsAndQuotesOfOtherSystems) {
  const std::string mark = "\xef\xbb\xbf";
  write("marked.mtl", mark + "newmtl m\nKd 0.1 0.2 0.3\n");
  write("cr.mtl", "newmtl m\rKd 0.1 0.2 0.3");
  write("my lib.mtl", "newmtl \"m\"\r\nKd 0.1 0.2 0.3\r\n");
  const auto check = [&](const std::string& text) {
    const auto d = load_scene(write("a.obj", text));
    EXPECT_EQ(d.geometry.triangle_count(), 1u);
    EXPECT_EQ(material_of(d).reflectance.value, RGB(0.1f, 0.2f, 0.3f)) << text;
    EXPECT_TRUE(d.notes.empty()) << testing::PrintToString(d.notes);
  };
  const std::string rest = std::string(kTriangle) + "usemtl m\nf 1 2 3";
  std::string in_cr = "# made by hand\nmtllib cr.mtl\n" + rest;
  std::replace(in_cr.begin(), in_cr.end(), '\n', '\r');
  check(mark + "mtllib marked.mtl\n" + rest);
  check(in_cr);
  check("mtllib \"my lib.mtl\"\n" + rest);
  check("mtllib my lib.mtl\n" + std::string(kTriangle) + "usemtl \"m\"\nf 1 2 3");
  check("mtllib \"my lib.mtl\" \"cr.mtl\"\n" + rest);
  check(mark + rest + "\nmtllib cr.mtl");
}

TEST_F(ObjTest, FacesOfTwoCornersAndNumbersThatAreNotFiniteAreLeftOut) {
  const auto d = load_scene(write("a.obj", std::string(kTriangle) +
                                               "v 1.#QNAN -1.#IND 1.#INF\nvt -1.#IND00 +1\nvn 1.#QNAN0 0 1\nf 1 2\n"
                                               "f 1/1/1 2/1/1 3/1/1\nf 1 2 4\n"));
  EXPECT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_THAT(d.notes, HasNote("face of fewer than three corners, left out"));
  EXPECT_THAT(d.notes, HasNote("not finite, left out"));
}

TEST_F(ObjTest, TexturesWithoutAColourAreTakenWhole) {
  write("t.tga", tga_row({{0, 0, 255, 255}}));
  const auto color = [&](const std::string& mtl) {
    const auto d = with_material(mtl);
    return evaluate(d.textures, material_of(d).reflectance, {0.5f, 0.5f});
  };
  EXPECT_EQ(color("map_Kd t.tga\n"), RGB(1, 0, 0));
  EXPECT_EQ(color("map_Kd t.tga\nKd 0.5 0.5 0.5\n"), RGB(0.5f, 0, 0));
  EXPECT_EQ(color(""), RGB(0.6f));
}

TEST_F(ObjTest, OptionsOfTexturesBeforeAndAfterTheName) {
  write("two tone.tga", tga_row({{0, 0, 255, 255}, {0, 255, 0, 255}}));  // red, green
  const auto color = [&](const std::string& map, float u) {
    const auto d = with_material("Kd 1 1 1\nmap_Kd " + map + "\n");
    EXPECT_TRUE(d.notes.empty()) << map << testing::PrintToString(d.notes);
    return evaluate(d.textures, material_of(d).reflectance, {u, 0.5f});
  };
  for (const char* map : {"-s 2 1 1 two tone.tga", "two tone.tga -s 2 1 1", "-s 2 \"two tone.tga\"",
                          "\"two tone.tga\" -s 2 2", "-bm 1 two tone.tga -blendu on -s 2 2 2"}) {
    EXPECT_EQ(color(map, 0.125f), RGB(1, 0, 0)) << map;
    EXPECT_EQ(color(map, 0.375f), RGB(0, 1, 0)) << map;
    EXPECT_EQ(color(map, 0.625f), RGB(1, 0, 0)) << map;
  }
  EXPECT_EQ(color("-o 0.5 0 0 two tone.tga", 0.25f), RGB(0, 1, 0));
  EXPECT_EQ(color("-s 0.5 -o 0.5 two tone.tga", 0.5f), RGB(0, 1, 0)) << "scaled first";
  EXPECT_EQ(color("two tone.tga -mm 0.25 0.5", 0.25f), RGB(0.75f, 0.25f, 0.25f));
  EXPECT_EQ(color("-clamp on two tone.tga -mm -2 1", 0.25f), RGB(0, 0, 0));
  EXPECT_EQ(color("two tone.tga -clamp on", 1.25f), RGB(0, 1, 0));
}

TEST_F(ObjTest, TexturesWithAlphaForAnyCapitalsAndSlashes) {
  write("Maps/Leaf.tga", tga_row({{0, 0, 255, 255}, {0, 255, 0, 0}}));
  const auto d = with_material("Kd 1 1 1\nmap_Kd maps\\leaf.TGA\n");
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
}

TEST_F(ObjTest, TextureColourAndAlphaAreRead) {
  write("leaf.tga", tga_row({{0, 0, 255, 255}, {0, 255, 0, 0}}));
  const auto d = with_material("Kd 0.5 0.5 0.5\nmap_Kd leaf.tga\n");
  const Material& m = material_of(d);
  ASSERT_NE(m.reflectance.texture, kNone);
  const RGB red = evaluate(d.textures, m.reflectance, {0.25f, 0.5f});
  EXPECT_NEAR(red.r, 0.5f, 1e-5);
  EXPECT_NEAR(red.g, 0, 1e-5);
  EXPECT_EQ(m.alpha.channel, Channel::alpha);
  EXPECT_NEAR(evaluate(d.textures, m.alpha, {0.25f, 0.5f}), 1, 1e-5);
  EXPECT_NEAR(evaluate(d.textures, m.alpha, {0.75f, 0.5f}), 0, 1e-5);
}

TEST_F(ObjTest, OpacityMapsAreReadAsNumbers) {
  write("mask.tga", tga_row({{128, 128, 128, 255}, {0, 0, 0, 255}}));
  const auto d = with_material("Kd 1 1 1\nd 0.5\nmap_d mask.tga\n");
  EXPECT_NEAR(evaluate(d.textures, material_of(d).alpha, {0.25f, 0.5f}), 0.5f * 128 / 255, 1e-5);
}

TEST_F(ObjTest, MissingAndBrokenTexturesAreMagentaWithANote) {
  const auto missing = with_material("Kd 1 1 1\nmap_Kd nowhere.png\n");
  EXPECT_EQ(evaluate(missing.textures, material_of(missing).reflectance, {0.5f, 0.5f}), RGB(1, 0, 1));
  EXPECT_THAT(missing.notes, HasNote("nowhere.png' is magenta"));
  write("not.png", "this is no image");
  const auto broken = with_material("Kd 1 1 1\nmap_Kd not.png\n");
  EXPECT_EQ(evaluate(broken.textures, material_of(broken).reflectance, {0.5f, 0.5f}), RGB(1, 0, 1));
  EXPECT_THAT(broken.notes, HasNote("not.png' is magenta"));
}

TEST_F(ObjTest, MissingDataTexturesChangeNothing) {
  const auto d = with_material("Kd 0.5 0.5 0.5\nKe 3 3 3\nd 0.5\nmap_d gone.png\nmap_Ke gone.png\nnorm gone.png\n");
  const Material& m = material_of(d);
  const Vec2 at{0.5f, 0.5f};
  EXPECT_EQ(evaluate(d.textures, m.alpha, at), 0.5f);
  EXPECT_EQ(evaluate(d.textures, m.normal_map, at), RGB(0.5f, 0.5f, 1));
  EXPECT_EQ(evaluate(d.textures, d.emissions.at(0).radiance, at), RGB(0.0f));
  EXPECT_THAT(d.notes, HasNote("gone.png' is left out: "));
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
}

TEST_F(ObjTest, NotesCountWhatIsLeftOut) {
  write("m.mtl", "newmtl m\nKd 1 1 1\nmap_bump b.png\n");
  const auto d = load_scene(write("a.obj", std::string("mtllib m.mtl\nmtllib gone.mtl\n") + kTriangle +
                                               "v nan 0 0\nl 1 2\nl 2 3\nusemtl other\nf 1 2 3\nf 1 2 2\nf 1 2 4\n"));
  EXPECT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_THAT(d.notes, HasNote("line element (l), left out (2 times)"));
  EXPECT_THAT(d.notes, HasNote("triangle without area, left out"));
  EXPECT_THAT(d.notes, HasNote("not finite, left out"));
  EXPECT_THAT(d.notes, HasNote("'gone.mtl' cannot be opened"));
  EXPECT_THAT(d.notes, HasNote("'other' is used but not defined"));
  EXPECT_THAT(d.notes, HasNote("'map_bump' is not supported"));
}

TEST_F(ObjTest, LibrariesMayDefineMaterialsInAnyOrder) {
  // What stands before the first newmtl belongs to no material.
  write("m.mtl", "map_Kd nowhere.png\nKd 1 0 0\nnewmtl a\nKd 0.25\nnewmtl b\nKd 0.1 0.2 0.3 # a comment\n");
  const auto d = load_scene(write(
      "a.obj", std::string("usemtl b\n") + kTriangle + "f 1 2 3\nmtllib m.mtl\nmtllib m.mtl\nusemtl a\nf 1 2 3\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 2u);
  EXPECT_EQ(d.materials.at(d.geometry.material[0]).reflectance.value, RGB(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(d.materials.at(d.geometry.material[1]).reflectance.value, RGB(0.25f));
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
}

TEST_F(ObjTest, OneLineMayNameSeveralLibrariesOrOneWithBlanks) {
  write("a.mtl", "newmtl a\nKd 0.1 0.2 0.3\n");
  write("b.mtl", "newmtl a\nKd 1 1 1\nnewmtl b\nKd 0.25\n");
  write("my lib.mtl", "newmtl c\nKd 0.5\n");
  const auto d = load_scene(write("a.obj", std::string("mtllib a.mtl gone.mtl b.mtl\nmtllib my lib.mtl\n") + kTriangle +
                                               "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  const auto color_of = [&](std::size_t t) { return d.materials.at(d.geometry.material[t]).reflectance.value; };
  EXPECT_EQ(color_of(0), RGB(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(color_of(1), RGB(0.25f));
  EXPECT_EQ(color_of(2), RGB(0.5f));
  EXPECT_THAT(d.notes, HasNote("material library 'gone.mtl' cannot be opened"));
  EXPECT_EQ(d.notes.size(), 1u) << testing::PrintToString(d.notes);
}

TEST_F(ObjTest, TextureOptionsAndNamesWithSpaces) {
  write("my leaf#1.tga", tga_row({{0, 0, 255, 255}, {0, 255, 0, 0}}));
  const auto d = with_material("Kd 0.6\nmap_Kd -t 0.5 0.5 -clamp on my leaf#1.tga\n");
  EXPECT_THAT(d.notes, HasNote("texture option '-t'"));
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
  EXPECT_NEAR(evaluate(d.textures, material_of(d).reflectance, {-3.0f, 0.5f}).r, 0.6f, 1e-5);
}

TEST_F(ObjTest, ConcavePolygonsAreCoveredOnce) {
  const auto d = load_scene(write("a.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  float area = 0;
  for (std::uint32_t t = 0; t < 3; ++t) {
    EXPECT_EQ(d.geometry.normal(t), (Vec3{0, 0, 1}));
    area += d.geometry.area(t);
  }
  EXPECT_FLOAT_EQ(area, 10);
}

/// What takes minutes where an algorithm is not linear.
TEST_F(ObjTest, LargePolygonsAndManyMaterialsTakeLittleTime) {
  std::string polygon, round = "f";
  for (int i = 1; i <= 50'000; ++i) {
    const double angle = 2 * M_PI * i / 50'000, radius = i % 2 ? 0.9 : 1;
    polygon += "v " + std::to_string(1000 * radius * std::cos(angle)) + " " +
               std::to_string(1000 * radius * std::sin(angle)) + " 0\n";
    round += " " + std::to_string(i);
  }
  EXPECT_GT(load_scene(write("polygon.obj", polygon + round + "\n")).geometry.triangle_count(), 40'000u);

  std::string many = kTriangle, fan = "s 1\nv 0 0 1\n";
  for (int i = 0; i < 100'000; ++i) many += "usemtl m" + std::to_string(i % 50'000) + "\nf 1 2 3\nmtllib gone.mtl\n";
  const auto d = load_scene(write("many.obj", many));
  EXPECT_EQ(d.geometry.triangle_count(), 100'000u);
  EXPECT_EQ(d.materials.size(), 50'000u);
  EXPECT_LT(d.notes.size(), 20u);
  EXPECT_EQ(load_scene(write("smooth.obj", "s 1\n" + many)).geometry.triangle_count(), 100'000u);
  for (int i = 0; i < 50'000; ++i) {
    const double angle = 2 * M_PI * i / 50'000;
    fan += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
    if (i > 0) fan += "f 1 -2 -1\n";
  }
  const auto cone = load_scene(write("cone.obj", fan));
  EXPECT_GT(cone.geometry.triangle_count(), 40'000u);

  std::string continued = kTriangle;
  for (int i = 0; i < 200'000; ++i) continued += "\\\n";
  EXPECT_EQ(load_scene(write("continued.obj", continued + "f 1 2 3\n")).geometry.triangle_count(), 1u);
}

TEST_F(ObjTest, BadFilesAreRefusedWithTheirLine) {
  const auto refused = [&](const std::string& text) { return message_of(write("bad.obj", text)); };
  const std::string v = kTriangle;
  EXPECT_THAT(refused(v + "f 1 2 9\n"), HasSubstr("bad.obj:4: vertex index 9 is out of range: 3 defined so far"));
  EXPECT_THAT(refused(v + "# a comment\nf 1 2 \\\n-4\n"), HasSubstr("bad.obj:6: vertex index -4 is out of range"));
  EXPECT_THAT(refused(v + "f 1 2 0\n"), HasSubstr("bad.obj:4: vertex index 0 is out of range"));
  EXPECT_THAT(refused(v + "f 1 2 99999999999999999999\n"), HasSubstr("is out of range"));
  EXPECT_THAT(refused(v + "f 1/1 2/1 3/1\n"), HasSubstr("bad.obj:4: texture vertex index 1 is out of range"));
  EXPECT_THAT(refused(v + "f 1//1 2//1 3//1\n"), HasSubstr("bad.obj:4: normal index 1 is out of range"));
  EXPECT_THAT(refused(v + "f 1 x 3\n"), HasSubstr("bad.obj:4: 'x' is not an index"));
  EXPECT_THAT(refused(v + "f 1 2\n"), HasSubstr("has no faces"));
  EXPECT_THAT(refused("v 0 zero 0\n" + v + "f 1 2 3\n"), HasSubstr("bad.obj:1: 'zero' is not a number"));
  EXPECT_THAT(refused("v 0 0\n" + v + "f 1 2 3\n"), HasSubstr("bad.obj:1: vertex with 2 coordinates"));
  EXPECT_THAT(refused(v), HasSubstr("has no faces"));
  EXPECT_THAT(refused(""), HasSubstr("has no faces"));
  EXPECT_THAT(refused("v nan nan nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("has no triangles"));
  EXPECT_THAT(refused(std::string(3000, '\xff')), HasSubstr("has no faces"));
}

}  // namespace
}  // namespace glowworm
