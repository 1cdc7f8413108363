// Other needs of a window: display bytes, handles, command lines and a thread.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <span>
#include <thread>

#include "builtin/builtin.h"
#include "core/error.h"
#include "core/parallel.h"
#include "scene/scene_parts.h"
#include "session/camera_control.h"
#include "session/command_text.h"
#include "session/display.h"
#include "session/gizmo.h"
#include "session/script.h"
#include "session/session_testing.h"
#include "session/worker.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

TEST(Display, ShowsTheBytesOfAPng) {
  ViewFrame frame;
  for (int i = 0; i < 4000; ++i) frame.image.light.push_back(RGB(0.0005f * static_cast<float>(i)));
  frame.image.light.push_back(RGB(-1.0f, std::numeric_limits<float>::infinity(), std::nanf("")));
  Display display;
  for (const ToneCurve curve : {ToneCurve::srgb, ToneCurve::filmic})
    for (const float exposure : {0.0f, 1.5f}) {
      const std::vector<std::uint8_t>& bytes = display.bytes(frame, curve, exposure);
      for (std::size_t i = 0; i < 4000; ++i)
        ASSERT_NEAR(bytes[4 * i], to_byte(tone_map(frame.image.light[i], curve, exposure).r), 1) << i;
      EXPECT_EQ(bytes[16000], 0);
      EXPECT_EQ(bytes[16001], 255);
      EXPECT_EQ(bytes[16002], 0);
      EXPECT_EQ(bytes[16003], 255);
    }
}

/// Shows every pixel as the same colour, whatever its light.
class PaintedView : public ColorView {
 public:
  void apply(std::span<RGB> pixels) const override { std::fill(pixels.begin(), pixels.end(), RGB(1, 0, 0.2f)); }
  std::string name() const override { return "painted"; }
};

TEST(Display, ShowsLightAloneByAView) {
  ViewFrame frame;
  frame.image.light.assign(2, RGB(0.0f));
  Display display;
  frame.is_light = true;
  EXPECT_THAT(display.bytes(frame, ToneCurve::srgb, 0, std::make_unique<PaintedView>().get()),
              testing::ElementsAre(255, 0, 51, 255, 255, 0, 51, 255));
  frame.is_light = false;
  EXPECT_THAT(display.bytes(frame, ToneCurve::srgb, 0, std::make_unique<PaintedView>().get()),
              testing::ElementsAre(0, 0, 0, 255, 0, 0, 0, 255));
}

TEST(Gizmo, IsDraggedByItsHandles) {
  const Camera camera = look_at({2, 3, 6}, {0, 0, 0}, {0, 1, 0}, 45);
  const Vec3 origin{0.3f, 0.2f, -0.1f};
  const Gizmo gizmo = make_gizmo(camera, origin, 320, 240);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 end = origin + axis_direction(axis) * gizmo.length;
    const Projection at = project(camera, end, 320, 240);
    EXPECT_EQ(picked_axis(gizmo, camera, at.film, 320, 240, 5), axis);
    EXPECT_NEAR(axis_position(gizmo, axis, camera, at.film, 320, 240, 0), gizmo.length, 1e-3f * gizmo.length);
  }
  EXPECT_EQ(picked_axis(gizmo, camera, {5, 5}, 320, 240, 5), -1);
  // Looking along an axis, the pointer says nothing about it.
  const Camera along = look_at({0.3f, 0.2f, 6}, origin, {0, 1, 0}, 45);
  EXPECT_EQ(axis_position(gizmo, 2, along, {160, 120}, 320, 240, 0.7f), 0.7f);
}

