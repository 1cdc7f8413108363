#include <gtest/gtest.h>

#include <cmath>

#include "import/pbrt/shapes.h"
#include "pbrt/pbrt_testing.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::has_note;
using pbrt_testing::load_text;
using pbrt_testing::total_area;

Geometry shape(const std::string& text) { return load_text("WorldBegin\n" + text).geometry; }

/// Largest distance of shading normals from `normal(position)`, and whether all triangles are wound with them.
template <typename Normal>
void expect_normals(const Geometry& mesh, const Normal& normal) {
  float worst = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    worst = std::max(worst, length(mesh.normals[i] - normal(mesh.positions[i])));
  }
  EXPECT_LT(worst, 1e-5f);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    ASSERT_GT(dot(mesh.scaled_normal(t), mesh.normals[a] + mesh.normals[b] + mesh.normals[c]), 0) << t;
  }
}

TEST(PbrtShape, WholeSphere) {
  const Geometry mesh = shape("Shape \"sphere\" \"float radius\" 3");
  EXPECT_NEAR(total_area(mesh) / (4 * M_PI * 9), 1, 1e-5);
  expect_normals(mesh, [](Vec3 p) { return normalize(p); });
  for (const Vec3& p : mesh.positions) ASSERT_NEAR(length(p), 3, 3 * 1e-3);
}

TEST(PbrtShape, SphereThatIsALightHasItsAreaToo) {
  const SceneDescription scene =
      load_text("WorldBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" 3");
  EXPECT_NEAR(total_area(scene.geometry) / (4 * M_PI * 9), 1, 1e-5);
  EXPECT_EQ(scene.geometry.emission[0], 0u);
}

TEST(PbrtShape, PartialSphere) {
  const Geometry mesh =
      shape("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 1.5 \"float phimax\" 90");
  // Archimedes: the area of a zone is its height times the circumference.
  EXPECT_NEAR(total_area(mesh) / (M_PI / 2 * 2 * 2.5), 1, 1e-5);
  expect_normals(mesh, [](Vec3 p) { return normalize(p); });
  const Box3 box = mesh.bounds();
  EXPECT_NEAR(box.min.z, -1, 2e-3);
  EXPECT_NEAR(box.max.z, 1.5, 2e-3);
  EXPECT_NEAR(box.min.x, 0, 1e-6);
  EXPECT_NEAR(box.min.y, 0, 1e-6);
}

TEST(PbrtShape, ReversedSphereLooksInwards) {
  const Geometry mesh = shape("ReverseOrientation Shape \"sphere\"");
  expect_normals(mesh, [](Vec3 p) { return -normalize(p); });
  const Geometry mirrored = shape("Scale 1 -1 1 Shape \"sphere\"");
  expect_normals(mirrored, [](Vec3 p) { return normalize(p); });
}

TEST(PbrtShape, StretchedSphereHasNormalsOfTheEllipsoid) {
  const Geometry mesh = shape("Scale 1 2 4 Shape \"sphere\"");
  expect_normals(mesh, [](Vec3 p) { return normalize(Vec3{p.x, p.y / 4, p.z / 16}); });
}

TEST(PbrtShape, DiskAndRing) {
  const Geometry disk = shape("Shape \"disk\" \"float radius\" 2 \"float height\" 5");
  EXPECT_NEAR(total_area(disk) / (M_PI * 4), 1, 1e-5);
  expect_normals(disk, [](Vec3) { return Vec3{0, 0, 1}; });
  EXPECT_EQ(disk.bounds().min.z, 5);
  const Geometry ring = shape("Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1 \"float phimax\" 180");
  EXPECT_NEAR(total_area(ring) / (M_PI / 2 * 3), 1, 1e-5);
  EXPECT_NEAR(ring.bounds().min.y, 0, 1e-5);
}

TEST(PbrtShape, Cylinder) {
  const Geometry mesh =
      shape("Shape \"cylinder\" \"float radius\" 2 \"float zmin\" 1 \"float zmax\" 4 \"float phimax\" 270");
  EXPECT_NEAR(total_area(mesh) / (1.5 * M_PI * 2 * 3), 1, 1e-5);
  expect_normals(mesh, [](Vec3 p) { return normalize(Vec3{p.x, p.y, 0}); });
  EXPECT_EQ(mesh.bounds().min.z, 1);
  EXPECT_EQ(mesh.bounds().max.z, 4);
}

TEST(PbrtShape, TextureCoordinatesRunAsInPbrt) {
  const Geometry sphere = shape("Shape \"sphere\"");
  for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
    const Vec3 p = normalize(sphere.positions[i]);
    ASSERT_NEAR(sphere.uvs[i].y, 1 - std::acos(p.z) / M_PI, 1e-3);
    if (sphere.uvs[i].x > 0 && sphere.uvs[i].x < 1 && std::fabs(p.z) < 0.99f) {
      double phi = std::atan2(p.y, p.x);
      if (phi < 0) phi += 2 * M_PI;
      ASSERT_NEAR(sphere.uvs[i].x, phi / (2 * M_PI), 1e-3);
    }
  }
  const Geometry disk = shape("Shape \"disk\" \"float innerradius\" .5");
  for (std::size_t i = 0; i < disk.positions.size(); ++i) {
    ASSERT_NEAR(disk.uvs[i].y, (1 - length(disk.positions[i])) / 0.5f, 2e-3);
  }
}

