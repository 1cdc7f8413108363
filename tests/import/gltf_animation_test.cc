// Moments of glTF animations.
#include <algorithm>
#include <array>
#include <cmath>

#include "gltf_file.h"
#include "import/gltf/animation.h"
#include "scene/light_rig.h"

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

TEST_F(GltfAnimationTest, AReaderOfSeveralMomentsChangesNothing) {
  const std::string path = write_gltf(moving_file(0));
  ImportOptions kept;
  kept.gltf = gltf_reader();
  for (const Moment& moment : {Moment{"", 0.5}, Moment{"", 1.5}, Moment{"back", 0.5}, Moment{"", 0.5}}) {
    ImportOptions fresh;
    fresh.moment = kept.moment = moment;
    EXPECT_EQ(load_scene(path, kept).geometry.positions, load_scene(path, fresh).geometry.positions);
  }
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

TEST_F(GltfAnimationTest, SlicesOfTheShutterHaveCamerasOfTheirOwn) {
  const auto motion = std::make_shared<SceneMotion>();
  motion->is_still = true;
  motion->frames = 1;
  motion->start = 0.5;
  motion->shutter = Shutter{0, 1};
  motion->slices = 4;
  const SceneDescription d = load_at(moving_file(1), {"", 0.5}, motion);
  EXPECT_EQ(motion->frames, 1u);
  EXPECT_EQ(motion->length, 2);
  EXPECT_FALSE(motion->anything_else_moves);
  ASSERT_EQ(d.cameras.size(), 6u);
  for (std::uint32_t slice = 1; slice <= 4; ++slice) {
    const Camera& camera = d.cameras[slice + 1];
    EXPECT_EQ(camera.name, (FrameMoment{0, slice}.camera()));
    // 4 m in a second, from 2 m on.
    EXPECT_GE(camera.to_world.translation.x, 1 + static_cast<float>(slice));
    EXPECT_LE(camera.to_world.translation.x, 2 + static_cast<float>(slice));
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

/// A triangle of one material, and a point light, which an animation moves by pointers between 0 and 2 s.
class GltfPointerTest : public GltfTest {
 protected:
  GltfPointerTest() {
    file_.add_shown_triangle({{"emissiveFactor", {1, 0, 0}}});
    file_.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    file_.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_animation_pointer"};
    file_.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 683}}};
    file_.add("animations", {{"samplers", json::array()}, {"channels", json::array()}});
  }
  void move(const std::string& pointer, const std::vector<float>& values, const char* type) {
    json& animation = file_.json["animations"][0];
    const int times = file_.add_accessor<float>({0, 2}, 5126, "SCALAR", 2);
    animation["samplers"].push_back({{"input", times}, {"output", file_.add_accessor(values, 5126, type, 2)}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1},
         {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  }
  SceneDescription at(double seconds) const {
    ImportOptions options;
    options.moment.seconds = seconds;
    return load_scene(write_gltf(file_), options);
  }
  GltfFile file_;
};

TEST_F(GltfPointerTest, LampsOfOneNameKeepTheirNumbersWhereOneIsBlack) {
  file_.json["materials"][0]["name"] = "lamp";
  file_.add_shown_triangle({{"name", "lamp"}, {"emissiveFactor", {0, 1, 0}}});
  move("/materials/0/emissiveFactor", {1, 0, 0, 0, 0, 0}, "VEC3");
  const auto names_at = [&](double seconds) {
    std::vector<std::string> names;
    const LightRig rig(std::make_shared<const Scene>(at(seconds)));
    for (const RigLight& light : rig.lights())
      if (light.kind == RigLightKind::area) names.push_back(light.name);
    return names;
  };
  EXPECT_EQ(names_at(0), (std::vector<std::string>{"lamp 1", "lamp 2"}));
  EXPECT_EQ(names_at(2), (std::vector<std::string>{"lamp 2"}));
}

TEST_F(GltfPointerTest, EmissionAndLightsChange) {
  move("/materials/0/emissiveFactor", {0, 1, 0, 0, 0, 1}, "VEC3");
  move("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", {2, 6}, "SCALAR");
  move("/extensions/KHR_lights_punctual/lights/0/intensity", {0, 1366}, "SCALAR");
  move("/extensions/KHR_lights_punctual/lights/0/color", {1, 1, 1, 1, 0, 1}, "VEC3");
  const SceneDescription half = at(1), end = at(5);
  ASSERT_EQ(half.emissions.size(), 1u);
  const RGB glow = half.emissions[0].radiance.value;
  EXPECT_FLOAT_EQ(glow.g, 2);
  EXPECT_FLOAT_EQ(glow.b, 2);
  EXPECT_FLOAT_EQ(glow.r, 0);
  EXPECT_FLOAT_EQ(end.emissions[0].radiance.value.b, 6);
  ASSERT_EQ(half.lights.size(), 1u);
  EXPECT_FLOAT_EQ(half.lights[0].intensity.g / half.lights[0].intensity.r, 0.5f);
  EXPECT_FLOAT_EQ(end.lights[0].intensity.r / half.lights[0].intensity.r, 2);
  const auto motion = std::make_shared<SceneMotion>();
  ImportOptions options;
  options.motion = motion;
  load_scene(write_gltf(file_), options);
  EXPECT_TRUE(motion->anything_else_moves);
}

TEST_F(GltfPointerTest, AReaderOfSeveralMomentsChangesNothing) {
  move("/materials/0/emissiveFactor", {0, 1, 0, 0, 0, 1}, "VEC3");
  const std::string path = write_gltf(file_);
  ImportOptions options;
  options.gltf = gltf_reader();
  for (const double seconds : {0.0, 1.0, 2.0}) {
    options.moment.seconds = seconds;
    const SceneDescription d = load_scene(path, options);
    ASSERT_EQ(d.emissions.size(), 1u);
    EXPECT_EQ(d.emissions[0].radiance.value, at(seconds).emissions[0].radiance.value) << seconds;
  }
}

TEST_F(GltfPointerTest, TexturesTurn) {
  write("t.tga", tga_row({{0, 0, 0, 255}}));
  file_.add("images", {{"uri", "t.tga"}});
  file_.add("textures", {{"source", 0}});
  file_.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 0.0}}}}}};
  move("/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation", {0, 1},
       "SCALAR");
  const SceneDescription d = at(1);
  EXPECT_TRUE(std::any_of(d.textures.begin(), d.textures.end(),
                          [](const TextureNode& node) { return std::abs(node.uv_rotation) == 0.5f; }));
}

