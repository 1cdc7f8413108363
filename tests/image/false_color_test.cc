// False colours, their legends and isolines.
#include "image/false_color.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::FloatEq;

TEST(FalseColor, TellsValuesApart) {
  std::vector<float> values;
  for (int i = 1; i <= 1000; ++i) values.push_back(static_cast<float>(i));
  const ColorScale scale = fitting_scale(values);
  EXPECT_NEAR(scale.low, 20, 2);
  EXPECT_NEAR(scale.high, 980, 3);
  const std::vector<RGB> colors = false_colors(values, scale);
  EXPECT_EQ(colors.back(), RGB(1, 1, 1));
  EXPECT_EQ(false_colors(std::vector<float>{0}, scale)[0], RGB(0, 0, 0));
  EXPECT_GT(fitting_scale({}).high, fitting_scale({}).low);
}

TEST(FalseColor, TicksAreRoundAndEnough) {
  EXPECT_THAT(scale_ticks({0.5f, 2e5f}), ElementsAre(1, 10, 100, 1000, 10'000, 100'000));
  EXPECT_THAT(scale_ticks({0.9f, 60}), ElementsAre(1, 2, 5, 10, 20, 50));
  EXPECT_THAT(scale_ticks({1000, 2000}), ElementsAre(1000, 1200, 1400, 1600, 1800, 2000));
  EXPECT_THAT(scale_ticks({0.308f, 0.347f}),
              ElementsAre(FloatEq(0.31f), FloatEq(0.315f), FloatEq(0.32f), FloatEq(0.325f), FloatEq(0.33f),
                          FloatEq(0.335f), FloatEq(0.34f), FloatEq(0.345f)));
}

TEST(FalseColor, PlotsHaveIsolinesAndALegend) {
  constexpr int kSide = 200;
  std::vector<float> values(kSide * kSide);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % kSide < 120 ? 10.0f : 50.0f;
  values[0] = std::numeric_limits<float>::quiet_NaN();
  const ColorScale scale{1, 100};
  const Image plot = false_color_plot(values, kSide, kSide, scale, "lx");
  ASSERT_GT(plot.width(), kSide);
  ASSERT_EQ(plot.height(), kSide);
  const std::vector<RGB> pixels = plot.rgb();
  const auto at = [&](int x, int y) { return pixels[static_cast<std::size_t>(y * plot.width() + x)]; };
  const std::vector<RGB> colors = false_colors(values, scale);
  EXPECT_EQ(at(50, 100), colors[50]);
  EXPECT_EQ(at(150, 100), colors[150]);
  EXPECT_EQ(at(0, 0).r, at(0, 0).b) << "grey: nothing there";
  // 20 is the only tick that the step crosses: 10 and 50 are values of their own.
  int dark = 0;
  for (int x = 100; x < 140; ++x) dark += at(x, 100).g < 0.05f;
  EXPECT_GE(dark, 1);
  EXPECT_LE(dark, 3);
  // The legend runs through all colours, white on top.
  bool white = false, blue = false;
  for (int y = 20; y < kSide; ++y) {
    const RGB c = at(kSide + 15, y);
    white = white || (c.r > 0.9f && c.b > 0.9f);
    blue = blue || (c.b > 0.5f && c.r < 0.05f && c.g < 0.2f);
  }
  EXPECT_TRUE(white);
  EXPECT_TRUE(blue);
}

}  // namespace
}  // namespace glowworm