TEST(PbrtShape, TriangleMeshKeepsItsArrays) {
  const Geometry mesh = shape(
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] "
      "\"point2 uv\" [0 0 .5 0 .5 .25 0 .25] \"normal N\" [0 0 2 0 0 2 0 0 2 0 0 2]");
  ASSERT_EQ(mesh.triangle_count(), 2u);
  EXPECT_EQ(mesh.uvs[2].x, 0.5f);
  EXPECT_EQ(mesh.uvs[2].y, 0.25f);
  EXPECT_TRUE(mesh.normals[0] == (Vec3{0, 0, 1}));
  EXPECT_TRUE(mesh.normal(0) == (Vec3{0, 0, 1}));
}

TEST(PbrtShape, NormalsSayWhereTheOutsideIs) {
  const Geometry mesh =
      shape("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 -1 0 0 -1 0 0 -1]");
  EXPECT_TRUE(mesh.normal(0) == (Vec3{0, 0, -1}));
  const Geometry reversed = shape(
      "ReverseOrientation Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 -1 0 0 -1 0 0 -1]");
  EXPECT_TRUE(reversed.normal(0) == (Vec3{0, 0, 1}));
}

TEST(PbrtShape, TexturedMeshWithoutCoordinatesGetsPbrts) {
  const Geometry mesh = shape(
      "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" "
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0]");
  ASSERT_EQ(mesh.positions.size(), 6u);
  EXPECT_EQ(mesh.uvs[3].x, 0);
  EXPECT_EQ(mesh.uvs[4].x, 1);
  EXPECT_EQ(mesh.uvs[5].y, 1);
}

TEST(PbrtShape, QuadsWithoutCoordinatesGetThoseOfPbrtsPatches) {
  const TemporaryFolder folder;
  // A triangle, two quads cut along either diagonal, and a pentagon.
  folder.write("m.ply",
               "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
               "0 0 0 2 0 0 3 1 0 1 1 0 0 0 1 2 0 1 1 1 1 -1 1 1 0.5 3 1\n"
               "3 0 1 2 4 0 1 2 3 4 4 5 6 7 5 4 5 6 8 7\n");
  const auto load = [&](const char* end) {
    return load_scene(folder.write("s.pbrt", std::string("WorldBegin Texture \"t\" \"spectrum\" \"checkerboard\"\n"
                                                         "Material \"diffuse\" \"texture reflectance\" \"t\"\n"
                                                         "Shape \"plymesh\" \"string filename\" \"m.ply\"\n") +
                                                 end))
        .geometry;
  };
  const Geometry mesh = load("");
  ASSERT_EQ(mesh.triangle_count(), 8u);
  const Vec2 corner[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto expect_corners = [&](const Geometry& of, std::uint32_t t, std::array<int, 3> expected) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(of.uvs[of.triangles[t][i]].x, corner[expected[i]].x) << t << " " << i;
      EXPECT_EQ(of.uvs[of.triangles[t][i]].y, corner[expected[i]].y) << t << " " << i;
    }
  };
  expect_corners(mesh, 0, {0, 1, 2});
  expect_corners(mesh, 1, {0, 1, 3});
  expect_corners(mesh, 2, {1, 2, 3});
  expect_corners(mesh, 3, {0, 1, 2});
  expect_corners(mesh, 4, {0, 2, 3});
  for (std::uint32_t t = 5; t < 8; ++t) expect_corners(mesh, t, {0, 1, 2});
  const Geometry old = load("WorldEnd");
  for (std::uint32_t t = 0; t < 8; ++t) expect_corners(old, t, {0, 1, 2});
}

