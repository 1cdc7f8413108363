#include "core/distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

TEST(Distribution1D, ChoosesInProportionToWeights) {
  const std::vector<float> weights = {0, 3, 0, 1, 0.5f, 20, 0};
  const Distribution1D distribution(weights);
  EXPECT_DOUBLE_EQ(distribution.total(), 24.5);
  std::vector<double> observed(weights.size()), expected;
  constexpr int samples = 100000;
  for (const float w : weights) expected.push_back(w / 24.5 * samples);
  for (std::uint32_t i = 0; i < samples; ++i) {
    const auto s = distribution.sample(to_unit_float(hash_combine(2, i)));
    EXPECT_EQ(s.probability, distribution.probability(s.index));
    ++observed[s.index];
  }
  expect_fit(chi_squared_counts(observed, expected).p_value, 3, "Distribution1D");
  for (std::uint32_t i = 0; i < weights.size(); ++i) EXPECT_FLOAT_EQ(distribution.probability(i), weights[i] / 24.5f);
}

TEST(Distribution1D, RemappedNumberIsUniformWithinTheChoice) {
  const Distribution1D distribution(std::vector<float>{1, 2, 5});
  const auto point = [&](int i) {
    const auto s = distribution.sample(to_unit_float(hash_combine(3, static_cast<std::uint32_t>(i))));
    return Vec2{(s.index + 0.5f) / 3, s.remapped};
  };
  const auto density = [&](Vec2 p) { return 3 * distribution.probability(static_cast<std::uint32_t>(p.x * 3)); };
  expect_fit(chi_squared_square(point, density, 100000, 3, 32).p_value, 3, "remapped");
}

TEST(Distribution1D, EndsOfTheUnitIntervalFallOnWeights) {
  const Distribution1D distribution(std::vector<float>{0, 1, 0});
  for (const float u : {0.0f, 0.5f, 0x1.fffffep-1f}) {
    const auto s = distribution.sample(u);
    EXPECT_EQ(s.index, 1u);
    EXPECT_EQ(s.probability, 1);
    EXPECT_LT(s.remapped, 1);
  }
}

/// Numbers on, just below and between the ends of intervals find the last interval that begins at or below them, also
/// where nearly all intervals lie close together.
TEST(Distribution1D, FindsTheIntervalOfEveryNumber) {
  for (const float largest : {1.0f, 1e6f}) {
    std::vector<float> weights(1000);
    for (std::uint32_t i = 0; i < weights.size(); ++i) weights[i] = i % 5 == 0 ? 0.0f : to_unit_float(hash32(i));
    weights[617] = largest;
    const Distribution1D distribution(weights);
    std::vector<double> begins(1, 0.0);
    for (const float w : weights) begins.push_back(begins.back() + w);
    for (double& b : begins) b /= distribution.total();
    std::vector<float> numbers;
    for (const double b : begins) {
      const auto on = static_cast<float>(b);
      for (const float u : {on, std::nextafter(on, 0.0f), std::nextafter(on, 2.0f)}) numbers.push_back(u);
    }
    for (std::uint32_t i = 0; i < 1000; ++i) numbers.push_back(to_unit_float(hash_combine(9, i)));
    for (const float u : numbers) {
      if (u >= 1) continue;
      const auto above = std::upper_bound(begins.begin(), begins.end(), static_cast<double>(u));
      EXPECT_EQ(distribution.sample(u).index, static_cast<std::uint32_t>(above - begins.begin() - 1)) << u;
    }
  }
}

TEST(Distribution1D, AllZeroIsUniform) {
  const Distribution1D distribution(std::vector<float>(4, 0.0f));
  EXPECT_EQ(distribution.total(), 0);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(distribution.probability(i), 0.25f);
  EXPECT_EQ(distribution.sample(0.6f).index, 2u);
}

TEST(Distribution2D, SamplesFollowItsDensity) {
  constexpr int width = 8, height = 5;
  std::vector<float> weights(width * height);
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = i % 7 == 0 ? 0.0f : to_unit_float(hash32(static_cast<std::uint32_t>(i))) + (i == 20 ? 10.0f : 0.0f);
  const Distribution2D distribution(weights, width, height);
  const auto point = [&](int i) {
    const auto s = distribution.sample(Sampler(SamplerKind::independent, 4, 0, static_cast<std::uint32_t>(i)).next2());
    EXPECT_NEAR(s.pdf, distribution.pdf(s.point), 1e-4f * s.pdf);
    return s.point;
  };
  const auto result = chi_squared_square(
      point, [&](Vec2 p) { return distribution.pdf(p); }, 100000, width * 3, height * 3);
  EXPECT_NEAR(result.integral, 1, 1e-5);
  expect_fit(result.p_value, 3, "Distribution2D");
}

}  // namespace
}  // namespace glowworm
