#include "core/shutter.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace glowworm {
namespace {

TEST(Shutter, ReadsTimes) {
  EXPECT_EQ(parse_shutter("0.02"), (Shutter{0, 0.02}));
  EXPECT_EQ(parse_shutter("1/48"), (Shutter{0, 1.0 / 48}));
  EXPECT_EQ(parse_shutter("-1/96:1/96"), (Shutter{-1.0 / 96, 1.0 / 96}));
  EXPECT_EQ(parse_shutter("0"), Shutter());
  for (const char* text : {"", "x", "-1", "1/0", "1/-2", "1/2/3", "2:1", "1:1", ":", "1:", "1:2:3", "nan", "inf"})
    EXPECT_THROW(parse_shutter(text), Error) << text;
}

TEST(Shutter, EachSliceHasAMomentWithinIt) {
  const Shutter shutter{-1, 3};
  for (const std::uint32_t seed : {0u, 1u, 77u})
    for (std::uint32_t slice = 0; slice < 8; ++slice) {
      const double moment = shutter.moment(slice, 8, seed);
      EXPECT_GE(moment, -1 + 0.5 * slice);
      EXPECT_LE(moment, -1 + 0.5 * (slice + 1));
      EXPECT_NE(moment, shutter.moment(slice, 8, seed + 1));
    }
}

}  // namespace
}  // namespace glowworm