TEST(PbrtShape, BilinearMeshes) {
  // p00 p10 p01 p11; the normal is that of du x dv.
  const Geometry flat = shape("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 3 0 2 3 0]");
  EXPECT_EQ(flat.triangle_count(), 2u);
  EXPECT_NEAR(total_area(flat), 6, 1e-6);
  EXPECT_TRUE(flat.normal(0) == (Vec3{0, 0, 1}));
  const Geometry curved = shape("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]");
  EXPECT_EQ(curved.triangle_count(), 512u);
  // z = x y: the area is the integral of sqrt(1 + x^2 + y^2) over the unit square, by the midpoint rule.
  double area = 0;
  constexpr int kCells = 400;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const double x = (i + 0.5) / kCells, y = (j + 0.5) / kCells;
      area += std::sqrt(1 + x * x + y * y) / (kCells * kCells);
    }
  }
  EXPECT_NEAR(total_area(curved) / area, 1, 1e-3);
  expect_normals(curved, [](Vec3 p) { return normalize(Vec3{-p.y, -p.x, 1}); });
  const Geometry two = shape(
      "Shape \"bilinearmesh\" \"integer indices\" [0 1 2 3 1 4 3 5] \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0] "
      "\"point2 uv\" [0 0 .5 0 0 1 .5 1 1 0 1 1]");
  EXPECT_EQ(two.triangle_count(), 4u);
  EXPECT_NEAR(total_area(two), 2, 1e-6);
}

TEST(PbrtShape, LoopSubdivisionOfAnOctahedronIsRound) {
  const Geometry mesh = shape(
      "Shape \"loopsubdiv\" \"integer levels\" 4 \"integer indices\" "
      "[0 1 2 1 3 2 3 4 2 4 0 2 1 0 5 3 1 5 4 3 5 0 4 5] \"point3 P\" [1 0 0 0 1 0 0 0 1 -1 0 0 0 -1 0 0 0 -1]");
  EXPECT_EQ(mesh.triangle_count(), 8u * 256);
  float smallest = 1e9f, largest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    smallest = std::min(smallest, length(mesh.positions[i]));
    largest = std::max(largest, length(mesh.positions[i]));
    ASSERT_GT(dot(mesh.normals[i], normalize(mesh.positions[i])), 0.95f);
  }
  EXPECT_GT(smallest / largest, 0.85f);
  // Closed: by the divergence theorem the scaled normals add up to nothing.
  Vec3 sum{0, 0, 0};
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) sum += mesh.scaled_normal(t);
  EXPECT_LT(length(sum), 1e-5f);
}

TEST(PbrtShape, LoopSubdivisionsOfAFileAreBoundedTogether) {
  // A few kilobytes that ask for a hundred million triangles.
  std::string text;
  for (int i = 0; i < 50; ++i) {
    text +=
        "Shape \"loopsubdiv\" \"integer levels\" 10 \"integer indices\" [ 0 1 2 0 2 3 0 3 1 1 3 2 ] "
        "\"point3 P\" [ 0 0 0 1 0 0 0 1 0 0 0 1 ]\n";
  }
  const Geometry mesh = shape(text);
  EXPECT_GT(mesh.triangle_count(), 1'000'000u);
  EXPECT_LT(mesh.triangle_count(), 2'200'000u);
}

