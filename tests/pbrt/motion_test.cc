// Motion of pbrt scenes: transforms at two times, and what lies between.
#include "import/pbrt/motion.h"

#include "pbrt_testing.h"

namespace glowworm {
namespace {

using namespace pbrt_testing;

constexpr double kDegree = M_PI / 180;

/// A turn about the z axis after a scale.
TransformDouble turned(double degrees, Vec3d scale, Vec3d translation) {
  const double c = std::cos(degrees * kDegree), s = std::sin(degrees * kDegree);
  return {Vec3d{c, s, 0} * scale.x, Vec3d{-s, c, 0} * scale.y, Vec3d{0, 0, 1} * scale.z, translation};
}

void expect_same(const TransformDouble& a, const TransformDouble& b) {
  for (const auto& [u, v] : {std::pair{a.x, b.x}, {a.y, b.y}, {a.z, b.z}, {a.translation, b.translation}})
    EXPECT_LT(length(u - v), 1e-9);
}

TEST(PbrtMotion, InterpolatesTranslationRotationAndScaleEachForItself) {
  const PbrtTransforms ends{turned(10, {1, 2, 3}, {0, 0, 0}), turned(100, {3, 2, 1}, {9, 0, -3})};
  expect_same(*between(ends, 0), ends.start);
  expect_same(*between(ends, 1), ends.end);
  expect_same(*between(ends, 1.0 / 3), turned(40, {5.0 / 3, 2, 7.0 / 3}, {3, 0, -1}));
  // The shorter arc, also over half a turn.
  expect_same(*between({turned(170, {1, 1, 1}, {}), turned(-170, {1, 1, 1}, {})}, 0.25), turned(175, {1, 1, 1}, {}));
  // A mirroring at both ends stays.
  expect_same(*between({turned(0, {1, 1, -1}, {}), turned(90, {1, 1, -1}, {})}, 0.5), turned(45, {1, 1, -1}, {}));
  EXPECT_FALSE(between({turned(0, {1, 1, 1}, {}), turned(0, {1, 1, 0}, {})}, 0.5));
}

TEST(PbrtMotion, RotationsAboutAnyAxisAreFound) {
  // Half turns have no trace to go by.
  const TransformDouble still;
  for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
    const auto half_turn = [&](Vec3d v) { return axis * (2 * dot(axis, v)) - v; };
    const TransformDouble turn{half_turn({1, 0, 0}), half_turn({0, 1, 0}), half_turn({0, 0, 1}), {}};
    const TransformDouble quarter = *between({still, turn}, 0.5);
    expect_same(quarter * quarter, turn);
  }
}

constexpr const char* kMove = "ActiveTransform EndTime Translate 4 0 0 ActiveTransform All ";

Vec3 corner_at(const std::string& text, double seconds) {
  ImportOptions options;
  options.moment.seconds = seconds;
  return load_text(text, options).geometry.positions[0];
}

TEST(PbrtMotion, ShapesAreShownAtAMoment) {
  const std::string shape = std::string("WorldBegin ") + kMove + kTriangle;
  expect_near(corner_at(shape, 0), {0, 0, 0});
  expect_near(corner_at(shape, 0.25), {1, 0, 0});
  expect_near(corner_at(shape, 7), {4, 0, 0});
  expect_near(corner_at("TransformTimes 2 4 " + shape, 3), {2, 0, 0});
  // All of these act on both ends, or on the start alone.
  expect_near(corner_at(std::string("WorldBegin ") + kMove + "Translate 0 1 0 " + kTriangle, 0.5), {2, 1, 0});
  expect_near(
      corner_at(std::string("WorldBegin ActiveTransform StartTime Translate 2 0 0 ActiveTransform All ") + kTriangle,
                0.5),
      {1, 0, 0});
  // Two motions, of an object and its instance.
  expect_near(corner_at(std::string("WorldBegin ObjectBegin \"o\" ") + kMove + kTriangle + "ObjectEnd " + kMove +
                            "ObjectInstance \"o\"",
                        0.5),
              {4, 0, 0});
  expect_near(corner_at(std::string("WorldBegin TransformBegin ") + kMove + "CoordinateSystem \"there\" TransformEnd " +
                            "CoordSysTransform \"there\" " + kTriangle,
                        0.5),
              {2, 0, 0});
}

TEST(PbrtMotion, LightsAndCamerasMove) {
  const std::string text =
      std::string(kMove) + "Camera \"perspective\" WorldBegin " + kMove + "LightSource \"point\" " + kTriangle;
  ImportOptions options;
  options.moment.seconds = 0.5;
  options.motion = std::make_shared<SceneMotion>();
  options.motion->frames_per_second = 4;
  const SceneDescription scene = load_text(text, options);
  expect_near(scene.lights[0].position, {2, 0, 0});
  // The transform of a camera leads from the world to it.
  expect_near(scene.cameras[0].to_world.translation, {-2, 0, 0});
  EXPECT_TRUE(options.motion->anything_else_moves);
  EXPECT_EQ(options.motion->frames, 5u);
  ASSERT_TRUE(options.motion->shutter);
  EXPECT_EQ(*options.motion->shutter, (Shutter{0, 1}));
  const auto camera = [&](FrameMoment moment) {
    for (const Camera& c : scene.cameras)
      if (c.name == moment.camera()) return c.to_world.translation;
    return Vec3{99, 99, 99};
  };
  expect_near(camera({3, 0}), {-3, 0, 0});
  // The moment of the only slice lies within the second for which the shutter is open.
  const float within = -camera({0, 1}).x / 4;
  EXPECT_TRUE(within >= 0 && within <= 1) << within;
}

TEST(PbrtMotion, SaysWhatMoves) {
  const auto load_with = [](const std::string& text, bool is_still) {
    ImportOptions options;
    options.motion = std::make_shared<SceneMotion>();
    options.motion->is_still = is_still;
    options.motion->frames = is_still ? 1 : 0;
    load_text(text, options);
    return *options.motion;
  };
  const SceneMotion camera = load_with(std::string(kMove) + "Camera \"perspective\" WorldBegin " + kTriangle, true);
  EXPECT_FALSE(camera.anything_else_moves);
  EXPECT_TRUE(camera.shutter);
  EXPECT_EQ(camera.frames, 1u);
  EXPECT_FALSE(load_with(std::string("Camera \"perspective\" WorldBegin ") + kTriangle, true).shutter);
  EXPECT_THROW(load_with(std::string("WorldBegin ") + kTriangle, false), Error);
  EXPECT_TRUE(has_note(load_text(std::string("WorldBegin ") + kMove + kTriangle), "motion: the first moment is shown"));
}

TEST(PbrtMotion, MistakesAreErrorsWithTheirPlace) {
  ImportOptions half;
  half.moment.seconds = 0.5;
  EXPECT_NE(
      error_of(std::string("WorldBegin ActiveTransform EndTime\nScale 1 1 0 ActiveTransform All\n") + kTriangle, half)
          .find("scene.pbrt:3:1: the transform at the start or the end of the motion cannot be inverted"),
      std::string::npos);
  EXPECT_NE(error_of("\nTransformTimes 2 1").find("scene.pbrt:2:1: TransformTimes end before they start"),
            std::string::npos);
  half.moment.animation = "walk";
  EXPECT_NE(error_of(std::string("WorldBegin ") + kTriangle, half).find("no names"), std::string::npos);
  half.moment.animation = "";
  EXPECT_NE(error_of(std::string("WorldBegin ") + kTriangle, half).find("nothing moves"), std::string::npos);
}

}  // namespace
}  // namespace glowworm
