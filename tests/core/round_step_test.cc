#include "core/round_step.h"

#include <gtest/gtest.h>

#include <tuple>

namespace glowworm {
namespace {

TEST(RoundStep, IsOneTwoOrFiveTimesAPowerOfTen) {
  const std::tuple<double, double, double> cases[] = {{1, 1, 1}, {1.5, 1, 2}, {2, 2, 2},
                                                      {3, 2, 5}, {5, 5, 5},   {9.99, 5, 10}};
  for (const double unit : {1e-3, 1.0, 1e4})
    for (const auto& [value, below, above] : cases) {
      EXPECT_DOUBLE_EQ(round_step_below(value * unit), below * unit) << value << ' ' << unit;
      EXPECT_DOUBLE_EQ(round_step_above(value * unit), above * unit) << value << ' ' << unit;
    }
}

}  // namespace
}  // namespace glowworm
