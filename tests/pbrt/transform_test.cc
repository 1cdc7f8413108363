#include <gtest/gtest.h>

#include <cmath>

#include "import/pbrt/builder.h"
#include "pbrt/pbrt_testing.h"
#include "scene/camera.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::expect_near;
using pbrt_testing::kTriangle;
using pbrt_testing::load_text;

/// Where directives before a shape at (1, 2, 3) put it.
Vec3 moved(const std::string& directives, const std::string& before_world = "") {
  const SceneDescription scene =
      load_text(before_world + "WorldBegin\n" + directives +
                "\nShape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [1 2 3  2 2 3  1 3 3]");
  return scene.geometry.positions.at(0);
}

TEST(PbrtTransform, EachDirectiveByHand) {
  expect_near(moved(""), {1, 2, 3});
  expect_near(moved("Translate 10 20 30"), {11, 22, 33});
  expect_near(moved("Scale 2 3 -4"), {2, 6, -12});
  expect_near(moved("Rotate 90 0 0 1"), {-2, 1, 3});  // x to y
  expect_near(moved("Rotate 90 1 0 0"), {1, -3, 2});  // y to z
  expect_near(moved("Rotate 90 0 2 0"), {3, 2, -1});  // z to x; the axis need not be unit
  expect_near(moved("Rotate 120 1 1 1"), {3, 1, 2});  // x to y to z to x
  expect_near(moved("Translate 9 9 9 Identity"), {1, 2, 3});
  // Columns one after another, the translation last.
  expect_near(moved("Transform [0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1]"), {3, 7, 10});
  expect_near(moved("Transform [0 2 0 0  -2 0 0 0  0 0 2 0  10 12 14 2]"), {3, 7, 10});
}

TEST(PbrtTransform, LaterDirectivesActFirst) {
  expect_near(moved("Translate 10 0 0 Scale 2 2 2"), {12, 4, 6});
  expect_near(moved("Scale 2 2 2 Translate 10 0 0"), {22, 4, 6});
  expect_near(moved("Scale 2 2 2 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0  10 0 0 1]"), {22, 4, 6});
  expect_near(moved("Scale 2 2 2 Transform [1 0 0 0 0 1 0 0 0 0 1 0  10 0 0 1]"), {11, 2, 3});
}

TEST(PbrtTransform, StacksSaveAndRestore) {
  expect_near(moved("Translate 1 0 0 AttributeBegin Translate 5 5 5 AttributeEnd"), {2, 2, 3});
  expect_near(moved("Translate 1 0 0 TransformBegin Translate 5 5 5 TransformEnd"), {2, 2, 3});
  expect_near(moved("Translate 1 0 0 CoordinateSystem \"here\" Scale 9 9 9 CoordSysTransform \"here\""), {2, 2, 3});
  expect_near(moved("ActiveTransform EndTime Translate 9 9 9 ActiveTransform All Translate 1 0 0"), {2, 2, 3});
  expect_near(moved("Translate 1 0 0", "ActiveTransform EndTime "), {2, 2, 3});
}

TEST(PbrtTransform, TransformEndKeepsAttributes) {
  // ReverseOrientation inside TransformBegin holds on; inside AttributeBegin it does not.
  const auto normal_z = [](const std::string& directives) {
    return load_text("WorldBegin " + directives + "\n" + kTriangle).geometry.normal(0).z;
  };
  EXPECT_EQ(normal_z(""), 1);
  EXPECT_EQ(normal_z("TransformBegin ReverseOrientation TransformEnd"), -1);
  EXPECT_EQ(normal_z("AttributeBegin ReverseOrientation AttributeEnd"), 1);
  EXPECT_EQ(normal_z("ReverseOrientation ReverseOrientation"), 1);
  // Mirroring does not turn the inside out.
  EXPECT_EQ(normal_z("Scale -1 1 1"), 1);
  EXPECT_EQ(normal_z("Scale 1 1 -1"), -1);
  EXPECT_EQ(normal_z("Scale -1 1 1 ReverseOrientation"), -1);
}

