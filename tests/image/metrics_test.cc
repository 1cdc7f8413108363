// Metrics against values computed by hand, and the statistics of the z-test.
#include "image/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "support/z_test.h"

namespace glowworm {
namespace {

Image picture(int width, int height, const std::vector<RGB>& pixels) {
  Image image(width, height);
  image.add_rgb("", pixels);
  return image;
}

TEST(Metrics, EqualPicturesDoNotDiffer) {
  const Image image = picture(2, 1, {{1, 2, 3}, {0, 0, 0}});
  const ImageComparison result = compare_images(image, image);
  EXPECT_EQ(result.mse, 0);
  EXPECT_EQ(result.relative_mse, 0);
  EXPECT_EQ(result.luminance_ratio, 1);
  for (const double ratio : result.mean_ratio) EXPECT_EQ(ratio, 1);
  EXPECT_EQ(result.pixels, 2u);
}

TEST(Metrics, KnownValues) {
  const Image image = picture(2, 1, {{1.5f, 1, 0}, {3, 1, 0}}), reference = picture(2, 1, {{1, 1, 0}, {2, 1, 0}});
  const ImageComparison result = compare_images(image, reference);
  EXPECT_DOUBLE_EQ(result.mse, (0.25 + 1) / 6);
  EXPECT_NEAR(result.relative_mse, (0.25 / 1.01 + 1 / 4.01) / 6, 1e-15);
  EXPECT_DOUBLE_EQ(result.relative_rmse, std::sqrt(result.relative_mse));
  EXPECT_DOUBLE_EQ(result.mean_ratio[0], 1.5);
  EXPECT_DOUBLE_EQ(result.mean_ratio[1], 1);
  EXPECT_DOUBLE_EQ(result.mean_ratio[2], 1);
  EXPECT_NEAR(result.luminance_ratio, (0.2126 * 4.5 + 0.7152 * 2) / (0.2126 * 3 + 0.7152 * 2), 1e-6);
  EXPECT_EQ(result.largest_difference, 1);
}

TEST(Metrics, WorstPixelsAreLeftOut) {
  std::vector<RGB> pixels(100, RGB(1)), truth(100, RGB(1));
  for (std::size_t i = 0; i < 98; ++i) pixels[i] = RGB(1.125f);
  pixels[98] = RGB(1000);
  pixels[99] = RGB(2000);
  const Image image = picture(10, 10, pixels), reference = picture(10, 10, truth);
  EXPECT_NEAR(compare_images(image, reference, 0.02).mse, 0.125 * 0.125, 1e-12);
  EXPECT_NEAR(compare_images(image, reference, 0.01).mse, (98 * 0.125 * 0.125 + 999.0 * 999) / 99, 1e-6);
  EXPECT_GT(compare_images(image, reference).mse, 40000);
  EXPECT_THROW(compare_images(image, reference, 1), Error);
  EXPECT_THROW(compare_images(image, reference, -0.1), Error);
}

TEST(Metrics, PicturesWithoutAFinitePixelAreNotEqual) {
  const Image nothing = picture(2, 1, {RGB(std::nanf("")), RGB(INFINITY)}), reference = picture(2, 1, {RGB(1), RGB(2)});
  EXPECT_THROW(compare_images(nothing, reference), Error);
  EXPECT_THROW(compare_images(reference, nothing), Error);
}

TEST(Metrics, NonFinitePixelsAreCountedApart) {
  const Image image = picture(2, 1, {RGB(std::nanf("")), RGB(2)}), reference = picture(2, 1, {RGB(1), RGB(2)});
  const ImageComparison result = compare_images(image, reference);
  EXPECT_EQ(result.non_finite_pixels, 1u);
  EXPECT_EQ(result.pixels, 1u);
  EXPECT_EQ(result.mse, 0);
}

TEST(Metrics, EqualInfinitiesAgree) {
  const RGB infinite(std::numeric_limits<float>::infinity());
  const Image image = picture(3, 1, {infinite, RGB(2), infinite}),
              reference = picture(3, 1, {infinite, RGB(2), RGB(1)});
  const ImageComparison result = compare_images(image, reference);
  EXPECT_EQ(result.non_finite_pixels, 1u);
  EXPECT_EQ(result.pixels, 2u);
  EXPECT_EQ(result.mse, 0);
}

TEST(Metrics, SizesMustAgree) {
  const Image a = picture(2, 1, {RGB(1), RGB(1)}), b = picture(1, 2, {RGB(1), RGB(1)});
  EXPECT_THROW(compare_images(a, b), Error);
  EXPECT_THROW(difference_picture(a, b), Error);
}

TEST(Metrics, RatioToBlackIsInfinite) {
  const Image light = picture(1, 1, {RGB(1)}), dark = picture(1, 1, {RGB(0)});
  EXPECT_EQ(compare_images(light, dark).luminance_ratio, std::numeric_limits<double>::infinity());
  EXPECT_EQ(compare_images(dark, light).luminance_ratio, 0);
}

TEST(Metrics, DifferencePictureIsRedWhereTooBright) {
  const Image image = picture(4, 1, {RGB(10), RGB(0), RGB(1), RGB(std::nanf(""))});
  const std::vector<RGB> colors = difference_picture(image, picture(4, 1, std::vector<RGB>(4, RGB(1)))).rgb();
  EXPECT_EQ(colors[0], RGB(1, 0, 0));
  EXPECT_EQ(colors[1], RGB(0, 0, 1));
  EXPECT_EQ(colors[2].r, colors[2].b);
  EXPECT_EQ(colors[3], RGB(0, 1, 0));
}

// Means of n uniform numbers, n large enough to be normal; variance of the mean 1 / (12 n).
struct Estimates {
  std::vector<float> mean, variance;
  EstimateSpan span() const { return {mean, variance}; }
};
Estimates estimates(std::uint32_t seed, std::size_t entries, float offset) {
  constexpr std::uint32_t kSamples = 64;
  Estimates result;
  for (std::uint32_t e = 0; e < entries; ++e) {
    double sum = 0;
    for (std::uint32_t s = 0; s < kSamples; ++s) sum += Sampler(SamplerKind::independent, seed, e, s).next1();
    result.mean.push_back(static_cast<float>(sum / kSamples) + offset);
    result.variance.push_back(1.0f / (12 * kSamples));
  }
  return result;
}

TEST(ZTestOfPictures, SameMeanPassesAndAnotherFails) {
  const Estimates a = estimates(1, 10000, 0), b = estimates(2, 10000, 0), c = estimates(3, 10000, 0.3f);
  EXPECT_TRUE(z_test(a.span(), b.span(), 0.01).passed());
  EXPECT_FALSE(z_test(a.span(), c.span(), 0.01).passed());
  Estimates one_wrong = b;
  one_wrong.mean[77] += 1;
  EXPECT_EQ(z_test(a.span(), one_wrong.span(), 0.01).rejected, 1u);
}

TEST(ZTestOfPictures, FalseAlarmsAreAsRareAsStated) {
  // 400 tests of 100 entries at 0.2: 80 alarms expected, standard deviation 8; held to 4 of them.
  int alarms = 0;
  for (std::uint32_t t = 0; t < 400; ++t) {
    if (!z_test(estimates(2 * t + 10, 100, 0).span(), estimates(2 * t + 11, 100, 0).span(), 0.2).passed()) ++alarms;
  }
  EXPECT_NEAR(alarms, 80, 32);
}

TEST(ZTestOfPictures, EdgeCases) {
  const std::vector<float> zero{0}, one{1}, nan{std::nanf("")}, none{}, two{1, 1};
  EXPECT_TRUE(z_test({one, zero}, {one, zero}).passed());
  EXPECT_FALSE(z_test({one, zero}, {zero, zero}).passed());
  EXPECT_FALSE(z_test({nan, one}, {one, one}).passed());
  EXPECT_TRUE(z_test({none, none}, {none, none}).passed());
  EXPECT_THROW(z_test({one, zero}, {two, two}), Error);
}

}  // namespace
}  // namespace glowworm
