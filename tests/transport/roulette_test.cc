// Russian roulette: its rule in numbers.
#include "transport/roulette.h"

#include <gtest/gtest.h>

namespace glowworm {
namespace {

TEST(Roulette, KeepsPathsThatCarryEnough) {
  EXPECT_EQ(survival(1, kLeastOfChains, 1), 1);
  EXPECT_EQ(survival(kLeastOfChains, kLeastOfChains, kEvenBounces), 1);
  // A survivor weighs the least weight.
  EXPECT_FLOAT_EQ(0.01f / survival(0.01f, kLeastOfChains, 5), kLeastOfChains);
  EXPECT_EQ(survival(0, kLeastOfPaths, 1), 0);
}

TEST(Roulette, EndsPathsThatLoseNothing) {
  double reach = 1, mean = 0;
  for (int bounce = 1; bounce <= 100 * kEvenBounces; ++bounce) {
    reach *= survival(1, 1, bounce);
    mean += reach;
    if (bounce == 2 * kEvenBounces) {
      EXPECT_NEAR(reach, 0.25, 1e-3);
    }
  }
  EXPECT_NEAR(reach, 1e-4, 1e-6);
  EXPECT_LT(mean, 2 * kEvenBounces);
}

}  // namespace
}  // namespace glowworm
