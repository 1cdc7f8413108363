// Sums that do not depend on the order or grouping of their terms.
#include "core/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

namespace glowworm {
namespace {

using Sum = ExactSum<Int128, 64>;

TEST(ExactSum, HoldsFloatsExactly) {
  for (const float value : {0.0f, 1.0f, -1.0f, 0.1f, 3e-12f, -1e-6f, 123456.78f, 2e11f, 1.5f}) {
    Sum sum;
    sum += value;
    EXPECT_EQ(sum.value(), static_cast<double>(value)) << value;
    sum += -value;
    EXPECT_EQ(sum.value(), 0) << value;
  }
  // Below the unit's precision terms are rounded, and vanish far below.
  Sum small;
  small += 1e-19f;
  EXPECT_NEAR(small.value(), 1e-19, 3e-20);
  Sum tiny;
  tiny += 1e-30f;
  EXPECT_EQ(tiny.value(), 0);
}

TEST(ExactSum, DependsNeitherOnOrderNorOnGrouping) {
  std::mt19937 random(7);
  std::vector<float> terms;
  for (int i = 0; i < 5000; ++i)
    terms.push_back(std::ldexp(static_cast<float>(random()) / 4e9f, static_cast<int>(random() % 60) - 30));
  Sum whole;
  double expected = 0;
  for (const float term : terms) {
    whole += term;
    expected += term;
  }
  EXPECT_NEAR(whole.value(), expected, 1e-12 * expected);
  for (const std::size_t group : {1, 7, 1000}) {
    std::shuffle(terms.begin(), terms.end(), random);
    std::vector<Sum> parts((terms.size() + group - 1) / group);
    for (std::size_t i = 0; i < terms.size(); ++i) parts[i / group] += terms[i];
    std::shuffle(parts.begin(), parts.end(), random);
    Sum together;
    for (const Sum& part : parts) together += part;
    EXPECT_EQ(together, whole) << group;
  }
}

TEST(ExactSum, BoundsTermsSoThatNoSumOverflows) {
  Sum sum;
  for (int i = 0; i < 1000; ++i) {
    sum += std::numeric_limits<float>::infinity();
    sum += std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_EQ(sum.value(), 1000.0 * Sum::kMaxTerm);
  EXPECT_TRUE(sum.can_be_of(1000));
  EXPECT_FALSE(sum.can_be_of(999));
  // As many terms as there is room for.
  const Sum most(sum.units() / 1000 * (1 << Sum::kTermBits) - 1);
  EXPECT_GT(most.value(), 0);
  using Unit = ExactSum<std::int64_t, 37>;
  Unit normal;
  normal += -1.0f;
  EXPECT_EQ(normal.value(), -1);
  EXPECT_GE(Unit::kMaxTerm, 1);
}

}  // namespace
}  // namespace glowworm
