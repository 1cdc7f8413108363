// Files whose coordinates have more digits than float, as those of maps: two sheets one millimetre apart.
#include <fmt/format.h>

#include <cmath>

#include "gltf_file.h"
#include "scene/scene.h"

namespace glowworm {
namespace {

constexpr double kEast = 512345.123, kNorth = 5412345.456, kUp = 101.25, kApart = 0.001;

using Corners = std::vector<std::array<double, 3>>;

/// A triangle of half a metre, raised.
Corners sheet(double raised) {
  const double z = kUp + raised;
  return {{kEast, kNorth, z}, {kEast + 0.5, kNorth, z}, {kEast, kNorth + 0.5, z}};
}

std::string text_of(const Corners& corners, const std::string& before = "") {
  std::string text;
  for (const auto& [x, y, z] : corners) text += fmt::format("{}{:.4f} {:.4f} {:.4f}\n", before, x, y, z);
  return text;
}

class FarTest : public GltfTest {
 protected:
  /// Checks that the sheets of a scene have their distance and their places.
  static void check(const SceneDescription& d, const std::string& what) {
    EXPECT_TRUE(d.origin_is_exact) << what;
    ASSERT_EQ(d.geometry.triangle_count(), 2u) << what;
    const auto corner = [&](std::size_t triangle) { return d.geometry.positions[d.geometry.triangles[triangle][0]]; };
    EXPECT_NEAR(std::abs(corner(0).z - corner(1).z), kApart, 1e-5) << what;
    EXPECT_NEAR(double{corner(0).x} + d.origin.x, kEast, 1e-4) << what;
    EXPECT_NEAR(double{corner(0).y} + d.origin.y, kNorth, 1e-4) << what;
    EXPECT_NEAR(d.geometry.area(0), 0.125, 1e-4) << what;
  }
  static std::string ply(const std::string& format, const std::string& type, const std::string& data) {
    return "ply\nformat " + format + " 1.0\nelement vertex 6\nproperty " + type + " x\nproperty " + type +
           " y\nproperty " + type + " z\nelement face 2\nproperty list uchar uchar vertex_indices\nend_header\n" + data;
  }
};

TEST_F(FarTest, TextKeepsItsDigits) {
  const std::string lower = text_of(sheet(0)), upper = text_of(sheet(kApart));
  // A vertex that no face uses does not count.
  const std::string obj = "v 0 0 0\n" + text_of(sheet(0), "v ") + text_of(sheet(kApart), "v ");
  check(load_scene(write("a.obj", obj + "f 2 3 4\nf 5 6 7\n")), "OBJ");
  check(load_scene(write("a.ply", ply("ascii", "float", lower + upper + "3 0 1 2\n3 3 4 5\n"))), "ASCII PLY");
  std::string stl = "solid a\n";
  for (const double raised : {0.0, kApart})
    stl += "facet normal 0 0 1\nouter loop\n" + text_of(sheet(raised), "vertex ") + "endloop\nendfacet\n";
  check(load_scene(write("a.stl", stl + "endsolid a\n")), "ASCII STL");
  const std::string shape = "Shape \"trianglemesh\" \"point3 P\" [ ";
  check(load_scene(write("a.pbrt", "WorldBegin\n" + shape + lower + "]\n" + shape + upper + "]\n")), "pbrt");
}

TEST_F(FarTest, DoublesKeepTheirDigits) {
  std::string data;
  for (const double raised : {0.0, kApart})
    for (const auto& corner : sheet(raised)) append_bytes<double>(data, {corner[0], corner[1], corner[2]});
  data += std::string("\3\0\1\2\3\3\4\5", 8);
  write("b.ply", ply("binary_little_endian", "double", data));
  check(load_scene(path("b.ply")), "PLY");
  check(load_scene(write("b.pbrt", "WorldBegin Shape \"plymesh\" \"string filename\" \"b.ply\"\n")), "pbrt");
}

TEST_F(FarTest, TransformsKeepTheirDigits) {
  const auto place = [](double raised) { return fmt::format("{} {} {:.4f}", kEast, kNorth, kUp + raised); };
  const std::string small = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 0.5 0 0 0 0.5 0 ]\n";
  std::string pbrt = fmt::format("LookAt {} {} 103 {} {} 101 0 1 0\nCamera \"perspective\"\nWorldBegin\n", kEast + 0.25,
                                 kNorth, kEast + 0.25, kNorth);
  for (const double raised : {0.0, kApart})
    pbrt += "AttributeBegin\nTranslate " + place(raised) + "\nRotate 90 0 0 1\nRotate -90 0 0 1\n" + small +
            "LightSource \"point\" \"point3 from\" [ 0 0 0.25 ]\nAttributeEnd\n";
  const auto d = load_scene(write("c.pbrt", pbrt));
  check(d, "pbrt");
  EXPECT_NEAR(d.lights.at(1).position.z - d.lights.at(0).position.z, kApart, 1e-5);
  EXPECT_NEAR(double{d.cameras.at(0).to_world.translation.x} + d.origin.x, kEast + 0.25, 1e-4);
  GltfFile file;
  const int mesh = file.add(
      "meshes", {{"primitives",
                  {{{"attributes",
                     {{"POSITION", file.add_accessor<float>({0, 0, 0, 0.5f, 0, 0, 0, 0.5f, 0}, 5126, "VEC3", 3)}}}}}}});
  file.add("nodes", {{"mesh", mesh}, {"translation", {kEast, kNorth, kUp}}});
  file.add("nodes", {{"children", {2}}, {"translation", {kEast, kNorth, kUp}}});
  file.add("nodes", {{"mesh", mesh}, {"translation", {0, 0, kApart}}});
  file.add("scenes", {{"nodes", {0, 1}}});
  check(load(file), "glTF");
}

/// In floats, all triangles of so small a shape are points.
TEST_F(FarTest, SmallShapesFarAwayHaveTriangles) {
  std::string obj;
  for (const double x : {0.0, 0.01, 0.0})
    for (const double y : {0.0, 0.01}) obj += fmt::format("v {:.3f} {:.3f} 0\n", kEast + x, kNorth + y);
  const auto d = load_scene(write("a.obj", obj + "f 1 3 2\n"));
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_NEAR(d.geometry.area(0), 0.00005, 1e-7);
  EXPECT_THAT(message_of(write("b.obj", "v 5e6 0 0\nv 5e6 0 0\nv 5e6 0 0\nf 1 2 3\n")),
              testing::HasSubstr("has no triangles"));
}

TEST_F(FarTest, ScenesSayWhatWasSubtracted) {
  const std::string obj = text_of(sheet(0), "v ") + text_of(sheet(kApart), "v ") + "f 1 2 3\nf 4 5 6\n";
  const Scene scene(load_scene(write("a.obj", obj)));
  EXPECT_THAT(scene.notes(), HasNote("m is subtracted from its coordinates"));
  EXPECT_THAT(scene.notes(), testing::Not(HasNote("coordinates are rounded")));
  EXPECT_NEAR(scene.outside(scene.center()).y, kNorth + 0.25, 1e-3);
  // Floats were rounded before they were read.
  std::string stl(80, ' ');
  append_bytes<std::uint32_t>(stl, {1});
  append_bytes<float>(stl, {0, 0, 1, 5e5f, 5e6f, 0, 5e5f + 1, 5e6f, 0, 5e5f, 5e6f + 1, 0});
  const Scene rounded(load_scene(write("b.stl", stl + std::string(2, '\0'))));
  EXPECT_THAT(rounded.notes(), HasNote("m is subtracted from its coordinates"));
  EXPECT_THAT(rounded.notes(), HasNote("coordinates are rounded"));
}

TEST_F(FarTest, NearFilesKeepTheirCoordinates) {
  const auto d = load_scene(write("a.obj", "v 100.1 0 0\nv 101 0 0\nv 100.1 1 0\nf 1 2 3\n"));
  EXPECT_EQ(d.origin, (Vec3{0, 0, 0}));
  EXPECT_EQ(d.geometry.positions[0].x, 100.1f);
}

}  // namespace
}  // namespace glowworm
