// The scheduler: tasks cover the picture, fit into memory and do not change the picture.
#include "control/scheduler.h"

#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "control/time_limit.h"
#include "core/error.h"
#include "density/engine.h"
#include "maps/memory.h"
#include "render_testing.h"

namespace glowworm {
namespace {

RenderSettings settings_for(int width, int height, std::uint32_t samples, std::uint32_t gather) {
  RenderSettings s;
  s.width = width;
  s.height = height;
  s.bounds = {0, 0, width, height};
  s.samples = samples;
  s.gather = gather;
  s.threads = 2;
  return s;
}

TEST(Scheduler, TasksOfAPassCoverEveryPixelOnce) {
  for (const auto& [width, height] : {std::pair{1, 1}, {17, 5}, {300, 200}, {1920, 1080}, {65536, 3}, {3, 5000}})
    for (const std::uint64_t room : {std::uint64_t{24} << 20, std::uint64_t{128} << 20, std::uint64_t{4} << 30}) {
      const RenderSettings settings = settings_for(width, height, 4, 25);
      const Schedule schedule = make_schedule(settings, room);
      std::vector<int> covered(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      for (const CameraTask& task : tasks_of_pass(schedule, settings, 1, 2)) {
        EXPECT_EQ(task.first_sample, 1u);
        EXPECT_EQ(task.sample_count, 2u);
        ASSERT_TRUE(task.x0 >= 0 && task.x0 < task.x1 && task.x1 <= width);
        ASSERT_TRUE(task.y0 >= 0 && task.y0 < task.y1 && task.y1 <= height);
        for (int y = task.y0; y < task.y1; ++y)
          for (int x = task.x0; x < task.x1; ++x) ++covered[static_cast<std::size_t>(y) * width + x];
      }
      EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](int n) { return n == 1; })) << width << 'x' << height;
    }
}

TEST(Scheduler, TasksOfAPartCoverItsPixelsOnce) {
  for (const PixelBounds part : {PixelBounds{5, 3, 6, 4}, {100, 50, 299, 200}, {17, 0, 33, 200}, {0, 0, 300, 200}})
    for (const std::uint64_t room : {std::uint64_t{24} << 20, std::uint64_t{4} << 30}) {
      RenderSettings settings = settings_for(300, 200, 4, 100);
      settings.bounds = part;
      std::uint64_t covered = 0;
      for (const CameraTask& task : tasks_of_pass(make_schedule(settings, room), settings, 0, 1)) {
        ASSERT_TRUE(task.x0 >= part.x0 && task.x0 < task.x1 && task.x1 <= part.x1);
        ASSERT_TRUE(task.y0 >= part.y0 && task.y0 < task.y1 && task.y1 <= part.y1);
        covered += task.pixel_count();
      }
      EXPECT_EQ(covered, part.pixel_count());
    }
}

TEST(Scheduler, TasksFitTheRoom) {
  for (const Preference preference : {Preference::automatic, Preference::preview, Preference::quality})
    for (const std::uint32_t gather : {1u, 25u, 600u})
      for (const std::uint64_t room : {std::uint64_t{24} << 20, std::uint64_t{100} << 20, std::uint64_t{2} << 30}) {
        RenderSettings settings = settings_for(1000, 800, 16, gather);
        settings.preference = preference;
        const Schedule schedule = make_schedule(settings, room);
        for (const CameraTask& task : tasks_of_pass(schedule, settings, 1, samples_of_pass(schedule, settings, 1)))
          EXPECT_LE(
              task.slot_count() * bytes_per_slot(0) + schedule.queries_at_once * kBytesPerQuery + 2 * kBytesPerThread,
              room);
      }
  EXPECT_THROW(make_schedule(settings_for(100, 100, 1, 1), 1 << 20), Error);
}

/// What is kept of first hits counts.
TEST(Scheduler, TasksWithPlacesTakeMore) {
  RenderSettings settings = settings_for(100, 100, 1, 1);
  const std::uint64_t plain = smallest_room(settings);
  settings.aovs = {"position"};
  FirstHit hit;
  hit.resize(16 * 16, settings.place_layers().of_triangles());
  ASSERT_EQ(hit.triangle.size(), 256u);
  EXPECT_GE(smallest_room(settings),
            plain + hit.triangle.size() * sizeof(std::uint32_t) + hit.barycentric.size() * sizeof(Vec2));
  EXPECT_THROW(make_schedule(settings, smallest_room(settings) - 1), Error);
}

