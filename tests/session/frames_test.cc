// Frames of sequences: their numbers, names and cameras.
#include "session/frames.h"

#include <gmock/gmock.h>

#include "core/error.h"
#include "session/camera_control.h"
#include "session/session_testing.h"

namespace glowworm {
namespace {

TEST(FrameRange, ReadsNumbersOfFrames) {
  EXPECT_THAT(parse_frame_range("3").numbers(), testing::ElementsAre(3));
  EXPECT_THAT(parse_frame_range("1-4").numbers(), testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(parse_frame_range("1-6:2").numbers(), testing::ElementsAre(1, 3, 5));
  for (const char* text : {"", "-", "1-", "-3", "4-1", "1-4:0", "1-4:", "1:2:3", "1.5", "a", "1-99999999", " 1"})
    EXPECT_THROW(parse_frame_range(text), Error) << text;
}

TEST(FrameFile, PutsTheNumberIntoTheName) {
  EXPECT_EQ(frame_file("a/walk_####.exr", 7), "a/walk_0007.exr");
  EXPECT_EQ(frame_file("#.png", 12), "12.png");
  EXPECT_EQ(frame_file("shot#1/x_##.png", 3), "shot#1/x_03.png");
  EXPECT_EQ(frame_file("a.png", 3), "a.png");
  EXPECT_TRUE(has_frame_number("a#.png"));
  EXPECT_FALSE(has_frame_number("a.png"));
}

TEST(Turntable, CirclesTheMiddleOfTheScene) {
  const std::shared_ptr<const Scene> scene = test_scene("cornell");
  const LightRig rig(scene);
  const Camera& start = scene->camera("");
  const std::vector<FrameOfSequence> frames = turntable(*scene, rig, start, 8, {0, 1, 2, 3, 4, 5, 6, 7});
  ASSERT_EQ(frames.size(), 8u);
  EXPECT_TRUE(same_view(frames[0].camera, start));
  const Vec3 eye = start.to_world.translation;
  const float ahead = dot(scene->center() - eye, forward(start));
  const Vec3 pivot = eye + forward(start) * ahead;
  for (const FrameOfSequence& frame : frames)
    EXPECT_LT(length(frame.camera.to_world.translation + forward(frame.camera) * ahead - pivot), 1e-4f * ahead);
  // The fourth eighth of a turn is half of it.
  EXPECT_LT(length(frames[4].camera.to_world.translation - (pivot + forward(start) * ahead)), 1e-4f * ahead);
}

TEST(GuideCameras, AreEvenlySpaced) {
  std::vector<std::string> names;
  for (int i = 0; i < 32; ++i) names.push_back(std::to_string(i));
  const std::vector<std::string> chosen = guide_cameras(names);
  ASSERT_EQ(chosen.size(), 16u);
  EXPECT_EQ(chosen[1], "2");
  names.resize(3);
  EXPECT_EQ(guide_cameras(names), names);
}

}  // namespace
}  // namespace glowworm