TEST(PbrtTransform, MistakesAreErrors) {
  EXPECT_NE(error_of("Rotate 90 0 0 0").find("scene.pbrt:1:1: Rotate around an axis of zero length"),
            std::string::npos);
  EXPECT_NE(error_of("LookAt 0 0 0 0 0 0 0 1 0").find("scene.pbrt:1:1: LookAt"), std::string::npos);
  EXPECT_NE(error_of("LookAt 0 0 0 0 1 0 0 1 0").find("scene.pbrt:1:1: LookAt"), std::string::npos);
  EXPECT_NE(error_of("Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]").find("not affine"), std::string::npos);
  EXPECT_NE(error_of("CoordSysTransform \"x\"").find("no coordinate system \"x\""), std::string::npos);
  EXPECT_NE(error_of("Scale 0 1 1 Camera \"perspective\"").find("cannot be inverted"), std::string::npos);
}

/// The ray through a point of a picture of 200 x 100 pixels, given from -1 to 1, right and up.
CameraRay ray(const SceneDescription& scene, float right, float up) {
  return generate_ray(scene.cameras.at(0), {100 + 100 * right, 50 - 50 * up}, 200, 100, {0.5f, 0.5f});
}

TEST(PbrtCamera, SphericalTurnsFromPlusXAroundUp) {
  const SceneDescription scene = load_text("Camera \"spherical\" \"string mapping\" \"equirectangular\"");
  expect_near(ray(scene, 0, 0).direction, {-1, 0, 0});
  expect_near(ray(scene, -0.5f, 0).direction, {0, 0, 1});
  expect_near(ray(scene, 0.5f, 0).direction, {0, 0, -1});
  EXPECT_GT(ray(scene, 0, 0.99f).direction.y, 0.99f);
}

TEST(PbrtCamera, LookAtIsLeftHanded) {
  // From +z towards the origin, y up: +x is to the LEFT in pbrt's left-handed camera space.
  const SceneDescription scene = load_text("LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 90");
  const CameraRay center = ray(scene, 0, 0);
  expect_near(center.origin, {0, 0, 5});
  expect_near(center.direction, {0, 0, -1});
  EXPECT_LT(ray(scene, 0.5f, 0).direction.x, 0);
  EXPECT_GT(ray(scene, 0, 0.5f).direction.y, 0);
}

TEST(PbrtCamera, MirroredByScale) {
  const SceneDescription scene =
      load_text("Scale -1 1 1 LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 90");
  expect_near(ray(scene, 0, 0).origin, {0, 0, 5});
  expect_near(ray(scene, 0, 0).direction, {0, 0, -1});
  EXPECT_GT(ray(scene, 0.5f, 0).direction.x, 0);
  EXPECT_GT(ray(scene, 0, 0.5f).direction.y, 0);
}

TEST(PbrtCamera, FieldOfViewIsAlongTheShorterSide) {
  const SceneDescription scene = load_text("Camera \"perspective\" \"float fov\" 90");
  // 200 x 100: 90 degrees from the lower to the upper edge.
  expect_near(ray(scene, 0, 1).direction, {0, std::sqrt(0.5f), std::sqrt(0.5f)});
  expect_near(ray(scene, 1, 0).direction, {2 / std::sqrt(5.0f), 0, 1 / std::sqrt(5.0f)});
}

TEST(PbrtCamera, WindowsAndAspect) {
  const SceneDescription window =
      load_text("Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [-2 1 -1 3]");
  const CameraRay upper_right = ray(window, 1, 1), lower_left = ray(window, -1, -1);
  expect_near(upper_right.direction / upper_right.direction.z, {1, 3, 1});
  expect_near(lower_left.direction / lower_left.direction.z, {-2, -1, 1});
  const SceneDescription wide = load_text("Camera \"perspective\" \"float fov\" 90 \"float frameaspectratio\" 4");
  EXPECT_NEAR(ray(wide, 1, 1).direction.x / ray(wide, 1, 1).direction.y, 4, 1e-5);
  const SceneDescription high = load_text("Camera \"perspective\" \"float fov\" 90 \"float frameaspectratio\" .5");
  const CameraRay corner = ray(high, 1, 1);
  expect_near(corner.direction / corner.direction.z, {1, 2, 1});
}

TEST(PbrtCamera, Orthographic) {
  const SceneDescription scene = load_text("LookAt 0 0 5  0 0 0  0 1 0 Camera \"orthographic\"");
  const CameraRay corner = ray(scene, 1, 1);
  expect_near(corner.direction, {0, 0, -1});
  expect_near(corner.origin, {-2, 1, 5});
}

