// 16-bit floats: every one of them, and the rounding to them.
#include "image/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace glowworm {
namespace {

TEST(Half, EveryNumberComesBackAsItWas) {
  for (std::uint32_t bits = 0; bits < 0x10000u; ++bits) {
    const float value = half_to_float(static_cast<std::uint16_t>(bits));
    if (std::isnan(value)) {
      EXPECT_TRUE(std::isnan(half_to_float(float_to_half(value)))) << bits;
    } else {
      EXPECT_EQ(float_to_half(value), bits);
    }
  }
}

TEST(Half, RoundsToTheNearestAndTiesToEven) {
  for (std::uint32_t bits = 0; bits < 0x7bffu; ++bits) {
    const float below = half_to_float(static_cast<std::uint16_t>(bits)),
                above = half_to_float(static_cast<std::uint16_t>(bits + 1)), middle = (below + above) / 2;
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float sign : {1.0f, -1.0f}) {
      const std::uint32_t mark = sign < 0 ? 0x8000u : 0;
      ASSERT_EQ(float_to_half(sign * middle), mark | (bits & 1 ? bits + 1 : bits)) << below;
      ASSERT_EQ(float_to_half(sign * std::nextafter(middle, 0.0f)), mark | bits) << below;
      ASSERT_EQ(float_to_half(sign * std::nextafter(middle, infinity)), mark | (bits + 1)) << below;
    }
  }
  EXPECT_EQ(float_to_half(65519), 0x7bff);
  EXPECT_EQ(float_to_half(65520), 0x7c00);
  EXPECT_EQ(float_to_half(1e30f), 0x7c00);
}

}  // namespace
}  // namespace glowworm
