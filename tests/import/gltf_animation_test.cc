// Moments of glTF animations.
#include <array>
#include <cmath>

#include "gltf_file.h"
#include "import/gltf/animation.h"

namespace glowworm {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::array<float, 3> kTimes = {1, 2, 4};

float value(const std::vector<float>& values, GltfInterpolation interpolation, double seconds) {
  return gltf_value_at(kTimes, values, 1, interpolation, false, seconds)[0];
}

TEST(GltfValueAt, InterpolatesBetweenKeys) {
  const std::vector<float> values = {10, 20, 40};
  for (const GltfInterpolation how : {GltfInterpolation::step, GltfInterpolation::linear}) {
    EXPECT_EQ(value(values, how, 0), 10);
    EXPECT_EQ(value(values, how, 2), 20);
    EXPECT_EQ(value(values, how, 9), 40);
  }
  EXPECT_FLOAT_EQ(value(values, GltfInterpolation::linear, 1.25), 12.5f);
  EXPECT_FLOAT_EQ(value(values, GltfInterpolation::linear, 3), 30);
  EXPECT_FLOAT_EQ(value(values, GltfInterpolation::step, 3.9), 20);
}

TEST(GltfValueAt, CubicSplinesHaveTheTangentsOfTheirKeys) {
  // t^2 - t: a cubic spline through its values and slopes is the same.
  std::vector<float> values;
  for (const float t : kTimes) values.insert(values.end(), {2 * t - 1, t * t - t, 2 * t - 1});
  for (const double t : {1.0, 1.3, 2.0, 2.5, 3.7, 4.0})
    EXPECT_NEAR(value(values, GltfInterpolation::cubic, t), t * t - t, 1e-5) << t;
}

TEST(GltfValueAt, RotationsTurnEvenlyAlongTheShorterArc) {
  const auto turn = [](double degrees, double sign) {
    const double half = degrees * 3.14159265358979 / 360;
    return std::array<float, 4>{0, 0, static_cast<float>(sign * std::sin(half)),
                                static_cast<float>(sign * std::cos(half))};
  };
  const std::array<float, 2> times = {0, 1};
  for (const double sign : {1.0, -1.0}) {
    const auto from = turn(10, 1), to = turn(100, sign);
    std::vector<float> values(from.begin(), from.end());
    values.insert(values.end(), to.begin(), to.end());
    const std::vector<float> q = gltf_value_at(times, values, 4, GltfInterpolation::linear, true, 1.0 / 3);
    const auto wanted = turn(40, 1);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(q[i], wanted[i], 1e-6) << sign;
  }
}

class GltfAnimationTest : public GltfTest {
 protected:
  /// A triangle and a camera, of which node `moving` (0 or 1) goes from (0,0,0) to (8,0,0) between 0 and 2 s, and, as
  /// animation "back", from (8,0,0) to (0,0,0).
  static GltfFile moving_file(int moving) {
    GltfFile file;
    file.add("nodes", {{"mesh", file.add_triangle()}});
    file.add("nodes", {{"camera", 0}, {"name", "eye"}});
    file.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
    const int times = file.add_accessor<float>({0, 2}, 5126, "SCALAR", 2);
    for (const bool back : {false, true}) {
      const int places = back ? file.add_accessor<float>({8, 0, 0, 0, 0, 0}, 5126, "VEC3", 2)
                              : file.add_accessor<float>({0, 0, 0, 8, 0, 0}, 5126, "VEC3", 2);
      file.add("animations",
               {{"name", back ? "back" : "forth"},
                {"samplers", {{{"input", times}, {"output", places}}}},
                {"channels", {{{"sampler", 0}, {"target", {{"node", moving}, {"path", "translation"}}}}}}});
    }
    return file;
  }
  SceneDescription load_at(const GltfFile& file, const Moment& moment,
                           const std::shared_ptr<SceneMotion>& motion = nullptr) const {
    ImportOptions options;
    options.moment = moment;
    options.motion = motion;
    return load_scene(write_gltf(file), options);
  }
};

TEST_F(GltfAnimationTest, MomentsPlaceMeshes) {
  const GltfFile file = moving_file(0);
  const auto x_at = [&](const Moment& moment) {
    const SceneDescription d = load_at(file, moment);
    return d.geometry.positions[d.geometry.triangles[0][0]].x;
  };
  EXPECT_FLOAT_EQ(x_at({}), 0);
  EXPECT_FLOAT_EQ(x_at({"", 0.5}), 2);
  EXPECT_FLOAT_EQ(x_at({"forth", 1.5}), 6);
  EXPECT_FLOAT_EQ(x_at({"back", 0.5}), 6);
  EXPECT_FLOAT_EQ(x_at({"1", 9}), 0);
}

TEST_F(GltfAnimationTest, CamerasOfAllFramesAreRead) {
  const auto motion = std::make_shared<SceneMotion>();
  motion->frames_per_second = 2;
  const SceneDescription d = load_at(moving_file(1), {}, motion);
  EXPECT_EQ(motion->frames, 5u);
  EXPECT_FALSE(motion->anything_else_moves);
  ASSERT_EQ(d.cameras.size(), 6u);
  EXPECT_EQ(d.cameras[0].name, "eye");
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(d.cameras[i + 1].name, FrameMoment{i}.camera());
    EXPECT_FLOAT_EQ(d.cameras[i + 1].to_world.translation.x, 2 * static_cast<float>(i));
  }
}

TEST_F(GltfAnimationTest, KnowsWhetherMeshesMove) {
  const auto motion = std::make_shared<SceneMotion>();
  load_at(moving_file(0), {}, motion);
  EXPECT_TRUE(motion->anything_else_moves);
}

TEST_F(GltfAnimationTest, RefusesWhatIsNotThere) {
  const auto message = [&](const auto& load) -> std::string {
    try {
      load();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message([&] { load_at(moving_file(0), {"up", 0}); }), HasSubstr("'forth', 'back'"));
  GltfFile still;
  still.add("nodes", {{"mesh", still.add_triangle()}});
  EXPECT_THAT(message([&] { load_at(still, {"", 1}); }), HasSubstr("no animation"));
  ImportOptions options;
  options.moment.seconds = 1;
  EXPECT_THAT(message([&] { load_scene("builtin:cornell", options); }), HasSubstr("no animation"));
}

}  // namespace
}  // namespace glowworm