TEST(CommandText, RendersTheSameView) {
  Session session(test_scene("cornell"), {});
  ViewState state = small_state(session);
  state.camera = orbit(state.camera, state.pivot_distance, {0, 1, 0}, 0.3f, 0.1f);
  state.lights[0].scale = 2;
  state.lights[0].move = {0.1f, -0.2f, 0};
  state.engine = "forward";
  state.kernel = KernelShape::cone;
  state.secondary_gather = false;
  const std::string text = render_command_text("my scenes/it's.glb", session.scene(), session.rig().lights(), state);
  EXPECT_THAT(text, HasSubstr("glowworm render 'my scenes/it'\\''s.glb' --size 32x24"));
  EXPECT_THAT(text, HasSubstr("--engine forward"));
  EXPECT_THAT(text, HasSubstr("--kernel cone"));
  EXPECT_THAT(text, HasSubstr("--no-secondary-gather"));
  EXPECT_THAT(text, HasSubstr("scale=2,move=0.1:-0.2:0"));
  std::string camera;
  const auto scene =
      scene_of_view(test_scene("cornell"), {light_edit_text(session.rig().lights()[0].name, state.lights[0])},
                    view_text(state.camera, session.scene()), camera);
  const Camera& read = scene->camera(camera);
  EXPECT_LT(length(read.to_world.translation - state.camera.to_world.translation), 1e-6f);
  EXPECT_LT(length(read.to_world.x - state.camera.to_world.x), 1e-5f);
  EXPECT_LT(length(read.to_world.z - state.camera.to_world.z), 1e-5f);
  EXPECT_EQ(read.half_extent, state.camera.half_extent);
  EXPECT_NEAR(scene->light_power().total() / session.scene().light_power().total(), 2, 1e-5);
  // Without changes nothing is said of them.
  EXPECT_EQ(render_command_text("builtin:cornell", session.scene(), session.rig().lights(), session.initial_state()),
            "glowworm render builtin:cornell --size " + std::to_string(session.initial_state().width) + "x" +
                std::to_string(session.initial_state().height) + " --samples 64 --gather 64 -o view.exr -o view.png");
}

TEST(CommandText, NamesPlacesAsTheFileDoes) {
  SceneDescription d = builtin_scene("cornell");
  translate(d, kFarAway);
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const Camera there = orbit(scene->camera(""), 2, {0, 1, 0}, 0.3f, 0.1f);
  const std::string text = view_text(there, *scene);
  EXPECT_THAT(text, testing::StartsWith("30000"));
  std::string camera;
  const Camera read = scene_of_view(scene, {}, text, camera)->camera(camera);
  EXPECT_LT(length(read.to_world.translation - there.to_world.translation), 1e-6f);
  EXPECT_LT(length(read.to_world.z - there.to_world.z), 1e-5f);
}

TEST(CommandText, HasTheAxesOfTheFile) {
  SceneDescription d = builtin_scene("cornell");
  d.z_up = true;
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const Camera there = orbit(scene->camera(""), 2, {0, 1, 0}, 0.3f, 0.1f);
  std::string camera;
  const Camera read = scene_of_view(scene, {}, view_text(there, *scene), camera)->camera(camera);
  EXPECT_LT(length(read.to_world.translation - there.to_world.translation), 1e-6f);
  EXPECT_LT(length(read.to_world.z - there.to_world.z), 1e-5f);
  camera.clear();
  const Camera down = scene_of_view(scene, {}, "0.5,-0.25,3,0.5,-0.25,0,0,1,0", camera)->camera(camera);
  EXPECT_LT(length(down.to_world.translation - Vec3{0.5f, 3, 0.25f}), 1e-6f);
  EXPECT_LT(length(down.to_world.z - Vec3{0, -1, 0}), 1e-6f);
  EXPECT_LT(length(down.to_world.y - Vec3{0, 0, -1}), 1e-6f);
  // A light that moves along the file's z axis rises.
  const LightRig rig(scene);
  const auto height = [](const Scene& s) {
    const std::uint32_t t = s.emissive_triangles()[0];
    return s.geometry().positions[s.geometry().triangles[t][0]].y;
  };
  camera.clear();
  const auto moved = scene_of_view(scene, {"0,move=0:0:-0.125"}, "", camera);
  EXPECT_NEAR(height(*moved) - height(*scene), -0.125f, 1e-6f);
  ViewState state;
  state.camera = there;
  play(parse_script(R"({"moves": [{"at": 0, "light": {"name": "0", "move": [0, 0, -0.25]}}]})", "a.json"), 0, *scene,
       rig, nullptr, state);
  EXPECT_EQ(state.lights.at(0).move, (Vec3{0, -0.25f, 0}));
  EXPECT_THAT(render_command_text("a.obj", *scene, rig.lights(), state), HasSubstr("move=0:0:-0.25"));
}

