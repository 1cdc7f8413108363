// The noise of photon maps: predicted from one map, and seen in the spread of several.
#include "maps/photon_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "builtin/builtin.h"
#include "control/job_report.h"
#include "core/error.h"
#include "core/parallel.h"
#include "film/checkpoint.h"
#include "film/part.h"
#include "render/render_testing.h"
#include "settings/render_key.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

/// The map shown directly, with little noise beside that of the photons.
RenderSettings few_photons(std::uint32_t seed, std::uint64_t photons) {
  RenderSettings settings = by_photons(48, 8, 0, photons, "blocked");
  settings.integrator = Integrator::photons;
  settings.seed = seed;
  return settings;
}

double photon_variance(const Stage& stage, const RenderSettings& settings) {
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  return job.photon_variance();
}

TEST(SlowPhotonNoise, IsTheSpreadOfMapsWithOtherPhotons) {
  constexpr std::uint32_t kRenders = 24;
  const Stage stage(builtin_scene("cornell"));
  std::vector<std::vector<double>> pixels;
  double predicted = 0;
  for (std::uint32_t seed = 0; seed < kRenders; ++seed) {
    Job job(stage.scene, stage.tracer, few_photons(seed, 4000));
    job.wait();
    const Film& film = job.film();
    predicted += job.photon_variance() / kRenders;
    pixels.emplace_back();
    for (std::size_t i = 0; i < film.pixel_count(); ++i) pixels.back().push_back(luminance(film.radiance(i, false)));
  }
  const std::size_t count = pixels.front().size();
  std::vector<double> mean(count), variance(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::vector<double>& picture : pixels) mean[i] += picture[i] / kRenders;
    for (const std::vector<double>& picture : pixels)
      variance[i] += (picture[i] - mean[i]) * (picture[i] - mean[i]) / (kRenders - 1);
  }
  double level = 0, spread = 0;
  for (const double m : mean) level += m / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i)
    spread += variance[i] / (mean[i] * mean[i] + 0.01 * level * level) / static_cast<double>(count);
  EXPECT_NEAR(std::sqrt(predicted / spread), 1, 0.2);
}

TEST(SlowPhotonNoise, FallsWithTheirNumber) {
  const Stage stage(builtin_scene("ajar"));
  const auto variance = [&](std::uint64_t photons) {
    RenderSettings settings = by_photons(64, 2, 16, photons, "blocked");
    settings.secondary_gather = false;  // the fewer photons, the more rays it takes
    double sum = 0;
    for (settings.seed = 0; settings.seed < 4; ++settings.seed) sum += photon_variance(stage, settings);
    return sum;
  };
  const double ratio = variance(5000) / variance(80'000);
  EXPECT_GT(ratio, 4) << "sixteen times the photons";
  EXPECT_LT(ratio, 64);
}

TEST(PhotonNoise, IsNotSharedWherePhotonsAreNot) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = few_photons(1, 4000);
  settings.progressive = true;
  EXPECT_EQ(photon_variance(stage, settings), 0);
  EXPECT_EQ(photon_variance(stage, by_path(16, 2)), 0);
}

/// Ends by noise, and so takes more photons than it is given.
RenderSettings ends_by_noise(int side, double target) {
  RenderSettings settings = by_photons(side, 4, 8, 4000, "blocked");
  settings.filter = Filtering::automatic;
  settings.noise_target = settings.photon_target = target;
  return settings;
}

TEST(SlowPhotonNoise, RendersThatEndByNoiseTakeMorePhotons) {
  const Stage stage(builtin_scene("ajar"));
  constexpr double kTarget = 0.05;
  constexpr std::uint32_t kRenders = 6;
  double before = 0, after = 0;
  for (std::uint32_t seed = 0; seed < kRenders; ++seed) {
    RenderSettings few = by_photons(96, 1, 8, 4000, "blocked"), settings = ends_by_noise(96, kTarget);
    few.seed = settings.seed = seed;
    before += photon_variance(stage, few) / kRenders;
    Job job(stage.scene, stage.tracer, settings);
    job.wait();
    after += job.photon_variance() / kRenders;
    EXPECT_TRUE(job.has_more_photons());
    EXPECT_GT(job.settings().photons, 8000u);
    EXPECT_GT(job.settings().nearest, 50u);
    // What continues it begins with the same number.
    EXPECT_EQ(key_text(job.key()), key_text(render_key(*stage.scene, resolve(settings, *stage.scene))));
  }
  EXPECT_GT(before, 1.5 * kTarget * kTarget);
  EXPECT_LT(after, kTarget * kTarget);

  Job noisy(stage.scene, stage.tracer, ends_by_noise(96, 1));
  noisy.wait();
  EXPECT_FALSE(noisy.has_more_photons());
  EXPECT_EQ(noisy.settings().photons, 4000u);
}

