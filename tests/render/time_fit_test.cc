#include "control/time_fit.h"

#include <gmock/gmock.h>

#include "builtin/builtin.h"
#include "control/scheduler.h"
#include "core/error.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

RenderSettings limited(double seconds) {
  RenderSettings s;
  s.width = s.height = 64;
  s.time_limit_s = seconds;
  s.filter = Filtering::off;
  return s;
}

const Scene& cornell() {
  static const Scene scene(builtin_scene("cornell"));
  return scene;
}

constexpr AutomaticNumbers kAllNumbers{true, true, true};

TEST(TimeFit, LeavesFastMachinesAlone) {
  const RenderSettings s = resolve(limited(20), cornell());
  const RenderSettings fitted = fitted_settings(s, kAllNumbers, {.ray_s = 1e-5 / s.gather, .photon_s = 1e-6}, 20);
  EXPECT_EQ(fitted.photons, s.photons);
  EXPECT_EQ(fitted.gather, s.gather);
  EXPECT_FALSE(may_need_fitting(s, kAllNumbers, 1000));
  EXPECT_TRUE(may_need_fitting(s, kAllNumbers, 20));
  EXPECT_FALSE(may_need_fitting(s, {}, 20));
  EXPECT_FALSE(may_need_fitting(resolve(limited(0), cornell()), kAllNumbers, 20));
}

TEST(TimeFit, GivesPhotonsAndAFirstImageTheirShares) {
  const RenderSettings s = resolve(limited(20), cornell());
  for (const double slowness : {1.0, 3.0, 10.0, 30.0}) {
    const Cost cost{.ray_s = 1e-3 * slowness / s.gather, .photon_s = 1e-4 * slowness};
    const RenderSettings fitted = fitted_settings(s, kAllNumbers, cost, 20);
    EXPECT_LT(fitted.photons, s.photons);
    const double photons_s = cost.photon_s * static_cast<double>(fitted.photons);
    EXPECT_LE(photons_s, 8.01);
    EXPECT_GT(photons_s, 7);
    const double image_s = cost.sample_s(fitted.gather) * 64 * 64;
    EXPECT_LE(photons_s + image_s, 20) << slowness;
    EXPECT_EQ(fitted.light_samples, resolve(
                                        [&] {
                                          RenderSettings same = limited(20);
                                          same.gather = fitted.gather;
                                          return same;
                                        }(),
                                        cornell())
                                        .light_samples);
  }
}

TEST(TimeFit, KeepsNumbersThatAreGiven) {
  const RenderSettings s = resolve(limited(20), cornell());
  const RenderSettings fitted = fitted_settings(s, {}, {.ray_s = 1, .photon_s = 1}, 20);
  EXPECT_EQ(fitted.photons, s.photons);
  EXPECT_EQ(fitted.gather, s.gather);
  EXPECT_EQ(fitted.light_samples, s.light_samples);
}

TEST(TimeFit, MeasuresEvenlySpreadPartsOfThePicture) {
  for (const PixelBounds& bounds : {PixelBounds{0, 0, 640, 480}, {10, 20, 13, 22}, {5, 5, 6, 6}, {0, 0, 4000, 1}}) {
    for (const CameraTask& task : spread_tasks(bounds)) {
      EXPECT_GE(task.x0, bounds.x0);
      EXPECT_GE(task.y0, bounds.y0);
      EXPECT_LE(task.x1, bounds.x1);
      EXPECT_LE(task.y1, bounds.y1);
      EXPECT_GT(task.slot_count(), 0u);
    }
  }
}

/// A machine so slow that no time is left: the picture is that of the numbers that the job states, and a render that
/// continues has them, too.
TEST(TimeFit, ARenderIsThatOfItsStatedNumbers) {
  const Stage stage(builtin_scene("cornell"));
  Job job(stage.scene, stage.tracer, limited(20), nullptr, 19.999);
  job.wait();
  const RenderSettings fitted = job.settings();
  EXPECT_TRUE(job.is_fitted());
  EXPECT_EQ(fitted.photons, 1000u);
  EXPECT_EQ(fitted.gather, 1u);
  EXPECT_EQ(job.passes(), 1u);

  RenderSettings given = limited(20);
  given.photons = fitted.photons;
  given.gather = fitted.gather;
  given.light_samples = fitted.light_samples;
  given.samples = 1;
  Job same(stage.scene, stage.tracer, given);
  same.wait();
  EXPECT_FALSE(same.is_fitted());
  EXPECT_EQ(same.snapshot().save(), job.snapshot().save());

  const Checkpoint checkpoint = job.checkpoint();
  Job more(stage.scene, stage.tracer, limited(20), &checkpoint, 19.999);
  more.wait();
  EXPECT_EQ(more.settings().photons, fitted.photons);
  EXPECT_EQ(more.settings().gather, fitted.gather);
  EXPECT_EQ(more.settings().light_samples, fitted.light_samples);
}

TEST(TimeFit, RendersThatContinueWithMoreSamplesKeepTheirPhotons) {
  RenderSettings asked;
  asked.width = 1280;
  asked.height = 720;
  asked.samples = 2;
  const RenderSettings first = resolve(asked, cornell());
  const RenderKey kept = render_key(cornell(), first, nullptr);
  asked.samples = 4;
  EXPECT_NE(resolve(asked, cornell()).photons, first.photons);
  const RenderSettings s = resolve(with_numbers_of(asked, kept), cornell());
  EXPECT_EQ(s.photons, first.photons);
  EXPECT_NO_THROW(check_same_render(render_key(cornell(), s, nullptr), kept, "the checkpoint"));
}

TEST(TimeFit, RendersThatContinueKeepTheErrorForWhichPhotonsWereChosen) {
  RenderSettings first;
  first.noise_target = 0.1;
  const RenderKey kept = render_key(cornell(), resolve(first, cornell()), nullptr);
  // To less noise, to a number of samples, and in a limited time.
  RenderSettings less, samples, timed;
  less.noise_target = 0.01;
  samples.samples = 64;
  timed.time_limit_s = 60;
  for (const RenderSettings& asked : {first, less, samples, timed}) {
    const RenderSettings s = resolve(with_numbers_of(asked, kept), cornell());
    EXPECT_EQ(s.photon_target, 0.1);
    EXPECT_NO_THROW(check_same_render(render_key(cornell(), s, nullptr), kept, "the checkpoint"));
  }
  // Photons that are given are others.
  first.photons = 1000;
  const RenderSettings others = with_numbers_of(first, kept);
  EXPECT_EQ(others.photon_target, 0);
  try {
    check_same_render(render_key(cornell(), resolve(others, cornell())), kept, "the checkpoint");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--photons auto"));
  }

  // What began with a number of photons keeps it.
  RenderSettings given;
  given.photons = 3000;
  given.samples = 2;
  const RenderKey of_given = render_key(cornell(), resolve(given, cornell()), nullptr);
  const RenderSettings s = resolve(with_numbers_of(less, of_given), cornell());
  EXPECT_EQ(s.photons, 3000u);
  EXPECT_EQ(s.photon_target, 0);
}

}  // namespace
}  // namespace glowworm