TEST(CommandText, RejectsInvalidViewsAndLights) {
  std::string camera;
  const auto scene = test_scene("cornell");
  for (const char* view :
       {"1,2,3", "0,0,0,0,0,0,0,1,0", "0,0,0,0,1,0,0,1,0", "a", "1,2,3,4,5,6,7,8,9,10", "1,2,3,4,5,6,7,8,nan"})
    EXPECT_THROW(scene_of_view(scene, {}, view, camera), Error) << view;
  EXPECT_THROW(scene_of_view(scene, {"0,off"}, "", camera), Error);
  EXPECT_THROW(scene_of_view(scene, {"moon,off"}, "", camera), Error);
  EXPECT_EQ(scene_of_view(scene, {}, "", camera), scene);
}

/// A floor below two lamps, of which the second has such a radiance.
std::shared_ptr<const Scene> scene_with_lamps(float second) {
  SceneDescription d = floor_description();
  for (const float radiance : {1.0f, second}) {
    add_panel(d, 2 + radiance, add_emission(d, RGB(radiance)));
    d.emissions.back().name = d.emissions.size() == 1 ? "first" : "second";
  }
  return std::make_shared<const Scene>(std::move(d));
}

TEST(CommandText, NamesLightsOfAnotherMoment) {
  const auto lit = scene_with_lamps(3), dark = scene_with_lamps(0);
  const LightRig named(lit);
  ASSERT_EQ(named.lights().size(), 2u);
  std::string camera;
  EXPECT_THROW(scene_of_view(dark, {"second,off"}, "", camera), Error);
  EXPECT_THROW(scene_of_view(dark, {"third,off"}, "", camera, &named), Error);
  const double whole = lit->light_power().total(), first = dark->light_power().total();
  // Numbers are those of the other moment, too.
  for (const char* text : {"second,off", "1,off"}) {
    EXPECT_NEAR(scene_of_view(lit, {text}, "", camera, &named)->light_power().total(), first, 1e-5 * whole) << text;
    EXPECT_NEAR(scene_of_view(dark, {text}, "", camera, &named)->light_power().total(), first, 1e-5 * whole) << text;
  }
  // All lamps may be black at a moment.
  EXPECT_EQ(scene_of_view(dark, {"first,off"}, "", camera, &named)->light_power().total(), 0);
}

/// What a window does with a worker, without one.
class WorkerTest : public testing::Test {
 protected:
  static SessionSettings settings() {
    SessionSettings s;
    s.adapt = true;
    return s;
  }
  WorkerTest()
      : worker_(
            settings(), [](const std::string& name, SceneMoments&) { return test_scene(name); }, [] {}) {}

  template <typename Take>
  auto wait_for(Take&& take) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    auto got = take();
    while (!got && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      got = take();
    }
    return got;
  }
  WorkerFrame frame_of(std::uint64_t number) {
    const auto frame = wait_for([&] {
      auto taken = worker_.take_frame();
      if (taken && taken->number < number) taken.reset();
      return taken;
    });
    EXPECT_TRUE(frame.has_value());
    return frame.value_or(WorkerFrame());
  }
  ViewState open(const std::string& name) {
    worker_.open(name);
    const auto scene = wait_for([&] { return worker_.take_scene(); });
    EXPECT_TRUE(scene.has_value());
    ViewState state = scene ? scene->state : ViewState();
    state.width = 40;
    state.height = 30;
    state.photons = 3000;
    state.gather = 4;
    return state;
  }

  SessionWorker worker_;
};

TEST_F(WorkerTest, ShowsWhatIsPostedAndRefinesIt) {
  const ViewState state = open("cornell");
  const std::uint64_t number = worker_.post(state, false);
  EXPECT_EQ(frame_of(number).frame.samples, 1u);
  const auto later = wait_for([&] {
    auto taken = worker_.take_frame();
    if (taken && taken->frame.samples < 4) taken.reset();
    return taken;
  });
  ASSERT_TRUE(later.has_value());
  EXPECT_EQ(later->frame.image.width, 40);
}

TEST_F(WorkerTest, AbandonsARestingPictureForANewState) {
  ViewState state = open("cornell");
  state.photons = 400'000;
  worker_.post(state, false);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  state.photons = 2000;
  state.camera = fly(state.camera, {0, 0, 0.1f});
  const WorkerFrame frame = frame_of(worker_.post(state, true));
  EXPECT_TRUE(same_view(frame.frame.image.camera, state.camera));
}