TEST(Scheduler, AWholeImageComesFirstAndAllSamplesInTheEnd) {
  for (const int side : {16, 200, 2000}) {
    RenderSettings settings = settings_for(side, side, 100, 25);
    settings.engine = "reverse";
    settings.photons = 500'000;
    const Schedule schedule = make_schedule(settings, std::uint64_t{1} << 30);
    EXPECT_EQ(samples_of_pass(schedule, settings, 0), 1u);
    std::uint32_t done = 0, passes = 0;
    for (; done < settings.samples; ++passes) {
      const std::uint32_t samples = samples_of_pass(schedule, settings, done);
      EXPECT_GE(samples, 1u);
      EXPECT_LE(samples, std::max(1u, done));
      done += samples;
    }
    EXPECT_EQ(done, settings.samples);
    // Small pictures take several samples in a pass, large ones do not.
    EXPECT_EQ(passes < 20, side == 16) << side;
  }
  RenderSettings progressive = settings_for(16, 16, 100, 25);
  progressive.engine = "reverse";
  progressive.progressive = true;
  const Schedule schedule = make_schedule(progressive, std::uint64_t{1} << 30);
  EXPECT_EQ(samples_of_pass(schedule, progressive, 50), 1u);
}

TEST(Scheduler, TasksOfALimitedTimeTakeASmallShareOfIt) {
  RenderSettings settings = settings_for(1280, 720, 1u << 20, 25);
  const Schedule unlimited = make_schedule(settings, std::uint64_t{8} << 30);
  std::uint64_t before = 0;
  for (const double limit : {1.0, 5.0, 20.0}) {
    settings.time_limit_s = limit;
    const Schedule schedule = make_schedule(settings, std::uint64_t{8} << 30);
    const std::uint64_t queries = schedule.slots_at_once * settings.gather;
    EXPECT_LE(static_cast<double>(queries), 100'000 * settings.threads * limit + 50'000) << limit;
    EXPECT_GT(queries, before) << limit;
    EXPECT_LT(schedule.slots_at_once, unlimited.slots_at_once) << limit;
    before = queries;
  }
  settings.time_limit_s = 1e6;
  EXPECT_EQ(make_schedule(settings, std::uint64_t{8} << 30).slots_at_once, unlimited.slots_at_once);
}

/// Plays a render on a machine where a camera sample takes as long as `slot_seconds` says at a time, and what follows
/// the last one takes `finish_s`. Returns the time at which it ends, by the rule of Job.
template <typename SlotSeconds>
double played(const RenderSettings& settings, const SlotSeconds& slot_seconds, double finish_s = 0) {
  const Schedule schedule = make_schedule(settings, std::uint64_t{8} << 30);
  double time = 0, known = 0;
  TimeLimit limit(settings.time_limit_s, 0, [&] { return time; });
  limit.rehearse(false, 1, [&] { time += finish_s; });
  for (std::uint32_t sample = 0;; ++sample) {
    std::vector<CameraTask> left = tasks_of_pass(schedule, settings, sample, 1);
    std::reverse(left.begin(), left.end());
    std::vector<int> covered(static_cast<std::size_t>(settings.height), 0);
    while (!left.empty()) {
      const std::vector<CameraTask> tasks = next_tasks(left, schedule.slots_at_once, limit.task_s(), known);
      const auto slots = static_cast<double>(CameraTasks(tasks).slot_count());
      if (sample > 0 && limit.is_up(known * slots)) return time + finish_s;
      known = slot_seconds(time);
      time += known * slots;
      for (const CameraTask& task : tasks)
        for (int y = task.y0; y < task.y1; ++y) covered[static_cast<std::size_t>(y)] += task.x1 - task.x0;
    }
    for (const int pixels : covered) EXPECT_EQ(pixels, settings.width);
  }
}

TEST(Scheduler, TimeLimitHoldsOnABusyMachine) {
  RenderSettings settings = settings_for(256, 144, 1u << 20, 4);
  settings.time_limit_s = 20;
  // A whole pass in one piece takes from two to eleven seconds.
  const auto slow = [](double) { return 150e-6; };
  const auto slowing = [](double time) { return time < 14 ? 50e-6 : 300e-6; };
  const auto changing = [](double time) { return static_cast<int>(time / 2) % 2 == 0 ? 50e-6 : 150e-6; };
  EXPECT_NEAR(played(settings, slow), 20, 1);
  EXPECT_NEAR(played(settings, slowing), 20, 2);
  EXPECT_NEAR(played(settings, changing), 20, 2);
  EXPECT_NEAR(played(settings, slow, 4), 20, 1);
  // A row of blocks takes five seconds.
  settings = settings_for(8192, 64, 1u << 20, 4);
  settings.time_limit_s = 60;
  const auto wide = [](double) { return 40e-6; };
  EXPECT_NEAR(played(settings, wide), 60, 0.9);
  EXPECT_NEAR(played(settings, wide, 6), 60, 0.9);
}

