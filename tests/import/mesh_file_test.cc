// PLY and STL files as scenes.
#include <algorithm>
#include <cctype>

#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;
using testing::Not;

using MeshFileTest = FileTest;

constexpr const char* kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

/// A binary STL file of triangles (0 0 0) (1 0 0) (0 1 i) with normals along z.
std::string binary_stl(std::uint32_t count, std::uint32_t promised, float normal = 1) {
  std::string bytes = "solid in name alone";
  bytes.resize(80);
  append_bytes<std::uint32_t>(bytes, {promised});
  for (std::uint32_t i = 0; i < count; ++i) {
    append_bytes<float>(bytes, {0, 0, normal, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(i)});
    bytes += std::string(2, '\0');
  }
  return bytes;
}

TEST_F(MeshFileTest, AsciiStl) {
  const auto d = load_scene(
      write("a.STL", std::string("solid a facet b\n") + kFacet + "endsolid a\nsolid\n" + kFacet + "endsolid\n"));
  EXPECT_EQ(d.geometry.triangle_count(), 2u);
  EXPECT_EQ(d.geometry.positions.size(), 3u);
  EXPECT_EQ(d.geometry.normals[0], (Vec3{0, 0, 0}));
  EXPECT_EQ(d.materials.at(0).kind, MaterialKind::diffuse);
}

TEST_F(MeshFileTest, AsciiStlInCapitalsOrWithAMarkOrOtherLineEnds) {
  const std::string text = std::string("solid a\n") + kFacet + "endsolid a\n";
  std::string upper = text, cr = text;
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (const std::string& file : {upper, cr, "\xef\xbb\xbf" + text})
    EXPECT_EQ(load_scene(write("a.stl", file)).geometry.triangle_count(), 1u) << file;
}

TEST_F(MeshFileTest, BinaryStlThatBeginsWithSolid) {
  const auto d = load_scene(write("a.stl", binary_stl(3, 3)));
  EXPECT_EQ(d.geometry.triangle_count(), 3u);
  EXPECT_THAT(d.notes, Not(HasNote("reversed")));
  const auto turned = load_scene(write("b.stl", binary_stl(1, 1, -1)));
  EXPECT_EQ(turned.geometry.normal(0), (Vec3{0, 0, -1}));
  EXPECT_THAT(turned.notes, HasNote("reversed"));
}

TEST_F(MeshFileTest, BadStlIsRefusedWithItsPlace) {
  EXPECT_THAT(message_of(write("a.stl", "")), HasSubstr("a.stl: is not an STL file"));
  EXPECT_THAT(message_of(write("b.stl", binary_stl(1, 0xffffffff).replace(0, 5, "other"))),
              HasSubstr("promises 4294967295 facets"));
  const auto ascii = [&](const std::string& text) { return message_of(write("c.stl", "solid c\n" + text)); };
  EXPECT_THAT(ascii("facet normal 0 0\n"), HasSubstr("c.stl:2: expected three numbers"));
  EXPECT_THAT(ascii("vertex 0 0 0\n"), HasSubstr("c.stl:2: a vertex that belongs to no facet"));
  EXPECT_THAT(ascii("facet normal 0 0 1\nvertex 0 0 0\nendfacet\n"), HasSubstr("c.stl:4: a facet of 1 vertices"));
  EXPECT_THAT(ascii("facet normal 0 0 1\n"), HasSubstr("ends within a facet"));
  EXPECT_THAT(ascii("polygon\n"), HasSubstr("unknown word 'polygon'"));
  EXPECT_THAT(ascii("endsolid\n"), HasSubstr("has no triangles"));
}

