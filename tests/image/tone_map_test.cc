// Transfer functions and tone curves.
#include "image/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace glowworm {
namespace {

TEST(ToneMap, SrgbKnownPoints) {
  EXPECT_EQ(srgb_encode(0), 0);
  EXPECT_NEAR(srgb_encode(1), 1, 1e-6f);
  EXPECT_NEAR(srgb_encode(0.21404114f), 0.5f, 1e-6f);
  EXPECT_NEAR(srgb_decode(0.5f), 0.21404114f, 1e-6f);
  EXPECT_NEAR(srgb_encode(0.001f), 0.01292f, 1e-8f);
  EXPECT_EQ(srgb_encode(-0.3f), -srgb_encode(0.3f));
}

TEST(ToneMap, EveryCodeSurvivesTheRoundTrip) {
  for (int code = 0; code < 256; ++code) {
    const auto byte = static_cast<std::uint8_t>(code);
    EXPECT_EQ(to_byte(srgb_encode(srgb_decode(byte))), byte);
    EXPECT_EQ(srgb_decode(byte), srgb_decode(static_cast<float>(code) / 255.0f));
  }
}

TEST(ToneMap, CurvesRiseFromBlackToWhite) {
  for (const ToneCurve curve : {ToneCurve::srgb, ToneCurve::filmic}) {
    float last = -1;
    for (float value = 0; value < 100; value = value * 1.05f + 1e-4f) {
      const RGB mapped = tone_map(RGB(value), curve, 0);
      EXPECT_GE(mapped.r, last);
      EXPECT_LE(mapped.r, 1);
      last = mapped.r;
    }
    EXPECT_EQ(tone_map(RGB(0), curve, 0).r, 0);
    EXPECT_NEAR(tone_map(RGB(std::numeric_limits<float>::infinity()), curve, 0).r, 1, 1e-6f);
  }
}

TEST(ToneMap, FilmicIsThePublishedFit) {
  EXPECT_NEAR(filmic_curve(1), 2.54f / 3.16f, 1e-6f);
  EXPECT_NEAR(filmic_curve(0.18f), 0.18f * (2.51f * 0.18f + 0.03f) / (0.18f * (2.43f * 0.18f + 0.59f) + 0.14f), 1e-6f);
}

TEST(ToneMap, ExposureIsInStops) {
  for (const ToneCurve curve : {ToneCurve::srgb, ToneCurve::filmic}) {
    EXPECT_EQ(tone_map(RGB(0.1f), curve, 2), tone_map(RGB(0.4f), curve, 0));
    EXPECT_EQ(tone_map(RGB(0.4f), curve, -2), tone_map(RGB(0.1f), curve, 0));
  }
}

TEST(ToneMap, AutomaticExposureTakesTheMeanOfLogarithmsToGrey) {
  for (const float level : {1e-6f, 0.18f, 3e5f}) {
    // Two halves, four stops apart, around the level; black and broken pixels do not count.
    const std::vector<RGB> pixels = {RGB(level / 4), RGB(level * 4), RGB(0.0f), RGB(std::nanf("")),
                                     RGB(std::numeric_limits<float>::infinity())};
    EXPECT_NEAR(level * std::exp2(automatic_exposure(pixels)), 0.18f, 1e-4f);
  }
  EXPECT_EQ(automatic_exposure({}), 0);
  EXPECT_EQ(automatic_exposure(std::vector<RGB>(4, RGB(0.0f))), 0);
}

TEST(ToneMap, AutomaticExposureIgnoresWhatIsDarkBesideTheBrightPixels) {
  // A weak light on sharp surfaces: a fifth of the picture is lit, the rest has traces of light.
  std::vector<RGB> pixels(1000, RGB(1e-7f));
  for (std::size_t i = 0; i < 200; ++i) pixels[i] = RGB(3e-4f);
  EXPECT_NEAR(3e-4f * std::exp2(automatic_exposure(pixels)), 0.18f, 1e-4f);
  // Lamps are few pixels, and do not darken the room.
  pixels.assign(1000, RGB(0.05f));
  for (std::size_t i = 0; i < 40; ++i) pixels[i] = RGB(1e4f);
  EXPECT_GT(0.05f * std::exp2(automatic_exposure(pixels)), 0.09f);
}

}  // namespace
}  // namespace glowworm
