#include "points/finite_light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace glowworm {
namespace {

TEST(FiniteLight, SamplesThatAreNotFiniteBecomeBlackAsAWhole) {
  SlotRadiance radiance;
  radiance.resize(5);
  for (std::size_t i = 0; i < 5; ++i) radiance.emitted[i] = radiance.direct[i] = RGB(static_cast<float>(i + 1));
  radiance.direct[1].g = NAN;
  radiance.indirect[2].b = INFINITY;
  radiance.caustic[3].r = 2e30f;
  EXPECT_EQ(drop_infinite_samples(radiance), 3u);
  for (const std::size_t black : {1, 2, 3}) {
    for (const auto* layer : {&radiance.emitted, &radiance.direct, &radiance.indirect, &radiance.caustic})
      EXPECT_EQ((*layer)[black], RGB());
  }
  EXPECT_EQ(radiance.emitted[0], RGB(1.0f));
  EXPECT_EQ(radiance.direct[4], RGB(5.0f));
}

}  // namespace
}  // namespace glowworm
