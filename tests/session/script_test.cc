// Scripts: valid content, effects, and errors for invalid ones.
#include "session/script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/frame.h"
#include "session/camera_control.h"
#include "session/session_testing.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

class ScriptTest : public testing::Test {
 protected:
  ScriptTest() : session_(test_scene("atrium"), {}), state_(small_state(session_)) {}

  void play_all(const std::string& text, std::uint32_t frames) {
    const Script script = parse_script(text, "test.json");
    for (std::uint32_t i = 0; i < frames; ++i) play(script, i, session_.scene(), session_.rig(), nullptr, state_);
  }

  Session session_;
  ViewState state_;
};

TEST_F(ScriptTest, SpreadsMovesOverFrames) {
  const Camera before = state_.camera;
  play_all(R"({"moves": [{"from": 2, "to": 12, "fly": [0, 0, 5]}]})", 20);
  EXPECT_LT(length(state_.camera.to_world.translation - before.to_world.translation - forward(before) * 5), 1e-4f);
  const Camera there = state_.camera;
  play_all(R"({"moves": [{"from": 0, "to": 9, "orbit": [360, 0]}]})", 9);
  EXPECT_LT(length(state_.camera.to_world.translation - there.to_world.translation), 1e-2f);
}

TEST_F(ScriptTest, SetsTheNamedValues) {
  play_all(R"({"moves": [{"at": 1, "mode": "photons", "engine": "forward", "kernel": "cone", "part": "indirect",
              "gather": 64, "photons": 1000, "nearest": 20, "filter": true, "reuse": false, "secondary_gather": false}]})",
           3);
  EXPECT_EQ(state_.mode, ViewMode::photons);
  EXPECT_EQ(state_.engine, "forward");
  EXPECT_EQ(state_.kernel, KernelShape::cone);
  EXPECT_EQ(state_.part, LightPart::indirect);
  EXPECT_EQ(state_.gather, 64u);
  EXPECT_EQ(state_.photons, 1000u);
  EXPECT_EQ(state_.nearest, 20u);
  EXPECT_TRUE(state_.filter);
  EXPECT_FALSE(state_.reuse);
  EXPECT_FALSE(state_.secondary_gather);
}

TEST_F(ScriptTest, MovesTheSun) {
  play_all(R"({"moves": [{"from": 0, "to": 5, "light": {"name": "sun", "azimuth": 40, "elevation": 30, "scale": 2}}]})",
           8);
  const std::size_t sun = session_.rig().find("sun");
  EXPECT_EQ(state_.lights[sun].scale, 2);
  const Vec3 direction = rotate(session_.rig().lights()[sun].direction, state_.lights[sun].turn);
  const SunAngles angles = sun_angles(direction, {0, 1, 0});
  EXPECT_NEAR(angles.azimuth, 40 * kPi / 180, 1e-3f);
  EXPECT_NEAR(angles.elevation, 30 * kPi / 180, 1e-3f);
}

TEST_F(ScriptTest, FocusesOnWhatIsSeen) {
  const ViewFrame frame = session_.next_frame(state_, 0);
  focus_on(frame, {0.3f, 0.8f}, state_);
  const ViewFrame turned = session_.next_frame(state_, 0.1);
  const Projection pivot = project(
      state_.camera, state_.camera.to_world.translation + forward(state_.camera) * state_.pivot_distance, 32, 24);
  EXPECT_NEAR(pivot.film.x, 16, 0.1f);
  EXPECT_NEAR(pivot.film.y, 12, 0.1f);
  // A pixel in the middle shows the pivot, as far as a pixel is small.
  EXPECT_NEAR(turned.image.depth[12 * 32 + 16], state_.pivot_distance, 0.25f * state_.pivot_distance);
}

TEST(ScriptErrors, NameThePlaceAndTheChoices) {
  const auto message = [](const std::string& text) {
    try {
      parse_script(text, "moves.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(message("{"), HasSubstr("moves.json"));
  EXPECT_THAT(message(R"({"fps": 1e400})"), HasSubstr("moves.json"));
  EXPECT_THAT(message("[]"), HasSubstr("moves.json is not an object"));
  EXPECT_THAT(message(R"({"move": []})"), testing::AllOf(HasSubstr("\"move\""), HasSubstr("moves")));
  EXPECT_THAT(message(R"({"moves": [{}, {"orbit": [1]}]})"), HasSubstr("moves.json: move 2 \"orbit\""));
  EXPECT_THAT(message(R"({"moves": [{"at": -1}]})"), HasSubstr("\"at\""));
  EXPECT_THAT(message(R"({"moves": [{"from": 5, "to": 5}]})"), HasSubstr("ends before it begins"));
  EXPECT_THAT(message(R"({"moves": [{"light": {"scale": 1}}]})"), HasSubstr("\"name\""));
  EXPECT_THAT(message(R"({"moves": [{"window": "dance"}]})"), HasSubstr("minimise"));
  for (const char* name : {"/tmp/a.png", "../a.png", "b/../../a.exr", "a.txt", ".bashrc", "a"})
    EXPECT_THAT(message(R"({"moves": [{"screenshot": ")" + std::string(name) + R"("}]})"),
                testing::AllOf(HasSubstr("move 1"), HasSubstr(name)));
  EXPECT_EQ(message(R"({"moves": [{"screenshot": "b/a.PNG"}]})"), "no error");
  EXPECT_THAT(message(R"({"fps": 0})"), HasSubstr("fps"));
  EXPECT_THAT(message(R"({"size": [0, 1]})"), HasSubstr("size"));
  EXPECT_THROW(parse_script(R"({"frames": 9, "moves": [{"from": 5, "to": 10}]})", "moves.json"), Error);
  EXPECT_EQ(parse_script(R"({"frames": 9, "moves": [{"from": 5, "to": 9}]})", "moves.json").moves.size(), 1u);
  EXPECT_THROW(read_script("/nonexistent.json"), Error);
}

TEST_F(ScriptTest, RejectsUnknownNames) {
  for (const char* text : {R"({"moves": [{"mode": "wireframe"}]})", R"({"moves": [{"engine": "none"}]})",
                           R"({"moves": [{"kernel": "hat"}]})", R"({"moves": [{"camera": "none"}]})",
                           R"({"moves": [{"light": {"name": "moon"}}]})"})
    EXPECT_THROW(play_all(text, 1), Error) << text;
}

}  // namespace
}  // namespace glowworm
