// Indices of glare against closed forms.
#include "measure/glare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "measure/glare_picture.h"
#include "measure/measurement.h"

namespace glowworm {
namespace {

constexpr int kSide = 512;
constexpr double kBackground = 200, kSource = 20'000, kRadius = 0.17;

/// A uniform background with discs of an angular radius of kRadius in these directions.
GlarePicture picture_of(CameraKind kind, const std::vector<Vec3>& discs) {
  GlarePicture p;
  p.kind = kind;
  p.width = p.height = kSide;
  if (kind == CameraKind::hemispherical) p.half_x = p.half_y = 1;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const Vec2 plane{(2 * (static_cast<float>(x) + 0.5f) / kSide - 1) * p.half_x,
                       (1 - 2 * (static_cast<float>(y) + 0.5f) / kSide) * p.half_y};
      const Vec3 d = angular_direction(kind, plane);
      double luminance = kBackground;
      for (const Vec3 disc : discs)
        if (dot(d, disc) > std::cos(kRadius)) luminance = kSource;
      p.luminance.push_back(static_cast<float>(luminance));
    }
  return p;
}

Vec3 at(double sideways, double up) {
  return normalize(Vec3{static_cast<float>(std::tan(sideways)), static_cast<float>(std::tan(up)), 1});
}

TEST(Glare, PositionIndexIsGuthsAboveAndIwatasBelow) {
  EXPECT_NEAR(position_index({0, 0, 1}), 1, 1e-9);
  // 20 degrees straight up: exp((35.2 - 1.22) 0.02 + 21e-5 * 400).
  EXPECT_NEAR(position_index(at(0, M_PI / 9)), std::exp(0.6796 + 0.084), 1e-4);
  // 20 degrees to the side: tau is 90.
  EXPECT_NEAR(position_index(at(M_PI / 9, 1e-7)),
              std::exp((35.2 - 28.7001 - 1.22 * std::exp(-20.0)) * 0.02 + (21 + 24.0003 - 24.0003) * 1e-5 * 400), 1e-3);
  EXPECT_NEAR(position_index(at(0, -std::atan(0.5))), 1.4, 1e-5);
  EXPECT_NEAR(position_index(at(0, -std::atan(2.0))), 3.4, 1e-5);
  EXPECT_EQ(position_index({0, 0, -1}), 16);
}

TEST(Glare, OneAndSeveralSourcesAgreeWithTheFormulas) {
  const double solid_angle = 2 * M_PI * (1 - std::cos(kRadius));
  const std::vector<std::vector<Vec3>> cases = {{at(0, 0.3)}, {at(0, 0)}, {at(0.4, 0.3), at(-0.4, 0.3), at(0, -0.5)}};
  for (const CameraKind kind : {CameraKind::fisheye, CameraKind::hemispherical})
    for (const std::vector<Vec3>& discs : cases) {
      double of_sources = 0, squares = 0, dgi = 0;
      // The illuminance of a disc: pi sin^2 of its radius, times the cosine of its middle.
      const double disc = M_PI * std::pow(std::sin(kRadius), 2);
      double e = kBackground * M_PI;
      for (const Vec3 d : discs) {
        of_sources += kSource * disc * d.z;
        e += (kSource - kBackground) * disc * d.z;
      }
      const double background = (e - of_sources) / M_PI;
      for (const Vec3 d : discs) {
        const double weight = solid_angle / std::pow(position_index(d), 2);
        squares += kSource * kSource * weight;
        dgi += 0.478 * std::pow(kSource, 1.6) * std::pow(weight, 0.8) /
               (background + 0.07 * std::sqrt(solid_angle) * kSource);
      }
      const Glare glare = rate_glare(picture_of(kind, discs));
      ASSERT_EQ(glare.sources.size(), discs.size());
      EXPECT_NEAR(glare.vertical_illuminance / e, 1, 0.01);
      EXPECT_NEAR(glare.background / background, 1, 0.01);
      EXPECT_NEAR(glare.sources[0].solid_angle / solid_angle, 1, 0.01);
      EXPECT_NEAR(glare.sources[0].luminance / kSource, 1, 1e-5);
      const double dgp = 5.87e-5 * e + 9.18e-2 * std::log10(1 + squares / std::pow(e, 1.87)) + 0.16;
      EXPECT_NEAR(glare.dgp / dgp, 1, 0.01);
      EXPECT_NEAR(glare.dgi / (10 * std::log10(dgi)), 1, 0.01);
      EXPECT_NEAR(glare.ugr / (8 * std::log10(0.25 / background * squares)), 1, 0.01);
    }
}

TEST(Glare, DimViewsHaveNoSourcesAndPeaksAreTheirOwn) {
  const Glare dim = rate_glare(picture_of(CameraKind::fisheye, {}));
  EXPECT_TRUE(dim.sources.empty());
  EXPECT_EQ(dim.ugr, 0);
  EXPECT_NEAR(dim.dgp, 5.87e-5 * kBackground * M_PI + 0.16, 1e-3);
  GlarePicture sky = picture_of(CameraKind::fisheye, {at(0, 0.3)});
  for (int y = 200; y < 205; ++y) sky.luminance[static_cast<std::size_t>(y) * kSide + 256] = 1e6f;
  EXPECT_EQ(rate_glare(sky).sources.size(), 2u);
  const GlareSource sun{at(0, 0.9), 6.8e-5, 1e9, position_index(at(0, 0.9)), 68'000 * std::cos(0.9)};
  const std::vector<GlareSource> lights = {sun};
  const Glare with_sun = rate_glare(picture_of(CameraKind::fisheye, {}), lights);
  EXPECT_NEAR(with_sun.vertical_illuminance, kBackground * M_PI + 68'000 * std::cos(0.9), 10);
  EXPECT_NEAR(with_sun.background, kBackground, 2);
}

TEST(Glare, OfPixelsWithDetailsThePartAboveTheThresholdIsTheSource) {
  GlarePicture picture = picture_of(CameraKind::fisheye, {});
  constexpr std::uint32_t kMiddle = kSide / 2 * kSide + kSide / 2;
  PixelDetail detail{kMiddle, {}};
  detail.luminance.fill(kBackground);
  for (std::size_t i = 0; i < 4; ++i) detail.luminance[i] = 6000;
  picture.luminance[kMiddle] = (4 * 6000 + 12 * kBackground) / 16;  // less than kGlareThreshold
  picture.details = {detail};
  const Glare glare = rate_glare(picture);
  ASSERT_EQ(glare.sources.size(), 1u);
  const double pixel = std::pow(M_PI / kSide, 2);
  EXPECT_NEAR(glare.sources[0].luminance, 6000, 0.1);
  EXPECT_NEAR(glare.sources[0].solid_angle, pixel / 4, 1e-3 * pixel);
  EXPECT_NEAR(glare.background, rate_glare(picture_of(CameraKind::fisheye, {})).background, 0.01);
}

TEST(Glare, SourcesBeginAtFiveTimesTheTask) {
  // A task of mean luminance (20,000 + 200) / 2, half of it a disc at the middle.
  const GlarePicture picture = picture_of(CameraKind::fisheye, {{0, 0, 1}});
  const double disc = 1 - std::cos(kRadius), both = std::acos(1 - 2 * disc);
  const GlareTask task{kSide / 2.0, kSide / 2.0, 2 * both};
  EXPECT_NEAR(task_luminance(picture, task), (kSource + kBackground) / 2, 0.01 * kSource);
  EXPECT_NEAR(task_luminance(picture, {kSide / 2.0, 0.8 * kSide, 0.3}), kBackground, 1e-3);
  EXPECT_TRUE(rate_glare(picture, {}, kTaskFactor * task_luminance(picture, task)).sources.empty());
  EXPECT_THROW(task_luminance(picture, {-500, -500, 0.2}), Error);
}

/// The factor of evalglare below 1000 lx.
TEST(Glare, ProbabilityIsLessInDimLight) {
  for (const double e : {100.0, 166.67, 300.0, 999.0})
    EXPECT_NEAR(daylight_glare_probability(e, {}),
                (5.87e-5 * e + 0.16) * std::exp(0.024 * e - 4) / (1 + std::exp(0.024 * e - 4)), 1e-9);
  EXPECT_NEAR(daylight_glare_probability(1000, {}), 0.2187, 1e-9);
}

TEST(Glare, SunsOfLessThanAPixelHaveRings) {
  GlarePicture picture = picture_of(CameraKind::fisheye, {});
  GlareSource sun;
  sun.direction = at(0.3, 0.4);
  sun.solid_angle = 6.8e-5;
  sun.luminance = 1e9;
  sun.illuminance = 6.8e4;
  const Glare glare = rate_glare(picture, std::vector<GlareSource>{sun});
  ASSERT_EQ(glare.sources.size(), 1u);
  const Image plain = glare_image(picture, glare, false), ringed = glare_image(picture, glare, true);
  const Vec2 plane = angular_plane(picture.kind, sun.direction);
  const auto pixel = [&](float across) {
    const auto x = static_cast<std::size_t>((plane.x / picture.half_x + 1) * kSide / 2 + across);
    const auto y = static_cast<std::size_t>((1 - plane.y / picture.half_y) * kSide / 2);
    return y * kSide + x;
  };
  EXPECT_FLOAT_EQ(kLuminousEfficacy * luminance(plain.rgb()[pixel(5)]), kBackground);
  EXPECT_GT(kLuminousEfficacy * luminance(ringed.rgb()[pixel(5)]), 1e8f);
  EXPECT_FLOAT_EQ(kLuminousEfficacy * luminance(ringed.rgb()[pixel(0)]), kBackground);
}

TEST(Glare, RefusesPicturesThatAreNoFisheyes) {
  Image image(4, 4);
  image.add_rgb("", std::vector<RGB>(16));
  EXPECT_THROW(view_of_picture(image, "a.hdr", ""), Error);
  EXPECT_THROW(glare_picture_of(image, parse_radiance_view("-vtv -vh 90 -vv 90")), Error);
  EXPECT_EQ(glare_picture_of(image, parse_radiance_view("-vth -vh 180 -vv 180")).half_x, 1);
}

}  // namespace
}  // namespace glowworm
