#include "kernels/kernel_shape.h"

#include <gtest/gtest.h>

namespace glowworm {
namespace {

TEST(Kernel, IntegratesToOneOverTheUnitDisc) {
  for (const KernelShape shape : kKernelShapes) {
    // In u = d^2 the integral of K over the disc is pi times that of K(u) over [0, 1]; midpoint rule.
    const int steps = 1000000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += kernel(shape, (i + 0.5) / steps);
    EXPECT_NEAR(std::numbers::pi * sum / steps, 1.0, 1e-7) << int(shape);
  }
}

TEST(Kernel, ProfileIsOneInTheMiddleAndFallsOutwards) {
  for (const KernelShape shape : kKernelShapes) {
    EXPECT_EQ(kernel_profile(shape, 0.0), 1.0);
    double last = 1;
    for (double d = 0.1; d < 1; d += 0.1) {
      const double value = kernel_profile(shape, d * d);
      EXPECT_LE(value, last);
      EXPECT_GT(value, 0);
      last = value;
    }
  }
}

TEST(Kernel, ConstantsAreThoseOfTheFormulas) {
  EXPECT_NEAR(kExpOfGaussianExponent, std::exp(kGaussianExponent), 1e-16);
  EXPECT_NEAR(kernel(KernelShape::epanechnikov, 0.25), 2 / std::numbers::pi * 0.75, 1e-15);
  EXPECT_NEAR(kernel(KernelShape::cone, 0.25), 3 / std::numbers::pi * 0.5, 1e-15);
}

}  // namespace
}  // namespace glowworm