TEST(PbrtCamera, ThinLens) {
  const SceneDescription scene =
      load_text("Camera \"perspective\" \"float fov\" 90 \"float lensradius\" .5 \"float focaldistance\" 4");
  EXPECT_EQ(scene.cameras[0].lens_radius, 0.5f);
  EXPECT_EQ(scene.cameras[0].focal_distance, 4);
  const CameraRay off = generate_ray(scene.cameras[0], {150, 20}, 200, 100, {0.9f, 0.3f});
  const CameraRay pinhole = ray(scene, 0.5f, 0.6f);
  // All rays through a point of the film meet at the focal distance.
  expect_near(off.origin + off.direction * ((4 - off.origin.z) / off.direction.z),
              pinhole.direction * (4 / pinhole.direction.z), 1e-4f);
}

TEST(PbrtCamera, OthersAreReplacedAndNoted) {
  const SceneDescription scene = load_text("Camera \"realistic\" \"string lensfile\" \"x.dat\"");
  EXPECT_TRUE(pbrt_testing::has_note(scene, "not supported, replaced by a perspective one: camera \"realistic\""));
  EXPECT_NE(error_of("Camera \"fisheye\"").find("unknown camera \"fisheye\""), std::string::npos);
  EXPECT_NE(error_of("Camera \"perspective\" \"float fov\" 180").find("a field of view of 180 degrees"),
            std::string::npos);
}

TEST(PbrtFilm, PixelBoundsFileNameAndWhatIsNotUsed) {
  const SceneDescription scene = load_text(
      "Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 360 \"string filename\" \"../up/a.exr\" "
      "\"integer pixelbounds\" [160 320 90 1000] Sampler \"halton\" \"integer pixelsamples\" 64 "
      "Integrator \"volpath\" \"integer maxdepth\" 5 PixelFilter \"gaussian\"");
  EXPECT_EQ(scene.film.crop[0], 0.25f);
  EXPECT_EQ(scene.film.crop[1], 0.5f);
  EXPECT_EQ(scene.film.crop[2], 0.25f);
  EXPECT_EQ(scene.film.crop[3], 1);
  EXPECT_EQ(scene.film.file, "a.exr");
  EXPECT_EQ(scene.film.samples, 64u);
  ASSERT_EQ(scene.notes.size(), 3u);
  EXPECT_NE(scene.notes[0].find("pixelsamples 64"), std::string::npos);
  EXPECT_NE(scene.notes[1].find("maxdepth 5"), std::string::npos);
  EXPECT_NE(scene.notes[2].find("pixel filter \"gaussian\""), std::string::npos);
  EXPECT_TRUE(load_text("PixelFilter \"box\"").notes.empty());
  EXPECT_NE(error_of("Film \"rgb\" \"integer pixelbounds\" [5 2 0 1]").find("pixelbounds"), std::string::npos);
}

TEST(PbrtFilm, SizeCropAndSensor) {
  const SceneDescription scene = load_text(
      "Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 360 \"float cropwindow\" [.25 .5 0 1] "
      "\"float iso\" 200 Camera \"perspective\" \"float shutterclose\" .25");
  EXPECT_EQ(scene.film.width, 640);
  EXPECT_EQ(scene.film.height, 360);
  EXPECT_EQ(scene.film.crop[0], 0.25f);
  EXPECT_EQ(scene.film.crop[1], 0.5f);
  EXPECT_FLOAT_EQ(scene.film.scale, 0.5f);
  EXPECT_EQ(load_text("Film \"rgb\"").film.scale, 1);
  // Not of pbrt-v3's.
  EXPECT_EQ(
      load_text("Film \"image\" Camera \"perspective\" \"float shutterclose\" .25 WorldBegin WorldEnd").film.scale, 1);
  EXPECT_NE(error_of("Film \"rgb\" \"integer xresolution\" 0").find("a picture of 0 x 720"), std::string::npos);
  EXPECT_NE(error_of("Film \"rgb\" \"float cropwindow\" [1 0 0 1]").find("cropwindow"), std::string::npos);
}

}  // namespace
}  // namespace glowworm
