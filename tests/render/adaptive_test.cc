// Adaptive sampling: which pixels get more samples, and that pictures stay the same and right.
#include "control/adaptive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "builtin/builtin.h"
#include "core/parallel.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

RenderSettings adaptive_render(int side, double noise) {
  RenderSettings s = by_photons(side, 0, 8, 20'000, "blocked");
  s.filter = Filtering::automatic;
  s.noise_target = noise;
  return s;
}

/// A film whose pixels all have so many black samples.
Film black_film(const PixelBounds& bounds, std::uint32_t samples) {
  Film film(bounds, false, false);
  const CameraTask task{bounds.x0, bounds.y0, bounds.x1, bounds.y1, 0, samples};
  SlotRadiance radiance;
  radiance.resize(task.slot_count());
  film.add(task, radiance, FirstHit(), Geometry());
  return film;
}

void add_black(Film& film, const std::vector<CameraTask>& tasks) {
  SlotRadiance radiance;
  for (const CameraTask& task : tasks) {
    radiance.resize(task.slot_count());
    film.add(task, radiance, FirstHit(), Geometry());
  }
}

std::uint32_t samples_at(const Film& film, int x, int y) { return film.sample_count(film.pixel_at(x, y)); }

/// A grey picture whose left half has much more noise.
FilmPicture noisy_on_the_left(const Film& film) {
  FilmPicture out{std::vector<RGB>(film.pixel_count(), RGB(1.0f)), std::vector<float>(film.pixel_count(), 1e-6f)};
  for (std::size_t i = 0; i < film.pixel_count(); ++i)
    if (static_cast<int>(i) % film.width() < film.width() / 2) out.variance[i] = 1e-2f;
  return out;
}

TEST(Adaptive, EvenRoundsAddASampleToEverySquare) {
  Film film = black_film({3, 5, 67, 42}, 4);
  add_black(film, {{8, 8, 12, 12, 4, 3}});  // One square.
  for (int round = 0; round < 2; ++round) add_black(film, tasks_of_round(film, even_round(film, 100)));
  EXPECT_EQ(samples_at(film, 3, 5), 6u);
  EXPECT_EQ(samples_at(film, 66, 41), 6u);
  EXPECT_EQ(samples_at(film, 8, 11), 9u);
  EXPECT_EQ(film.whole_passes(), 6u);
  EXPECT_FALSE(even_round(film, 7).empty());
  EXPECT_TRUE(even_round(film, 6).empty());
}

TEST(Adaptive, RoundsDoubleTheSamplesWhereNoiseIs) {
  // Neither side of the film is at the border of a block.
  Film film = black_film({3, 5, 67, 42}, 4);
  const FilmPicture picture = noisy_on_the_left(film);
  const SquareSamples round = next_round(film, picture, 0, 100);
  ASSERT_TRUE(is_round_of(film.bounds(), round));
  EXPECT_FALSE(is_round_of({0, 0, 16, 16}, round));
  const std::vector<CameraTask> tasks = tasks_of_round(film, round);
  add_black(film, tasks);
  EXPECT_TRUE(tasks_of_round(film, round).empty());
  for (const CameraTask& task : tasks) EXPECT_TRUE(film.has(task));
  EXPECT_EQ(samples_at(film, 3, 5), 8u);
  EXPECT_EQ(samples_at(film, 20, 41), 8u);
  EXPECT_EQ(samples_at(film, 50, 20), 4u);
  EXPECT_NEAR(film.mean_samples(), 4 * 1.5, 0.3);
  EXPECT_EQ(film.whole_passes(), 4u);
}

TEST(Adaptive, RoundsEndWhereTheTargetIsPredicted) {
  const Film film = black_film({0, 0, 64, 64}, 4);
  FilmPicture picture = noisy_on_the_left(film);
  const double error = relative_error(picture);
  const auto doubled = [&](double target) {
    Film next = film;
    add_black(next, tasks_of_round(next, next_round(next, picture, target, 100)));
    return next.mean_samples() / 4 - 1;
  };
  // Half of the picture has all of the noise. An eighth of it with twice the samples has 15 / 16 of the variance.
  EXPECT_NEAR(doubled(error * std::sqrt(15.0 / 16)), 1.0 / 16, 0.01);
  EXPECT_NEAR(doubled(error * std::sqrt(0.75)), 0.25, 0.01);
  EXPECT_NEAR(doubled(error / 10), kRoundGrowth, 0.01);
  EXPECT_TRUE(next_round(film, picture, 0, 4).empty());
}

/// Where earlier frames have as many samples, doubling the frame's own leaves 2 / 3 of the variance.
TEST(Adaptive, RoundsKnowWhatEarlierFramesHaveDone) {
  const Film film = black_film({0, 0, 64, 64}, 4);
  FilmPicture picture = noisy_on_the_left(film);
  picture.earlier.assign(film.pixel_count(), 4);
  const double error = relative_error(picture);
  const auto doubled = [&](double target) {
    Film next = film;
    add_black(next, tasks_of_round(next, next_round(next, picture, target, 100)));
    return next.mean_samples() / 4 - 1;
  };
  EXPECT_NEAR(doubled(error * std::sqrt(11.0 / 12)), 0.125, 0.01);
  EXPECT_NEAR(doubled(error * std::sqrt(5.0 / 6)), 0.25, 0.01);
}

TEST(Adaptive, WhatASquareFoundDoesNotChooseIt) {
  const Film film = black_film({0, 0, 64, 64}, 4);
  FilmPicture picture{std::vector<RGB>(film.pixel_count(), RGB(1.0f)), std::vector<float>(film.pixel_count(), 1e-6f)};
  for (int y = 32; y < 36; ++y)
    for (int x = 32; x < 36; ++x) picture.variance[static_cast<std::size_t>(64 * y + x)] = 1;
  const SquareSamples round = next_round(film, picture, 0, 100);
  const auto at = [&](int column, int row) { return round[static_cast<std::size_t>(16 * row + column)]; };
  EXPECT_EQ(at(8, 7), 8u);
  EXPECT_EQ(at(9, 9), 8u);
  // Its neighbours say that there is no more noise than further on.
  EXPECT_EQ(at(8, 8), at(12, 8));
}

TEST(Adaptive, SquaresWithFewSamplesTakePart) {
  Film film = black_film({0, 0, 64, 64}, 4);
  FilmPicture picture = noisy_on_the_left(film);
  for (int round = 0; round < 12; ++round) add_black(film, tasks_of_round(film, next_round(film, picture, 0, 1 << 20)));
  EXPECT_GT(film.whole_passes(), 4u);
  EXPECT_GT(film.whole_passes(), film.mean_samples() / 16);
  EXPECT_GT(samples_at(film, 0, 0), samples_at(film, 63, 0));
}

TEST(SlowAdaptiveRender, NeedsFewerSamplesForTheSameError) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = adaptive_render(64, 0.03);
  const Film film = stage.render(settings);
  settings.adaptive = false;
  const Film even = stage.render(settings);
  EXPECT_TRUE(even.is_even());
  EXPECT_FALSE(film.is_even());
  EXPECT_LE(relative_error(filtered_picture(film, false)), settings.noise_target);
  EXPECT_LT(film.mean_samples(), 0.9 * even.mean_samples());
}