TEST_F(MeshFileTest, PlyWithNormalsTextureAndAConcaveFace) {
  write("t.tga", tga_row({{0, 0, 255, 255}}));
  const auto d = load_scene(write(
      "a.ply",
      "ply\nformat ascii 1.0\ncomment TextureFile t.tga\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n"
      "property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 0 0 1 0 0 9\n4 0 0 0 0 1 1 0 9\n4 4 0 0 0 1 1 1 9\n2 1 0 0 0 1 0 0 9\n0 4 0 0 0 1 0 1 9\n5 0 1 2 3 4\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  float area = 0;
  for (std::uint32_t t = 0; t < 3; ++t) {
    EXPECT_EQ(d.geometry.normal(t), (Vec3{0, 0, 1}));
    area += d.geometry.area(t);
  }
  EXPECT_FLOAT_EQ(area, 10);
  EXPECT_EQ(d.geometry.normals[0], (Vec3{0, 0, 1}));
  EXPECT_EQ(evaluate(d.textures, d.materials.at(0).reflectance, {0.5f, 0.5f}), RGB(1, 0, 0));
  EXPECT_THAT(d.notes, HasNote("colours at its vertices"));
}

TEST_F(MeshFileTest, PlyWithTextureCoordinatesAtCorners) {
  write("my scan.tga", tga_row({{0, 0, 255, 255}, {255, 0, 0, 255}}));  // red, blue
  const auto ply = [&](const std::string& lists, const std::string& faces) {
    return "ply\nformat ascii 1.0\ncomment TextureFile  my scan.tga \nelement vertex 4\nproperty float x\n"
           "property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
           "element face 3\n" +
           lists + "end_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n" + faces;
  };
  const std::string indices = "property list uchar int vertex_indices\n", uvs = "property list uchar float texcoord\n";
  const std::string red = "6 .25 .5 .25 .5 .25 .5 ", blue = "8 .75 .5 .75 .5 .75 .5 .75 .5 ";
  // The last face has no texture coordinates.
  for (const std::string& text : {ply(indices + uvs, "3 0 1 2 " + red + "4 0 1 2 3 " + blue + "3 0 2 3 0"),
                                  ply(uvs + indices, red + "3 0 1 2 " + blue + "4 0 1 2 3 0 3 0 2 3")}) {
    const auto d = load_scene(write("a.ply", text));
    EXPECT_EQ(d.notes.size(), 0u) << testing::PrintToString(d.notes);
    ASSERT_EQ(d.geometry.triangle_count(), 4u);
    const auto seen = [&](std::uint32_t t) {
      return evaluate(d.textures, d.materials.at(0).reflectance, texture_point(d.geometry, t, {0.3f, 0.3f}));
    };
    EXPECT_GT(seen(0).r, 0.99f);
    EXPECT_GT(seen(1).b, 0.99f);
    EXPECT_GT(seen(2).b, 0.99f);
    EXPECT_EQ(d.geometry.positions[d.geometry.triangles[2][2]], (Vec3{0, 1, 0}));
    EXPECT_EQ(d.geometry.normals[d.geometry.triangles[2][2]], (Vec3{0, 0, 1}));
    EXPECT_EQ(d.geometry.uvs[d.geometry.triangles[3][2]].x, 0);
  }
  // Faces may not name the vertices that were added for others.
  EXPECT_THAT(message_of(write("b.ply", ply(indices + uvs, "3 0 1 2 " + red + "3 0 1 5 " + red + "3 0 2 3 0"))),
              HasSubstr("a face has vertex 5, but there are 4 vertices"));
}

constexpr const char* kPlyVertices =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";

TEST_F(MeshFileTest, PlyTriangleStripsFaceOneWay) {
  const auto d = load_scene(write("a.ply", kPlyVertices + std::string("element tristrips 2\n"
                                                                      "property list int int vertex_indices\n"
                                                                      "end_header\n0 0 0 1 0 0 0 1 0 1 1 0\n"
                                                                      "8 0 1 2 3 -1 0 1 3 3 0 1 2")));
  ASSERT_EQ(d.geometry.triangle_count(), 4u);
  for (std::uint32_t t = 0; t < 4; ++t) EXPECT_EQ(d.geometry.normal(t), (Vec3{0, 0, 1})) << t;
  EXPECT_THAT(message_of(write("b.ply", kPlyVertices + std::string("element tristrips 1\n"
                                                                   "property list int int vertex_indices\n"
                                                                   "end_header\n0 0 0 1 0 0 0 1 0 1 1 0\n"
                                                                   "3 0 1 4"))),
              HasSubstr("a face has vertex 4"));
}

TEST_F(MeshFileTest, PlyOfOtherProgramsAndSystems) {
  write("t.tga", tga_row({{0, 0, 255, 255}, {255, 0, 0, 255}}));  // red, blue
  std::string text =
      "ply\nformat ascii 1.0\ncomment TextureFile t.tga\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty float tx\nproperty float ty\nelement face 3\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 .75 .5\n1 0 0 .75 .5\n0 1 0 .75 .5\n1.#QNAN -1.#IND 1e999 0 0\n3 0 1 2\n2 0 1\n3 0 1 3\n";
  std::string cr = text;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (const std::string& file : {text, cr, "\xef\xbb\xbf" + text}) {
    const auto d = load_scene(write("a.ply", file));
    ASSERT_EQ(d.geometry.triangle_count(), 1u);
    EXPECT_EQ(evaluate(d.textures, d.materials.at(0).reflectance, texture_point(d.geometry, 0, {0.3f, 0.3f})),
              RGB(0, 0, 1));
    EXPECT_THAT(d.notes, HasNote("face of fewer than three corners, left out"));
    EXPECT_THAT(d.notes, HasNote("not finite, left out"));
  }
  // Binary data behind a header that ends in a carriage return may begin with a line feed.
  std::string binary =
      "ply\rformat binary_little_endian 1.0\relement vertex 3\rproperty uchar x\rproperty uchar y\r"
      "property uchar z\relement face 1\rproperty list uchar uchar vertex_indices\rend_header\r";
  binary += std::string("\n\0\0\1\0\0\0\1\0", 9) + std::string("\3\0\1\2", 4);
  EXPECT_EQ(load_scene(write("b.ply", binary)).geometry.positions.at(0).x, 10);
}

TEST_F(MeshFileTest, PlyWithSeveralTexturesIsNoted) {
  write("a.tga", tga_row({{0, 0, 255, 255}}));
  write("b.tga", tga_row({{255, 0, 0, 255}}));
  const auto d =
      load_scene(write("a.ply",
                       "ply\nformat ascii 1.0\ncomment TextureFile a.tga\ncomment TextureFile b.tga\nelement vertex 3\n"
                       "property float x\nproperty float y\nproperty float z\nelement face 1\n"
                       "property list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n"));
  EXPECT_EQ(evaluate(d.textures, d.materials.at(0).reflectance, {0.5f, 0.5f}), RGB(0, 0, 1));
  EXPECT_THAT(d.notes, HasNote("only the last texture is used, 'b.tga'"));
}

TEST_F(MeshFileTest, BadPlyIsRefused) {
  EXPECT_THAT(message_of(write("a.ply", "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nend_header\n0\n")),
              HasSubstr("a.ply"));
  EXPECT_THAT(message_of(write("b.ply", "")), HasSubstr("b.ply"));
}

TEST_F(MeshFileTest, TheBudgetBoundsEveryReader) {
  const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string files[] = {
      write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
      write("a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                triangle + "3 0 1 2\n"),
      write("a.stl", std::string("solid\n") + kFacet), write("b.stl", binary_stl(1, 1))};
  for (const std::string& file : files) {
    ImportOptions options;
    options.budget = loading_budget(100'000);
    EXPECT_EQ(load_scene(file, options).geometry.triangle_count(), 1u) << file;
    // A scene's triangle takes 344 bytes with its vertices, beside the mesh and the file.
    EXPECT_GE(options.budget->peaks().at("triangles"), 344u) << file;
    EXPECT_GT(options.budget->peaks().at("meshes"), 0u) << file;
    EXPECT_GT(options.budget->peaks().at("scene files"), 0u) << file;
    options.budget = loading_budget(400);
    EXPECT_THROW(load_scene(file, options), Error) << file;
  }
}

}  // namespace
}  // namespace glowworm