TEST(PbrtShape, LoopSubdivisionOfAFlatSheetStaysFlatAndKeepsItsArea) {
  Geometry sheet;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) sheet.positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
  }
  for (std::uint32_t y = 0; y < 3; ++y) {
    for (std::uint32_t x = 0; x < 3; ++x) {
      const std::uint32_t a = y * 4 + x;
      sheet.triangles.push_back({a, a + 1, a + 5});
      sheet.triangles.push_back({a, a + 5, a + 4});
    }
  }
  const Geometry fine = loop_subdivide(sheet, 3);
  EXPECT_EQ(fine.triangle_count(), 18u * 64);
  for (const Vec3& p : fine.positions) ASSERT_NEAR(p.z, 0, 1e-7);
  // The corners of the boundary, cubic B-splines, are rounded off; its straight sides stay.
  EXPECT_LT(total_area(fine), 9);
  EXPECT_GT(total_area(fine), 8.5);
}

TEST(PbrtShape, InstancesAreMovedByBothTransforms) {
  const SceneDescription scene = load_text(
      "WorldBegin Translate 1 0 0 ObjectBegin \"o\" Scale 2 2 2 Shape \"sphere\" \"float radius\" .5 ObjectEnd\n"
      "Translate 0 10 0 ObjectInstance \"o\" AttributeBegin Scale -1 1 1 ObjectInstance \"o\" AttributeEnd");
  // Instance transform, then the object's own, then the shape's: (1 + 1, 10, 0) and (1 - 1, 10, 0).
  const Box3 box = scene.geometry.bounds();
  EXPECT_NEAR(box.min.x, -1, 2e-3);
  EXPECT_NEAR(box.max.x, 3, 2e-3);
  EXPECT_NEAR(box.min.y, 9, 2e-3);
  EXPECT_NEAR(total_area(scene.geometry) / (2 * 4 * M_PI), 1, 1e-5);
  for (std::uint32_t t = 0; t < scene.geometry.triangle_count(); ++t) {
    const auto [a, b, c] = scene.geometry.corner_normals(t);
    ASSERT_GT(dot(scene.geometry.scaled_normal(t), a + b + c), 0) << t;
  }
}

TEST(PbrtShape, ObjectsWithinObjectsAreInstancesOfTheInnerOnes) {
  // Two spheres a row, three rows; mirrored rows, too.
  const SceneDescription scene = load_text(
      "WorldBegin ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd\n"
      "ObjectBegin \"row\" ObjectInstance \"ball\" AttributeBegin Translate 3 0 0 ObjectInstance \"ball\" "
      "AttributeEnd ObjectEnd\n"
      "ObjectInstance \"row\" Translate 0 4 0 ObjectInstance \"row\" Scale -1 1 1 ObjectInstance \"row\"");
  ASSERT_EQ(scene.geometry.instances.size(), 5u);
  EXPECT_EQ(scene.geometry.instances[2].to_world.translation.x, 3);
  EXPECT_EQ(scene.geometry.instances[2].to_world.translation.y, 4);
  EXPECT_EQ(scene.geometry.instances[4].to_world.translation.x, -3);
}

TEST(PbrtShape, InstancesWithoutNormalsKeepTheirOutside) {
  const std::string object = std::string("WorldBegin ObjectBegin \"o\" ") + pbrt_testing::kTriangle + "ObjectEnd\n";
  EXPECT_EQ(load_text(object + "ObjectInstance \"o\"").geometry.normal(0).z, 1);
  EXPECT_EQ(load_text(object + "Scale -1 1 1 ObjectInstance \"o\"").geometry.normal(0).z, 1);
  EXPECT_EQ(load_text(object + "Scale 1 1 -1 ObjectInstance \"o\"").geometry.normal(0).z, -1);
}

TEST(PbrtShape, ObjectsAppearOnlyAsInstances) {
  EXPECT_EQ(shape(std::string("ObjectBegin \"o\" ") + pbrt_testing::kTriangle + "ObjectEnd").triangle_count(), 0u);
}

TEST(PbrtShape, AttributeGivesDefaults) {
  const Geometry mesh = shape("Attribute \"shape\" \"float radius\" 2 Shape \"sphere\"");
  EXPECT_NEAR(mesh.bounds().max.x, 2, 2e-3);
  const Geometry own = shape("Attribute \"shape\" \"float radius\" 2 Shape \"sphere\" \"float radius\" 3");
  EXPECT_NEAR(own.bounds().max.x, 3, 3e-3);
  const Geometry ended = shape("AttributeBegin Attribute \"shape\" \"float radius\" 2 AttributeEnd Shape \"sphere\"");
  EXPECT_NEAR(ended.bounds().max.x, 1, 1e-3);
}

