// Gathered light of earlier frames, used again.
#include "film/earlier_frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "scene/projection.h"

namespace glowworm {
namespace {

constexpr int kFrameSide = 40;
constexpr float kDeviation = 0.2f;

/// A frame of a wall at z = 0 that is lit by `level(x, y)`, with noise. @param x of the camera, 1 m before it
FrameLight frame_of_wall(float x, std::uint32_t seed, float (*level)(Vec3)) {
  FrameLight out;
  out.view = {look_at({x, 0, -1}, {x, 0, 0}, {0, 1, 0}, 60), kFrameSide, kFrameSide, {0, 0, kFrameSide, kFrameSide}};
  out.guides = {kFrameSide, kFrameSide, {}, {}};
  Sampler random(SamplerKind::independent, seed, 0, 0);
  for (int i = 0; i < kFrameSide * kFrameSide; ++i) {
    const Vec2 film{static_cast<float>(i % kFrameSide) + 0.5f, static_cast<float>(i / kFrameSide) + 0.5f};
    const Vec3 to = unproject(out.view.camera, film, kFrameSide, kFrameSide, 1) - out.view.camera.to_world.translation;
    const float depth = 1 / to.z;
    out.guides.normal.push_back({0, 0, -1});
    out.guides.depth.push_back(depth);
    // Of even random numbers on [-sqrt(3), sqrt(3)], the variance is 1.
    const float noise = kDeviation * std::sqrt(3.0f) * (2 * random.next1() - 1);
    const float value = level(out.view.camera.to_world.translation + to * depth) + noise;
    out.direct.light.emplace_back(value);
    out.direct.level.push_back(value);
    out.direct.variance.push_back(kDeviation * kDeviation);
    out.direct.samples.push_back(4);
  }
  out.indirect = out.direct;
  return out;
}

float even(Vec3) { return 2; }

/// Root mean square of the difference from a level.
double error_of(const LightEstimate& estimate, float level) {
  double sum = 0;
  for (const RGB& light : estimate.light) sum += (light.r - level) * (light.r - level);
  return std::sqrt(sum / static_cast<double>(estimate.light.size()));
}

EarlierFrames frames_before(const FrameLight& own, int count, float (*level)(Vec3)) {
  FrameLights frames;
  for (int i = 1; i <= count; ++i)
    frames.push_back(std::make_shared<const FrameLight>(
        frame_of_wall(-0.02f * static_cast<float>(i), static_cast<std::uint32_t>(i), level)));
  return {own.view, frames};
}

TEST(EarlierFrames, ReduceNoiseLikeFurtherSamples) {
  FrameLight own = frame_of_wall(0, 0, even);
  const double before = error_of(own.direct, 2);
  add_earlier_samples(frames_before(own, 7, even), own.guides, &FrameLight::direct, own.direct);
  EXPECT_LT(error_of(own.direct, 2), 0.5 * before);
  // In the middle, all frames but a few are used.
  const std::size_t middle = kFrameSide * kFrameSide / 2 + kFrameSide / 2;
  EXPECT_GE(own.direct.samples[middle], 24u);
  EXPECT_NEAR(own.direct.variance[middle] * static_cast<float>(own.direct.samples[middle]), 4 * kDeviation * kDeviation,
              1e-5);
}

/// Makes the variances of a layer as uncertain as those of four samples: chi-squared of three degrees of freedom.
void blur_variance(LightEstimate& estimate, std::uint32_t seed) {
  Sampler random(SamplerKind::independent, seed, 0, 0);
  for (float& variance : estimate.variance) {
    const float first = random.next1(), angle = std::cos(2 * kPi * random.next1());
    variance *= (-2 * std::log(1 - first) - 2 * std::log(1 - random.next1()) * angle * angle) / 3;
  }
}

TEST(EarlierFrames, AreUsedWhereFewSamplesTellTheirNoise) {
  FrameLight own = frame_of_wall(0, 0, even);
  blur_variance(own.direct, 1);
  const double before = error_of(own.direct, 2);
  add_earlier_samples(frames_before(own, 7, even), own.guides, &FrameLight::direct, own.direct);
  double samples = 0;
  for (const std::uint32_t n : own.direct.samples) samples += n;
  EXPECT_GT(samples / (kFrameSide * kFrameSide), 24) << "of 32";
  EXPECT_LT(error_of(own.direct, 2), 0.5 * before);
}

TEST(EarlierFrames, AreNotUsedInOtherLight) {
  FrameLight own = frame_of_wall(0, 0, even);
  add_earlier_samples(frames_before(own, 7, [](Vec3) { return 2.4f; }), own.guides, &FrameLight::direct, own.direct);
  double sum = 0;
  for (const RGB& light : own.direct.light) sum += light.r;
  EXPECT_NEAR(sum / (kFrameSide * kFrameSide), 2, 0.03);
}

/// Frames of the same view are further samples of each pixel, whatever these show.
TEST(EarlierFrames, OfTheSameViewAreFurtherSamples) {
  FrameLight own = frame_of_wall(0, 0, even);
  auto before = std::make_shared<FrameLight>(frame_of_wall(0, 1, [](Vec3) { return 4.0f; }));
  before->direct.samples.assign(before->direct.samples.size(), 12);
  before->surfaces.assign(kFrameSide * kFrameSide, {RGB(0.5f), RGB(0.6f), RGB(1.0f), RGB(2.0f), 0.5f});
  const EarlierFrames earlier(own.view, {before});
  const LightEstimate alone = own.direct;
  add_earlier_samples(earlier, own.guides, &FrameLight::direct, own.direct);
  std::uint32_t samples = 4;
  const PixelSurface surface = with_same_view(earlier.of_same_view(), 7, {RGB(0.1f), RGB(0.2f), {}, {}, 0.5f}, samples);
  EXPECT_EQ(samples, 16u);
  EXPECT_FLOAT_EQ(surface.albedo.r, 0.4f);
  EXPECT_FLOAT_EQ(surface.shown.g, 0.5f);
  EXPECT_FLOAT_EQ(surface.caustic.b, 0.75f);
  EXPECT_FLOAT_EQ(surface.emitted.r, 1.5f);
  EXPECT_FLOAT_EQ(surface.variance, 0.5f * (16 + 144) / 256);
  for (std::size_t i = 0; i < alone.level.size(); ++i) {
    ASSERT_EQ(own.direct.samples[i], 16u);
    ASSERT_NEAR(own.direct.level[i], (alone.level[i] + 3 * before->direct.level[i]) / 4, 1e-5);
  }
  auto other = std::make_shared<FrameLight>(*before);
  other->view.bounds.x0 = 1;
  EXPECT_EQ(EarlierFrames(own.view, {other}).of_same_view().size(), 0u);
}

constexpr float kShadow = 0.013f, kLit = 2;

/// A frame of the wall with the edge of a shadow at x = kShadow. Independent samples would vary by `variance` at the
/// edge; as they are stratified, each pixel is right to a small error.
FrameLight frame_of_shadow(float x, std::uint32_t seed) {
  FrameLight out = frame_of_wall(x, seed, [](Vec3) { return 0.0f; });
  const float pixel = 2 * std::tan(kPi / 6) / kFrameSide;
  Sampler random(SamplerKind::independent, seed, 0, 0);
  for (std::size_t i = 0; i < kFrameSide * kFrameSide; ++i) {
    const Vec2 film{static_cast<float>(i % kFrameSide) + 0.5f, static_cast<float>(i / kFrameSide) + 0.5f};
    const float middle = unproject(out.view.camera, film, kFrameSide, kFrameSide, out.guides.depth[i]).x;
    const float lit = std::clamp((middle - kShadow) / pixel + 0.5f, 0.0f, 1.0f);
    const float value = kLit * lit + 0.01f * (2 * random.next1() - 1);
    out.direct.light[i] = RGB(value);
    out.direct.level[i] = value;
    out.direct.variance[i] = kLit * kLit * lit * (1 - lit) / 4 + 0.01f * 0.01f / 3;
  }
  return out;
}

TEST(EarlierFrames, DoNotBlurShadows) {
  FrameLight own = frame_of_shadow(0, 0);
  const LightEstimate before = own.direct;
  FrameLights frames;
  for (int i = 1; i <= 3; ++i)
    frames.push_back(std::make_shared<const FrameLight>(
        frame_of_shadow(-0.0043f * static_cast<float>(i), static_cast<std::uint32_t>(i))));
  add_earlier_samples({own.view, frames}, own.guides, &FrameLight::direct, own.direct);
  for (std::size_t i = 0; i < before.level.size(); ++i)
    EXPECT_NEAR(own.direct.level[i], before.level[i], 0.1) << i % kFrameSide;
}

TEST(EarlierFrames, AreNotUsedOnOtherSurfaces) {
  FrameLight own = frame_of_wall(0, 0, even);
  const LightEstimate before = own.direct;
  EarlierFrames earlier = frames_before(own, 1, even);
  auto nearer = std::make_shared<FrameLight>(*earlier.frames[0]), turned = std::make_shared<FrameLight>(*nearer);
  for (float& depth : nearer->guides.depth) depth *= 0.9f;
  for (Vec3& normal : turned->guides.normal) normal = {0, 1, 0};
  earlier.frames = {nearer, turned};
  add_earlier_samples(earlier, own.guides, &FrameLight::direct, own.direct);
  EXPECT_EQ(own.direct.samples, before.samples);
}

}  // namespace
}  // namespace glowworm