TEST_F(GltfPointerTest, MaterialsAndNodesChange) {
  move("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 0, 0, 1, 1, 1, 1, 1}, "VEC4");
  move("/nodes/0/translation", {0, 0, 0, 8, 0, 0}, "VEC3");
  const SceneDescription d = at(0.5);
  EXPECT_FLOAT_EQ(d.geometry.positions[d.geometry.triangles[0][0]].x, 2);
  EXPECT_FLOAT_EQ(d.materials[0].reflectance.value.r, 0.25f);
}

TEST_F(GltfPointerTest, CamerasOfAllFramesFollowPointers) {
  file_.add("nodes", {{"children", {file_.json["nodes"].size() + 1}}});
  const std::string arm = std::to_string(file_.json["nodes"].size() - 1);
  file_.add("nodes", {{"camera", 0}});
  file_.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
  move("/nodes/" + arm + "/translation", {0, 0, 0, 8, 0, 0}, "VEC3");
  move("/cameras/0/perspective/yfov", {1, 2}, "SCALAR");
  ImportOptions options;
  options.motion = std::make_shared<SceneMotion>();
  options.motion->frames_per_second = 1;
  const SceneDescription d = load_scene(write_gltf(file_), options);
  EXPECT_FALSE(options.motion->anything_else_moves);
  ASSERT_EQ(d.cameras.size(), 4u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto t = static_cast<float>(i);
    EXPECT_FLOAT_EQ(d.cameras[i + 1].to_world.translation.x, 4 * t);
    EXPECT_FLOAT_EQ(d.cameras[i + 1].half_extent, std::tan((1 + t / 2) / 2));
  }
}

TEST_F(GltfPointerTest, WhatDoesNotExistIsLeftOut) {
  // Indices are no quantities.
  for (const char* pointer :
       {"/materials/7/emissiveFactor", "/nodes/0/mesh", "/lights/0/intensity", "/accessors/0/count", ""})
    move(pointer, {0, 9}, "SCALAR");
  EXPECT_FLOAT_EQ(at(1).emissions[0].radiance.value.r, 1);
  move("materials", {0, 1}, "SCALAR");
  EXPECT_THAT(refusal(file_), HasSubstr("'materials', which is no JSON pointer"));
}

}  // namespace
}  // namespace glowworm