TEST(PbrtShape, InterfacesAndFullyTransparentShapesAreRemoved) {
  const std::string triangle = pbrt_testing::kTriangle;
  const SceneDescription scene = load_text("WorldBegin Translate 99 0 0 Material \"interface\" " + triangle +
                                           "Identity Material \"diffuse\" " + triangle);
  EXPECT_EQ(scene.geometry.triangle_count(), 1u);
  EXPECT_EQ(scene.geometry.bounds().max.x, 1);
  EXPECT_TRUE(has_note(scene, "1 triangles of an \"interface\" material"));
}

TEST(PbrtShape, UnsupportedShapesAreNotedAndLeftOut) {
  const SceneDescription scene =
      load_text("WorldBegin Shape \"curve\" \"point3 P\" [0 0 0] Shape \"curve\" Shape \"sphere\"");
  EXPECT_GT(scene.geometry.triangle_count(), 0u);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(scene.notes[0].starts_with("not supported, left out: shape \"curve\" ("));
  EXPECT_TRUE(scene.notes[0].ends_with("scene.pbrt:1:12, and 1 more)")) << scene.notes[0];
}

TEST(PbrtShape, DegenerateTrianglesAreLeftOutAndCounted) {
  const SceneDescription scene = load_text(
      "WorldBegin Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 0 1 0 1 1] \"point3 P\" [0 0 0 1 0 0 0 1 0]");
  EXPECT_EQ(scene.geometry.triangle_count(), 1u);
  EXPECT_TRUE(has_note(scene, "left out: triangles without area of a trianglemesh"));
  EXPECT_TRUE(scene.notes[0].ends_with("and 1 more)"));
}

TEST(PbrtShape, ObjectsHaveTheNamesOfTheirShapes) {
  const Geometry mesh = shape("Shape \"disk\" \"string name\" \"top\" Shape \"disk\"");
  ASSERT_EQ(mesh.objects.size(), 2u);
  EXPECT_EQ(mesh.objects[0].name, "top");
  EXPECT_EQ(mesh.objects[1].name, "disk 2");
}

TEST(PbrtShape, MistakesAreErrorsWithPlaces) {
  const struct {
    const char *text, *message;
  } kCases[] = {
      {"Shape \"shpere\"", "scene.pbrt:1:1: unknown shape \"shpere\""},
      {"Shape \"sphere\" \"float radius\" 0", "scene.pbrt:1:1: the radius of a sphere must be positive"},
      {"Shape \"sphere\" \"float zmin\" 2 \"float zmax\" 3", "leave nothing of the sphere"},
      {"Shape \"sphere\" \"float phimax\" 0", "phimax must be positive"},
      {"Shape \"disk\" \"float innerradius\" 1", "the radii of a disk enclose no area"},
      {"Shape \"cylinder\" \"float zmin\" 1", "a cylinder without radius or height"},
      {"Shape \"trianglemesh\"", "a mesh without points"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1]", "parameter \"P\" has 4 values, which is not a multiple of 3"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0]", "a mesh without indices"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1 3]",
       "scene.pbrt:1:53: index 3 does not fit 3 vertices"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1 -1]", "index -1 does not fit"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1]",
       "2 indices are not a multiple of 3"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"normal N\" [0 0 1]", "1 normals N for 3 points P"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"point2 uv\" [0 0]", "1 uv for 3 points P"},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0]", "a mesh without indices"},
      {"Shape \"plymesh\"", "a plymesh without a file name"},
      {"Shape \"plymesh\" \"string filename\" \"no.ply\"",
       "scene.pbrt:1:17: cannot read \"no.ply\": no.ply: no such file"},
      {"Shape \"loopsubdiv\" \"integer levels\" -1 \"point3 P\" [0 0 0 1 0 0 1 1 0]", "-1 levels of subdivision"},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_NE(error_of(text).find(message), std::string::npos) << text << "\n" << error_of(text);
  }
}

}  // namespace
}  // namespace glowworm