TEST_F(WorkerTest, KeepsTheSceneIfAnotherCannotBeLoaded) {
  const ViewState state = open("cornell");
  worker_.open("no such scene");
  const auto error = wait_for([&] { return worker_.take_error(); });
  ASSERT_TRUE(error.has_value());
  EXPECT_THAT(*error, HasSubstr("no such scene"));
  EXPECT_FALSE(worker_.take_scene().has_value());
  EXPECT_GT(frame_of(worker_.post(state, false)).frame.samples, 0u);
}

TEST_F(WorkerTest, AbandonsLoadingForAnotherSceneAndOnDestruction) {
  std::atomic<int> begun{0}, left{0};
  {
    SessionWorker worker(
        settings(),
        [&](const std::string& name, SceneMoments&) {
          ++begun;
          try {
            while (name == "endless") check_cancelled();
          } catch (const Cancelled&) {
            ++left;
            throw;
          }
          return test_scene(name);
        },
        [] {});
    const auto wait_until = [](const auto& condition) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
      bool holds = condition();
      while (!holds && std::chrono::steady_clock::now() < end) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        holds = condition();
      }
      return holds;
    };
    worker.open("endless");
    ASSERT_TRUE(wait_until([&] { return begun == 1; }));
    worker.open("cornell");
    EXPECT_TRUE(wait_until([&] { return worker.take_scene().has_value(); }));
    EXPECT_EQ(left, 1);
    EXPECT_FALSE(worker.take_error().has_value());
    worker.open("endless");
    ASSERT_TRUE(wait_until([&] { return begun == 3; }));
  }
  EXPECT_EQ(left, 2);
}

TEST_F(WorkerTest, ReportsAnInvalidStateOnce) {
  ViewState state = open("cornell");
  state.gather = 0;
  worker_.post(state, false);
  EXPECT_TRUE(wait_for([&] { return worker_.take_error(); }).has_value());
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(worker_.take_error().has_value());
  state.gather = 1;
  EXPECT_GT(frame_of(worker_.post(state, false)).frame.samples, 0u);
}

TEST_F(WorkerTest, ShowsAStateThatIsPostedWhileAnotherFails) {
  SessionSettings little_memory = settings();
  little_memory.frames_per_second = 0.001;  // as many pixels as the state has
  little_memory.memory_bytes = std::uint64_t{64} << 20;
  SessionWorker worker(
      little_memory, [](const std::string& name, SceneMoments&) { return test_scene(name); }, [] {});
  worker.open("cornell");
  const auto scene = wait_for([&] { return worker.take_scene(); });
  ASSERT_TRUE(scene.has_value());
  ViewState good = scene->state, bad = good;
  good.width = good.height = 8;
  good.photons = 1000;
  bad.width = bad.height = 8000;
  bad.photons = 100'000;  // takes time before the memory for the pixels is missing
  worker.post(bad, true);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::uint64_t number = worker.post(good, true);
  EXPECT_TRUE(wait_for([&] { return worker.take_error(); }).has_value());
  const auto frame = wait_for([&] { return worker.take_frame(); });
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->number, number);
}

TEST_F(WorkerTest, DoesNotShowAStateOfTheOldSceneInTheNewOne) {
  const ViewState state = open("cornell");
  worker_.open("ring");
  EXPECT_TRUE(wait_for([&] { return !worker_.loading(); }));
  worker_.post(state, false);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_FALSE(worker_.take_error().has_value());
  EXPECT_FALSE(worker_.take_frame().has_value());
  const auto scene = worker_.take_scene();
  ASSERT_TRUE(scene.has_value());
  EXPECT_GT(frame_of(worker_.post(scene->state, true)).frame.samples, 0u);
}

TEST_F(WorkerTest, RendersNothingWhilePaused) {
  const ViewState state = open("cornell");
  frame_of(worker_.post(state, false));
  worker_.pause(true);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  worker_.take_frame();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(worker_.take_frame().has_value());
  worker_.pause(false);
  EXPECT_TRUE(wait_for([&] { return worker_.take_frame(); }).has_value());
}

TEST_F(WorkerTest, OpensOneSceneAfterAnother) {
  for (const char* name : {"cornell", "ring", "cornell"}) {
    const ViewState state = open(name);
    EXPECT_GT(mean_luminance(frame_of(worker_.post(state, false)).frame), 0) << name;
  }
}

}  // namespace
}  // namespace glowworm