TEST(Scheduler, PortionsStayWithinUsefulMemory) {
  const std::uint64_t room = std::uint64_t{16} << 30;
  std::size_t before = 0;
  for (const int side : {64, 256, 512, 1024, 4096}) {
    RenderSettings settings = settings_for(side, side, 16, 25);
    settings.photons = 100'000;
    const Schedule schedule = make_schedule(settings, room);
    EXPECT_GE(schedule.queries_at_once, 2 * settings.photons) << side;
    // A small part of what sixteen samples bring.
    const std::size_t rays = static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 25 * 16;
    EXPECT_LE(4 * schedule.queries_at_once, std::max<std::size_t>(8 * settings.photons, rays)) << side;
    EXPECT_GE(schedule.queries_at_once, before) << side;
    before = schedule.queries_at_once;
    // The samples asked for do not show: a render may go on with more of them.
    settings.samples = 1024;
    EXPECT_EQ(make_schedule(settings, room).queries_at_once, before) << side;
  }
  EXPECT_EQ(before, DensityEngine::kMaxPointsAtOnce);
}

/// A film has room for so many ids.
TEST(Scheduler, FilmsThatProcessesSendHoldAllIds) {
  RenderSettings settings = settings_for(1280, 720, 1000, 25);
  const Schedule schedule = make_schedule(settings, std::uint64_t{1} << 30);
  EXPECT_GT(shared_tasks(schedule, settings, 2).samples_at_once, kMaxIdsOfPixel);
  for (const char* layer : {"object-id", "material-id", "cryptomatte"}) {
    settings.aovs = {layer};
    EXPECT_EQ(most_shared_samples(settings), kMaxIdsOfPixel) << layer;
    EXPECT_LE(shared_tasks(schedule, settings, 2).samples_at_once, kMaxIdsOfPixel) << layer;
  }
}

TEST(Scheduler, TasksByDiskLeaveRoomForTheCache) {
  for (const std::uint64_t room : {std::uint64_t{30} << 20, std::uint64_t{70} << 20, std::uint64_t{2} << 30}) {
    RenderSettings settings = settings_for(1000, 800, 16, 100);
    settings.disk = DiskUse::always;
    const Schedule schedule = make_schedule(settings, room);
    EXPECT_TRUE(schedule.by_disk);
    const std::uint64_t taken =
        schedule.slots_at_once * bytes_per_slot(0) + schedule.queries_at_once * kBytesPerQuery + 2 * kBytesPerThread;
    EXPECT_GE(room, taken + room / 32) << room;
  }
}

TEST(Scheduler, PreferenceChoosesSamplesPerPassOrLargeTiles) {
  RenderSettings settings = settings_for(1000, 800, 17, 25);
  settings.engine = "reverse";
  const auto schedule = [&](Preference preference) {
    settings.preference = preference;
    return make_schedule(settings, std::uint64_t{1} << 30);
  };
  const Schedule preview = schedule(Preference::preview);
  EXPECT_EQ(samples_of_pass(preview, settings, 0), 1u);
  EXPECT_EQ(samples_of_pass(preview, settings, 4), 1u);
  const Schedule quality = schedule(Preference::quality);
  // A whole noisy image comes first in any case; then each tile gets all that is left.
  EXPECT_EQ(samples_of_pass(quality, settings, 0), 1u);
  EXPECT_EQ(samples_of_pass(quality, settings, 1), 16u);
  const TileSize large = tile_size(preview, settings, 1), small = tile_size(quality, settings, 16);
  EXPECT_LT(8 * small.width * small.height, large.width * large.height);
  EXPECT_GT(32 * small.width * small.height, large.width * large.height);
  // Where nobody knows how many samples there will be, passes double.
  settings.time_limit_s = 10;
  EXPECT_EQ(samples_of_pass(quality, settings, 1), 1u);
  EXPECT_EQ(samples_of_pass(quality, settings, 4), 4u);
}

TEST(Scheduler, PreferenceDoesNotChangeThePicture) {
  const Stage stage(builtin_scene("cornell"));
  for (const char* engine : {"blocked", "reverse"}) {
    RenderSettings settings = by_photons(40, 6, 20, 4000, engine);
    std::vector<std::vector<std::uint32_t>> films;
    for (const Preference preference : {Preference::automatic, Preference::preview, Preference::quality}) {
      settings.preference = preference;
      films.push_back(stage.render(settings).save());
    }
    EXPECT_EQ(films[1], films[0]) << engine;
    EXPECT_EQ(films[2], films[0]) << engine;
  }
}

TEST(Scheduler, NoiseIsCheckedAfterEverySampleWhateverTheMemory) {
  RenderSettings settings = settings_for(16, 16, 100, 25);
  settings.engine = "reverse";
  settings.noise_target = 0.01;
  const Schedule schedule = make_schedule(settings, std::uint64_t{1} << 30);
  for (const std::uint32_t done : {0u, 1u, 8u, 99u}) EXPECT_EQ(samples_of_pass(schedule, settings, done), 1u) << done;
}

}  // namespace
}  // namespace glowworm
