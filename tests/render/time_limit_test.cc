#include "control/time_limit.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "builtin/builtin.h"
#include "control/job.h"
#include "control/job_report.h"
#include "film/output.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

TEST(TimeLimit, LeavesRoomForWhatFollowsTheLastSample) {
  double now = 0;
  TimeLimit limit(20, 2, [&] { return now; });
  EXPECT_DOUBLE_EQ(limit.left_s(), 18);
  EXPECT_TRUE(limit.wants_rehearsal(false));
  limit.rehearse(false, 1.0 / 16, [&] { now += 0.25; });
  EXPECT_DOUBLE_EQ(limit.finish_s(), 4);
  EXPECT_DOUBLE_EQ(limit.left_s(), 20 - 2 - 0.25 - 4);
  now = 13;
  EXPECT_FALSE(limit.is_up(1.9));
  EXPECT_TRUE(limit.is_up(2));
  // Other programs take more of the machine.
  limit.rehearse(true, 1.0 / 16, [&] { now += 0.3; });
  EXPECT_NEAR(limit.finish_s(), 4.8, 1e-9);
  EXPECT_TRUE(limit.is_up(0.1));
  limit.rehearse(true, 1.0 / 16, [&] { now += 0.05; });
  EXPECT_NEAR(limit.finish_s(), 2.8, 1e-9);
}

TEST(TimeLimit, RehearsesRarelyAndWithTheFirstImage) {
  double now = 0;
  TimeLimit limit(20, 0, [&] { return now; });
  limit.rehearse(false, 0.5, [&] { now += 0.1; });
  EXPECT_FALSE(limit.wants_rehearsal(false));
  EXPECT_TRUE(limit.wants_rehearsal(true));
  limit.rehearse(true, 0.5, [&] { now += 0.1; });
  double spent = 0.2;
  while (now < 20) {
    if (limit.wants_rehearsal(true)) limit.rehearse(true, 0.5, [&] { now += 0.1, spent += 0.1; });
    now += 0.01;
  }
  EXPECT_LT(spent, 0.05 * 20);
  EXPECT_GT(spent, 0.4);
}

TEST(TimeLimit, TasksAreSmallAtTheEndAndNotWhereTheFirstImageIsLate) {
  double now = 0;
  const TimeLimit limit(100, 0, [&] { return now; });
  EXPECT_DOUBLE_EQ(limit.task_s(), 3);
  now = 98;
  EXPECT_DOUBLE_EQ(limit.task_s(), 1);
  now = 99.9;
  EXPECT_DOUBLE_EQ(limit.task_s(), 0.5);
  now = 150;
  EXPECT_DOUBLE_EQ(limit.task_s(), 3);
}

TEST(TimeLimit, NoLimitIsNeverUp) {
  const TimeLimit limit(0, 0, [] { return 1e9; });
  EXPECT_FALSE(limit.is_up(1e9));
  EXPECT_FALSE(limit.wants_rehearsal(true));
  EXPECT_TRUE(std::isinf(limit.task_s()));
}

RenderSettings small(double limit_s) {
  RenderSettings s;
  s.width = 64;
  s.height = 48;
  s.gather = 1;
  s.photons = 2000;
  s.light_samples = 1;
  s.time_limit_s = limit_s;
  return s;
}

/// What follows is rehearsed before the photons and with the first image, on a part that the filter takes as a picture,
/// and a render that has no time for more ends with the first image.
TEST(TimeLimit, AJobRehearsesItsEnd) {
  const Stage stage(builtin_scene("cornell"));
  std::vector<std::uint32_t> passes;
  const auto rehearsal = [&](const Film& film, const Job& job) {
    passes.push_back(job.passes());
    EXPECT_EQ(film.width(), 64);
    EXPECT_EQ(film.height(), 32);
    EXPECT_EQ(film.bounds().y0, 8);
    EXPECT_GE(film.whole_passes(), 2u);
    EXPECT_GT(make_image(film, job).channels().size(), 0u);
    // The next rehearsal, but for one of the first image, waits for 50 times as long.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  };
  RenderSettings asked = small(3600);
  Job job(stage.scene, stage.tracer, asked, nullptr, {3599.999, rehearsal});
  job.wait();
  EXPECT_THAT(passes, testing::ElementsAre(0, 1));
  EXPECT_EQ(job.ending(), Ending::time_up);
  EXPECT_EQ(job.passes(), 1u);

  asked = small(0);
  asked.samples = 3;
  passes.clear();
  Job unlimited(stage.scene, stage.tracer, asked, nullptr, {0, rehearsal});
  unlimited.wait();
  EXPECT_TRUE(passes.empty());
}

/// A rehearsal that shows that nearly all of the time is needed at the end stops the render early.
TEST(TimeLimit, AJobStopsWhereItsEndNeedsTheTime) {
  const Stage stage(builtin_scene("cornell"));
  const auto slow = [](const Film&, const Job& job) {
    // 32 of 48 rows.
    if (job.passes() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  };
  RenderSettings asked = small(3600);
  Job job(stage.scene, stage.tracer, asked, nullptr, {3600 - 0.031, slow});
  job.wait();
  EXPECT_EQ(job.ending(), Ending::time_up);
  EXPECT_EQ(job.passes(), 1u);
}

TEST(TimeLimit, FinishesThePassesThatAreNeeded) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings asked = small(3600);
  asked.progressive = true;
  Job job(stage.scene, stage.tracer, asked, nullptr, {3600, nullptr, 2});
  job.wait();
  EXPECT_EQ(job.passes(), 2u);
  EXPECT_EQ(job.film().whole_passes(), 2u);
}

}  // namespace
}  // namespace glowworm