TEST(AdaptiveRender, CountsThePassesOfRounds) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = adaptive_render(16, 0.001);
  settings.samples = 2 * kEvenSamples;
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  EXPECT_EQ(job.ending(), Ending::samples_done);
  EXPECT_EQ(job.film().whole_passes(), settings.samples);
  EXPECT_EQ(job.passes(), settings.samples);
}

TEST(AdaptiveRender, GivesTheSameBitsForAnyThreadsAndMemoryAndAfterInterruptions) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = adaptive_render(48, 0.06);
  const std::vector<std::uint32_t> whole = stage.render(settings).save();
  const int threads = thread_count();
  set_thread_count(3);
  settings.memory_bytes = std::uint64_t{48} << 20;
  const bool same = stage.render(settings).save() == whole;
  set_thread_count(threads);
  EXPECT_TRUE(same);
  // Interrupted in each round.
  Checkpoint checkpoint;
  std::size_t interruptions = 0;
  for (;; ++interruptions) {
    Job job(stage.scene, stage.tracer, settings, interruptions == 0 ? nullptr : &checkpoint);
    const std::uint64_t tasks = job.tasks();
    while (!job.done() && (job.tasks() < tasks + 2 || job.checkpoint().round.empty())) std::this_thread::yield();
    job.cancel();
    job.wait();
    checkpoint = job.checkpoint();
    if (job.ending() == Ending::noise_reached) break;
    ASSERT_LT(interruptions, 200u);
  }
  EXPECT_GE(interruptions, 1u);
  EXPECT_TRUE(checkpoint.film == whole);
}

TEST(SlowAdaptiveRender, HasTheMeanOfEvenSamples) {
  const Stage stage(builtin_scene("ring"));
  // Both renders of a seed have the same photons.
  constexpr int kRenders = 10;
  double sum = 0, squares = 0;
  for (int seed = 0; seed < kRenders; ++seed) {
    RenderSettings settings = adaptive_render(24, 0.15);
    settings.seed = static_cast<std::uint32_t>(seed);
    const double adaptive = mean(stage.render(settings)).luminance();
    settings.noise_target = 0;
    settings.samples = 32;
    const double ratio = adaptive / mean(stage.render(settings)).luminance() - 1;
    sum += ratio;
    squares += ratio * ratio;
  }
  const double ratio = sum / kRenders;
  const double error = std::sqrt((squares / kRenders - ratio * ratio) / (kRenders - 1));
  EXPECT_LT(error, 0.004);
  EXPECT_NEAR(ratio, 0, 3 * error);
}

}  // namespace
}  // namespace glowworm