TEST(PhotonNoise, MorePhotonsAreTheSameForAnyThreadsAndMemoryAndAfterInterruptions) {
  const Stage stage(builtin_scene("ajar"));
  const RenderSettings settings = ends_by_noise(48, 0.1);
  const std::vector<std::uint32_t> whole = stage.render(settings).save();
  const int threads = thread_count();
  set_thread_count(3);
  for (const DiskUse disk : {DiskUse::automatic, DiskUse::never}) {
    RenderSettings scarce = settings;
    scarce.memory_bytes = std::uint64_t{48} << 20;
    scarce.disk = disk;
    EXPECT_TRUE(stage.render(scarce).save() == whole) << static_cast<int>(disk);
  }
  set_thread_count(threads);
  Job interrupted(stage.scene, stage.tracer, settings);
  while (interrupted.tasks() == 0 && !interrupted.done()) std::this_thread::yield();
  interrupted.cancel();
  interrupted.wait();
  const Checkpoint checkpoint = interrupted.checkpoint();
  Job more(stage.scene, stage.tracer, settings, &checkpoint);
  more.wait();
  EXPECT_EQ(more.settings().photons, interrupted.settings().photons);
  EXPECT_TRUE(more.film().save() == whole);
  // To another end, in little memory.
  for (const double target : {0.0, 0.05}) {
    RenderSettings other = settings;
    other.noise_target = target;
    other.memory_bytes = std::uint64_t{48} << 20;
    Job continued(stage.scene, stage.tracer, other, &checkpoint);
    continued.wait();
    EXPECT_EQ(continued.settings().photons, interrupted.settings().photons) << target;
  }
}

TEST(PhotonNoise, LeavesAtLeastHalfOfTheErrorToSamples) {
  EXPECT_DOUBLE_EQ(noise_left_to_samples(0.1, 0), 0.1);
  EXPECT_DOUBLE_EQ(noise_left_to_samples(0.1, 0.0036), 0.08);
  EXPECT_DOUBLE_EQ(noise_left_to_samples(0.1, 0.02), std::sqrt(0.005));
  EXPECT_EQ(noise_left_to_samples(0, 0.02), 0);
}

TEST(PhotonNoise, OnlyAutomaticPhotonsFollowIt) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings asked;
  asked.noise_target = 0.01;
  EXPECT_EQ(resolve(asked, *stage.scene).photon_target, 0.01);
  RenderSettings given = asked, timed = asked, progressive = asked;
  given.photons = 1000;
  timed.time_limit_s = 60;
  progressive.progressive = true;
  for (const RenderSettings& s : {given, timed, progressive, RenderSettings()})
    EXPECT_EQ(resolve(s, *stage.scene).photon_target, 0);
}

TEST(PhotonNoise, OfPartsIsMeasuredByTheFirst) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = few_photons(1, 4000);
  const double whole = photon_variance(stage, settings);
  EXPECT_GT(whole, 0);
  settings.part = {1, 2};
  EXPECT_EQ(photon_variance(stage, settings), whole);
  settings.part = {2, 2};
  EXPECT_EQ(photon_variance(stage, settings), 0);
}

TEST(PhotonNoise, IsTheSameInLittleMemory) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = few_photons(1, 4000);
  settings.memory_bytes = std::uint64_t{20} << 20;
  const int threads = thread_count();
  set_thread_count(1);
  const double in_little = photon_variance(stage, settings);
  settings.memory_bytes = std::uint64_t{200} << 20;
  const double in_enough = photon_variance(stage, settings);
  set_thread_count(threads);
  EXPECT_GT(in_little, 0);
  EXPECT_EQ(in_little, in_enough);
}

TEST(PhotonNoise, CostsLittleHoweverManyRaysThereAre) {
  const Stage stage(builtin_scene("cornell"));
  Job job(stage.scene, stage.tracer, by_photons(64, 1, 256, 10'000, "blocked"));
  job.wait();
  EXPECT_GT(job.photon_variance(), 0);
  EXPECT_LT(job.statistics().seconds(Phase::photon_noise), 0.25 * job.statistics().seconds(Phase::total));
}

TEST(PhotonNoise, ComesBackFromFilesThatCanHoldIt) {
  const Stage stage(builtin_scene("cornell"));
  const TemporaryFolder folder;
  const std::string file = folder.path("render");
  Job job(stage.scene, stage.tracer, few_photons(1, 4000));
  job.wait();
  write_checkpoint(file, job.checkpoint());
  Checkpoint checkpoint = *read_checkpoint(file);
  Job finished(stage.scene, stage.tracer, few_photons(1, 4000), &checkpoint);
  finished.wait();
  EXPECT_EQ(finished.photon_variance(), job.photon_variance());
  Part part = part_of(job);
  write_part(file, part, job.film());
  EXPECT_EQ(read_part(file).picture.photon_variance, job.photon_variance());
  part.picture.photon_variance = -1;
  write_part(file, part, job.film());
  EXPECT_THROW(read_part(file), Error);
  for (const double impossible : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    checkpoint.photon_variance = impossible;
    EXPECT_THROW(Job(stage.scene, stage.tracer, few_photons(1, 4000), &checkpoint), Error) << impossible;
  }
}

}  // namespace
}  // namespace glowworm
