// The emission guide: samples follow density(), and means do not change.
#include "photon/emission_guide.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {
namespace {

EmissionNumbers numbers(Sampler& s) { return {s.next1(), s.next1(), s.next1(), s.next1(), s.next1()}; }

/// Worth something in a slanted tube through two of the numbers, and for a part of the lights.
float score_at(const EmissionNumbers& u) {
  const float across = u[1] - (0.2f + 0.5f * u[3]);
  return std::abs(across) < 0.05f && u[0] > 0.6f ? 1 + u[4] : 0.0f;
}

EmissionGuide learnt(int paths) {
  std::vector<PilotPath> pilot;
  for (int i = 0; i < paths; ++i) {
    Sampler sampler(SamplerKind::sobol, 1, 2, static_cast<std::uint32_t>(i));
    PilotPath& path = pilot.emplace_back();
    path.numbers = numbers(sampler);
    path.score = score_at(path.numbers);
  }
  return EmissionGuide::learn(pilot);
}

TEST(EmissionGuide, StopsLearningWhenCancelled) {
  Interrupt interrupt;
  interrupt.request();
  const CancellationScope scope(interrupt);
  EXPECT_THROW(learnt(1000), Cancelled);
}

TEST(EmissionGuide, IsUniformUntilItLearns) {
  const EmissionGuide guide;
  Sampler sampler(SamplerKind::independent, 1, 2, 3);
  EmissionNumbers u = numbers(sampler);
  const EmissionNumbers before = u;
  EXPECT_EQ(guide.warp(u), 1);
  EXPECT_EQ(u, before);
  EXPECT_EQ(guide.density(u), 1);
  EXPECT_EQ(guide.cell_count(), 1u);
}

TEST(EmissionGuide, LearnsNothingFromPathsWithoutLight) {
  std::vector<PilotPath> pilot(1000);
  for (std::uint32_t i = 0; i < pilot.size(); ++i) {
    Sampler sampler(SamplerKind::sobol, 1, 2, i);
    pilot[i].numbers = numbers(sampler);
  }
  EXPECT_EQ(EmissionGuide::learn(pilot).cell_count(), 1u);
  EXPECT_EQ(EmissionGuide::learn({}).cell_count(), 1u);
}

TEST(EmissionGuide, WeightIsOneOverDensity) {
  const EmissionGuide guide = learnt(200000);
  ASSERT_GT(guide.cell_count(), 50u);
  constexpr std::uint32_t kCount = 100000;
  std::uint32_t others = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    Sampler sampler(SamplerKind::sobol, 5, 6, i);
    EmissionNumbers u = numbers(sampler);
    const float weight = guide.warp(u);
    for (const float x : u) ASSERT_TRUE(x >= 0 && x < 1);
    others += std::abs(weight * guide.density(u) - 1) > 1e-5f;
    ASSERT_LE(weight, 1.0001f / EmissionGuide::kFloor);
  }
  // A number may be rounded over the edge of its cell: one of 2^24 places, of which a cell has at least 2^10 an axis.
  EXPECT_LT(others, kCount / 1000);
}

TEST(EmissionGuide, SamplesByItsDensity) {
  const EmissionGuide guide = learnt(200000);
  // Cells over the two numbers that the tube runs through and the one that chooses lights; the expected counts by
  // integrating the density over a fine grid of points in the others.
  constexpr int kSide = 8, kPoints = 2000000;
  std::vector<double> expected(kSide * kSide * kSide), seen(expected.size());
  const auto cell = [](const EmissionNumbers& u) {
    const auto part = [](float x) { return static_cast<std::size_t>(x * kSide); };
    return (part(u[0]) * kSide + part(u[1])) * kSide + part(u[3]);
  };
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    Sampler even(SamplerKind::independent, 7, 8, i);
    const EmissionNumbers u = numbers(even);
    expected[cell(u)] += guide.density(u) / kPoints;
  }
  constexpr int kSamples = 100000;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    Sampler sampler(SamplerKind::independent, 9, 10, i);
    EmissionNumbers u = numbers(sampler);
    guide.warp(u);
    seen[cell(u)] += 1;
  }
  double statistic = 0, total = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    ASSERT_GT(expected[i] * kSamples, 5);
    // The expectation has a noise of its own, of twenty times as many points.
    statistic += (seen[i] - expected[i] * kSamples) * (seen[i] - expected[i] * kSamples) / (expected[i] * kSamples);
    total += expected[i];
  }
  EXPECT_NEAR(total, 1, 0.01);
  // Chi-squared with 511 degrees of freedom: mean 511, standard deviation 32; 4 of these and the expectation's noise.
  EXPECT_LT(statistic, 511 * 1.1 + 4 * 32);
}

TEST(EmissionGuide, KeepsMeansAndLowersTheirNoise) {
  const EmissionGuide guide = learnt(200000);
  EXPECT_GT(guide.gain(), 3);
  double sum = 0, squares = 0, plain = 0, plain_squares = 0;
  constexpr int kSamples = 200000;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    Sampler sampler(SamplerKind::independent, 11, 12, i);
    EmissionNumbers u = numbers(sampler);
    const double unguided = score_at(u);
    plain += unguided;
    plain_squares += unguided * unguided;
    const double weight = guide.warp(u), guided = weight * score_at(u);
    sum += guided;
    squares += guided * guided;
  }
  // The tube is 0.1 wide and never leaves the unit square; two fifths of the lights; 1 + u in the mean 1.5.
  const double truth = 0.1 * 0.4 * 1.5;
  const double mean = sum / kSamples, variance = squares / kSamples - mean * mean;
  const double plain_mean = plain / kSamples, plain_variance = plain_squares / kSamples - plain_mean * plain_mean;
  EXPECT_NEAR(mean, truth, 4 * std::sqrt(variance / kSamples));
  EXPECT_LT(variance, 0.3 * plain_variance);
}

}  // namespace
}  // namespace glowworm
