// The session: which steps are redone and which are kept, and that frames show the scene correctly.
#include "session/session.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>

#include "control/job.h"
#include "control/scheduler.h"
#include "core/error.h"
#include "core/parallel.h"
#include "film/filtered.h"
#include "maps/memory.h"
#include "session/camera_control.h"
#include "session/session_testing.h"

namespace glowworm {
namespace {

class SessionTest : public testing::Test {
 protected:
  SessionTest() : session_(test_scene("cornell"), {}), state_(small_state(session_)) {}

  ViewFrame next() { return session_.next_frame(state_, clock_ += 1.0 / 30); }
  std::uint64_t photons_traced(const ViewFrame& frame) const { return frame.cost.count(Counter::photons_emitted); }

  Session session_;
  ViewState state_;
  double clock_ = 0;
};

TEST_F(SessionTest, KeepsThePhotonMapWhenTheCameraMoves) {
  EXPECT_GT(photons_traced(next()), 0u);
  state_.camera = orbit(state_.camera, state_.pivot_distance, nearest_up(state_.camera), 0.1f, 0.05f);
  const ViewFrame frame = next();
  EXPECT_EQ(photons_traced(frame), 0u);
  EXPECT_EQ(frame.cost.phase(Phase::build_photon_map), 0);
  EXPECT_TRUE(frame.moving);
  EXPECT_GT(frame.cost.count(Counter::query_points), 0u);
}

TEST_F(SessionTest, TracesPhotonsAgainWhenALightChanges) {
  const double before = mean_luminance(next());
  state_.lights[0].scale = 2;
  state_.reuse = false;
  const ViewFrame frame = next();
  EXPECT_GT(photons_traced(frame), 0u);
  // The same photons, camera rays and gather rays, with twice the flux.
  state_.lights[0].scale = 1;
  EXPECT_NEAR(mean_luminance(frame), 2 * mean_luminance(next()), 1e-4 * before);
}

TEST_F(SessionTest, TracesNoPhotonsForAnotherEngineKernelOrMode) {
  next();
  state_.engine = "forward";
  EXPECT_EQ(photons_traced(next()), 0u);
  state_.kernel = KernelShape::cone;
  EXPECT_EQ(photons_traced(next()), 0u);
  state_.nearest = 30;
  EXPECT_EQ(photons_traced(next()), 0u);
  for (const ViewMode mode :
       {ViewMode::photons, ViewMode::density, ViewMode::radius, ViewMode::cost, ViewMode::albedo, ViewMode::normal}) {
    state_.mode = mode;
    EXPECT_EQ(photons_traced(next()), 0u);
  }
}

TEST_F(SessionTest, TakesTheFastestEngineUnlessOneIsNamed) {
  EXPECT_EQ(state_.engine, "auto");
  EXPECT_EQ(next().engine, kAutomaticEngine);
  state_.engine = "forward";
  EXPECT_EQ(next().engine, "forward");
}

TEST_F(SessionTest, TracesNoPhotonsWhereOnlySurfacesAreShown) {
  state_.mode = ViewMode::albedo;
  EXPECT_EQ(photons_traced(next()), 0u);
}

TEST_F(SessionTest, ShowsAPartWithoutRenderingOtherLight) {
  state_.reuse = false;
  state_.part = LightPart::direct;
  const ViewFrame direct = next();
  state_.mode = ViewMode::albedo;  // so that the next frame begins with the same samples
  next();
  state_.mode = ViewMode::gather;
  state_.part = LightPart::indirect;
  const ViewFrame indirect = next();
  state_.mode = ViewMode::albedo;
  next();
  state_.mode = ViewMode::gather;
  state_.part = LightPart::all;
  const ViewFrame all = next();
  EXPECT_GT(mean_luminance(direct), 0);
  EXPECT_GT(mean_luminance(indirect), 0);
  // What is left is light that is seen itself.
  EXPECT_GT(mean_luminance(all), mean_luminance(direct) + mean_luminance(indirect));
}

TEST_F(SessionTest, RefinesWhileTheViewRests) {
  Session other(test_scene("cornell"), {});
  ViewState fine = state_;
  fine.gather = 64;
  ViewFrame reference;
  for (int i = 0; i < 24; ++i) reference = other.next_frame(fine, i);
  const ViewFrame first = next();
  ViewFrame last;
  for (int i = 0; i < 11; ++i) last = next();
  EXPECT_EQ(first.samples, 1u);
  EXPECT_EQ(last.samples, 11u) << "the quick first frame is no part of the picture at rest";
  EXPECT_FALSE(last.moving);
  EXPECT_LT(relative_difference(last, reference), 0.5 * relative_difference(first, reference));
}

TEST_F(SessionTest, TracesNewPhotonsAfterSomePasses) {
  for (int i = 0; i < 17; ++i) {
    const ViewFrame frame = next();
    EXPECT_EQ(photons_traced(frame) > 0, i == 0) << i;
  }
  EXPECT_GT(photons_traced(next()), 0u);
  EXPECT_EQ(photons_traced(next()), 0u);
  // The map of views in motion is still there.
  state_.camera = fly(state_.camera, {0, 0, 0.01f});
  EXPECT_EQ(photons_traced(next()), 0u);
}

TEST_F(SessionTest, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<ViewFrame> frames[2];
  for (int run = 0; run < 2; ++run) {
    set_thread_count(run == 0 ? 1 : 3);
    Session session(test_scene("cornell"), {});
    ViewState state = small_state(session);
    state.filter = true;
    for (int i = 0; i < 8; ++i) {
      if (i == 2) state.camera = fly(state.camera, {0.02f, 0, 0.05f});
      if (i == 4) state.lights[0].move = {0.1f, -0.1f, 0};
      frames[run].push_back(session.next_frame(state, i / 30.0));
    }
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < frames[0].size(); ++i)
    EXPECT_TRUE(frames[0][i].image.light == frames[1][i].image.light) << "frame " << i;
}

TEST_F(SessionTest, ShowsAMovedLightAsInASceneBuiltThatWay) {
  state_.reuse = false;
  state_.lights[0].move = {0.12f, -0.05f, 0.08f};
  state_.lights[0].scale = 1.5f;
  next();
  SceneDescription description = builtin_scene("cornell");
  Geometry& g = description.geometry;
  std::set<std::uint32_t> vertices;
  for (std::size_t t = 0; t < g.triangle_count(); ++t)
    if (g.emission[t] != kNone) vertices.insert(g.triangles[t].begin(), g.triangles[t].end());
  for (const std::uint32_t v : vertices) g.positions[v] += state_.lights[0].move;
  for (Emission& e : description.emissions) e.radiance.value *= 1.5f;
  Session made(std::make_shared<const Scene>(std::move(description)), {});
  ViewState plain = state_;
  plain.lights[0] = {};
  state_.camera = plain.camera = fly(state_.camera, {0, 0, 0.01f});  // both from their first sample
  ViewFrame edited, wanted;
  for (int i = 0; i < 8; ++i) {
    edited = next();
    wanted = made.next_frame(plain, i / 30.0);
  }
  // The same paths, but for rays on edges between the two structures.
  EXPECT_LT(relative_difference(edited, wanted), 0.02);
}

TEST_F(SessionTest, ShowsAnotherMomentAsASceneOfItsOwn) {
  SceneMoments moments;
  moments.length = 2;
  moments.at = [](double seconds) {
    SceneDescription scene = builtin_scene("cornell");
    for (Vec3& p : scene.geometry.positions) p.y += static_cast<float>(seconds);
    return std::make_shared<const Scene>(std::move(scene));
  };
  Session moving(moments.at(0), SessionSettings(), moments), own(moments.at(0.5), SessionSettings());
  ViewState state = small_state(moving);
  state.reuse = false;
  moving.next_frame(state, 0);
  state.seconds = 0.5;
  const ViewFrame shown = moving.next_frame(state, 1);
  EXPECT_TRUE(shown.moving);
  EXPECT_GT(shown.cost.count(Counter::photons_emitted), 0u);
  EXPECT_EQ(relative_difference(shown, own.next_frame(state, 0)), 0);
  // It rests there, and lights of the moment may be edited.
  EXPECT_FALSE(moving.next_frame(state, 2).moving);
  state.lights[0].scale = 2;
  EXPECT_NEAR(mean_luminance(moving.next_frame(state, 3)) / mean_luminance(shown), 2, 0.1);
}

TEST_F(SessionTest, EditsLightsByNameWhereOneIsBlackAtAMoment) {
  SceneMoments moments;
  moments.length = 2;
  moments.at = [](double seconds) {
    SceneDescription scene = builtin_scene("cornell");
    Light light;
    light.name = "bulb";
    light.position = {0, 0.5f, 0};
    light.intensity = RGB(1);
    scene.lights.push_back(light);
    if (seconds == 1) scene.emissions[0].radiance.value = RGB(0);
    return std::make_shared<const Scene>(std::move(scene));
  };
  Session session(moments.at(0), SessionSettings(), moments);
  ViewState state = small_state(session);
  state.reuse = false;
  ASSERT_EQ(state.lights.size(), 2u);
  state.lights[0].scale = 3;
  session.next_frame(state, 0);
  state.seconds = 1;
  const float bulb = mean_luminance(session.next_frame(state, 1));
  state.lights[1].scale = 2;
  EXPECT_NEAR(mean_luminance(session.next_frame(state, 2)) / bulb, 2, 1e-3);
  EXPECT_EQ(session.rig().lights().size(), 2u);
}

TEST_F(SessionTest, IsDarkWithoutLight) {
  next();
  state_.lights[0].on = false;
  state_.reuse = false;
  for (const ViewMode mode : {ViewMode::gather, ViewMode::photons}) {
    state_.mode = mode;
    EXPECT_EQ(mean_luminance(next()), 0);
  }
  state_.mode = ViewMode::density;
  next();
  state_.mode = ViewMode::gather;
  state_.lights[0].on = true;
  EXPECT_GT(mean_luminance(next()), 0);
}

TEST_F(SessionTest, StopsWhenInterruptedAndContinues) {
  Interrupt interrupt;
  interrupt.request();
  EXPECT_THROW(session_.next_frame(state_, 0, false, interrupt), Cancelled);
  interrupt.clear();
  const ViewFrame late = session_.next_frame(state_, 0.1, false, interrupt);
  Session undisturbed(test_scene("cornell"), {});
  const ViewFrame frame = undisturbed.next_frame(state_, 0);
  EXPECT_NEAR(mean_luminance(late), mean_luminance(frame), 0.1 * mean_luminance(frame));
}

TEST_F(SessionTest, RejectsInvalidStates) {
  state_.width = 0;
  EXPECT_THROW(next(), Error);
  state_.width = 32;
  state_.gather = 0;
  EXPECT_THROW(next(), Error);
  state_.gather = 4;
  state_.lights.resize(7);
  EXPECT_THROW(next(), Error);
  state_.lights.resize(1);
  EXPECT_GT(mean_luminance(next()), 0);
}

TEST_F(SessionTest, StaysWithinItsMemory) {
  SessionSettings settings;
  settings.memory_bytes = kBytesPerThread * static_cast<std::uint64_t>(thread_count()) + 4'000'000;
  Session session(test_scene("cornell"), settings);
  ViewState state = small_state(session);
  state.photons = 1'000'000;
  EXPECT_THROW(session.next_frame(state, 0), Error);
  state.photons = 2000;
  EXPECT_NO_THROW(session.next_frame(state, 0));
}

TEST_F(SessionTest, AdaptsToTheTimeAvailable) {
  SessionSettings settings;
  settings.adapt = true;
  settings.frames_per_second = 1000;  // more than any machine holds
  Session session(test_scene("cornell"), settings);
  ViewState state = small_state(session);
  state.width = 320;
  state.height = 240;
  state.gather = 64;
  ViewFrame frame;
  for (int i = 0; i < 6; ++i) {
    state.camera = fly(state.camera, {0, 0, 0.01f});
    frame = session.next_frame(state, i / 30.0);
  }
  EXPECT_LT(frame.image.width, 320);
  EXPECT_LT(frame.effort.gather, 64u);
  // At rest the picture is whole again.
  frame = session.next_frame(state, 1);
  EXPECT_EQ(frame.image.width, 320);
}

/// The filter takes longer than a pass of few rays: a view at rest runs it after more and more passes, and shows the
/// newest filtered picture meanwhile.
TEST(SessionFilter, RunsAtGrowingIntervalsWhereFramesAdapt) {
  SessionSettings settings;
  settings.adapt = true;
  Session session(test_scene("cornell"), settings);
  ViewState state = small_state(session);
  state.filter = true;
  ViewFrame last = session.next_frame(state, 0);
  int passes = 0, pictures = 0;
  for (int i = 1; i <= 64; ++i) {
    const ViewFrame frame = session.next_frame(state, i);
    ASSERT_FALSE(frame.moving);
    if (frame.samples >= 16 && last.samples >= 16) {
      ++passes;
      pictures += frame.samples != last.samples;
      EXPECT_EQ(frame.samples == last.samples, frame.image.light == last.image.light);
    }
    EXPECT_LE(frame.samples, static_cast<std::uint32_t>(i));
    if (i > 2) {
      EXPECT_GE(frame.samples, 2u);
    }
    last = frame;
  }
  EXPECT_LE(2 * pictures, passes + 1);
}

TEST(SessionFilter, MayBeTurnedOnAndOffAtRest) {
  Session session(test_scene("cornell"), {}), plain(test_scene("cornell"), {});
  ViewState state = small_state(session);
  state.reuse = false;
  for (int i = 0; i < 8; ++i) {
    state.filter = i == 4 || i == 5;
    const ViewFrame frame = session.next_frame(state, i);
    state.filter = false;
    const ViewFrame unfiltered = plain.next_frame(state, i);
    EXPECT_EQ(frame.samples, unfiltered.samples);
    EXPECT_EQ(frame.image.light == unfiltered.image.light, i != 4 && i != 5) << i;
  }
}

TEST(SessionGuiding, SendsPhotonsWhereAViewAtRestNeedsThem) {
  SessionSettings settings;
  settings.adapt = true;
  settings.frames_per_second = 0.01;  // as many photons as are asked for
  Session session(test_scene("window-room"), settings);
  ViewState state = small_state(session);
  state.mode = ViewMode::density;
  const ViewFrame hasty = session.next_frame(state, 0);
  // Of all light most misses the window.
  const ViewFrame guided = session.next_frame(state, 1);
  EXPECT_EQ(hasty.photons / 1000, guided.photons / 1000);
  EXPECT_GT(guided.scale.high, 10 * hasty.scale.high) << "photons per m^2 in the room";
  state.camera = fly(state.camera, {0, 0, 0.01f});
  for (const double seconds : {2.0, 3.0})
    EXPECT_EQ(session.next_frame(state, seconds).cost.count(Counter::photons_emitted), 0u) << "the map is kept";
  state.lights[0].scale = 2;
  EXPECT_LT(session.next_frame(state, 4).scale.high, 2 * hasty.scale.high) << "a frame in time takes no pilots";
}

/// Better photons for a view at rest take their time: where a person goes on before they are there, the next frame
/// shows those that there were, and traces none.
TEST(SessionInterruption, KeepsExistingPhotons) {
  SessionSettings settings;
  settings.adapt = true;
  settings.frames_per_second = 1000;
  Session session(test_scene("cornell"), settings);
  ViewState state = small_state(session);
  state.photons = 300'000;
  const std::uint64_t few = session.next_frame(state, 0).photons;
  EXPECT_LT(few, 100'000u);
  Interrupt interrupt;
  std::thread person([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    interrupt.request();
  });
  EXPECT_THROW(session.next_frame(state, 1, false, interrupt), Cancelled);
  person.join();
  state.camera = fly(state.camera, {0, 0, 0.01f});
  const ViewFrame frame = session.next_frame(state, 2);
  EXPECT_EQ(frame.cost.count(Counter::photons_emitted), 0u);
  EXPECT_EQ(frame.photons, few);
  EXPECT_GE(session.next_frame(state, 3).photons, 300'000u);
}

/// The light of a picture is that of another, but for rounding.
void expect_same(const std::vector<RGB>& shown, const std::vector<RGB>& wanted, float scale, const std::string& name) {
  ASSERT_EQ(shown.size(), wanted.size());
  float mean = 0;
  for (const RGB& light : wanted) mean += luminance(light) * scale / static_cast<float>(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(shown[i][c], wanted[i][c] * scale, 1e-5f * (wanted[i][c] * scale + mean)) << name << ", pixel " << i;
}

/// A view at rest is what a render of the same view, samples and photons is: one renderer makes both, and one filter.
TEST(SlowSession, ShowsAtRestWhatAJobRenders) {
  for (const char* name : {"cornell", "window-room", "glass-sphere"})
    for (const LightPart part : {LightPart::all, LightPart::indirect}) {
      const auto scene = test_scene(name);
      RenderSettings asked;
      asked.width = 48;
      asked.height = 36;
      asked.samples = 5;
      asked.gather = 16;
      asked.photons = 50'000;
      asked.nearest = 50;
      asked.engine = "blocked";
      asked.indirect_only = part == LightPart::indirect;
      Job job(scene, std::make_shared<const Tracer>(*scene), asked);
      job.wait();
      const Film film = job.snapshot();
      Session session(scene, {});
      ViewState state = small_state(session);
      state.width = asked.width;
      state.height = asked.height;
      state.photons = asked.photons;
      state.gather = asked.gather;
      state.engine = asked.engine;
      state.part = part;
      ViewFrame frame;
      for (int i = 0; i < 6; ++i) frame = session.next_frame(state, i);
      ASSERT_EQ(frame.samples, asked.samples);
      const float scale = scene->film().scale;
      expect_same(frame.image.light, unfiltered_picture(film, asked.indirect_only).radiance, scale, name);
      Session filtering(scene, {});
      state.filter = true;
      // Earlier frames, soon before, leave no trace in a filtered picture.
      for (int i = 0; i < 6; ++i) frame = filtering.next_frame(state, 0.01 * i);
      ASSERT_EQ(frame.samples, asked.samples);
      expect_same(frame.image.light, filtered_picture(film, asked.indirect_only).radiance, scale, name);
    }
}

}  // namespace
}  // namespace glowworm
