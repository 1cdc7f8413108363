// Sampling of bright patches: the same mean with less noise.
#include "gather/bright_patches.h"

#include <gtest/gtest.h>

#include "core/warp.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

constexpr float kSpotRadius = 0.16f;  // metres

/// A floor beside a wall on which a lamp throws a spot of 16 cm radius: all light on the floor comes from there. A pole
/// stands between them.
SceneDescription floor_beside_a_spot() {
  SceneDescription d = floor_description();
  add_quad(d, {2, 2, 0}, {0, -4, 0}, {0, 0, 4});
  add_quad(d, {1.2f, -0.2f, 0}, {0, 0.4f, 0}, {0, 0, 2});
  Light lamp;
  lamp.kind = LightKind::spot;
  lamp.intensity = RGB(100, 80, 60);
  lamp.position = {1.2f, 0.5f, 1};
  lamp.direction = {1, 0, 0};
  lamp.cos_inner = std::cos(std::atan(0.18f));
  lamp.cos_outer = std::cos(std::atan(0.2f));
  d.lights.push_back(lamp);
  d.cameras = {square_view({0, 0, 0}, {0, 0, 1}, 1, 3)};
  return d;
}

/// Places as photons of that scene would have them: on the spot, evenly, and few and dim ones over the floor.
LitPlaces spot_and_floor() {
  LitPlaces places;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    Sampler s(SamplerKind::independent, 1, 2, i);
    const Vec2 u = s.next2();
    const bool on_spot = i < 1000;
    const Vec2 disk = square_to_disk(u) * kSpotRadius;
    places.position.push_back(on_spot ? Vec3{2, 0.5f + disk.x, 1 + disk.y} : Vec3{4 * u.x - 2, 4 * u.y - 2, 0});
    places.normal.push_back(on_spot ? Vec3{-1, 0, 0} : Vec3{0, 0, 1});
    places.flux.push_back(on_spot ? 0.001f : 0.0001f);
    places.irradiance.push_back(on_spot ? 1 / (kPi * kSpotRadius * kSpotRadius) : 0.1f / 16);
  }
  return places;
}

class BrightPatchesTest : public testing::Test {
 protected:
  Scene scene_{floor_beside_a_spot()};
  Tracer tracer_{scene_};
  LitPlaces places_ = spot_and_floor();
  RadiusGrid radii_{places_.position, std::vector<float>(places_.position.size(), 0.03f)};
  BrightPatches patches_{tracer_, places_, radii_};
};

TEST_F(BrightPatchesTest, CoverTheSpotAndNothingElse) {
  ASSERT_FALSE(patches_.empty());
  int on = 0, off = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    Sampler s(SamplerKind::independent, 3, 4, i);
    const Vec2 d = square_to_disk(s.next2()) * 0.4f;
    const Hit hit = tracer_.intersect({{1.9f, 0.5f + d.x, 1 + d.y}, 0, {1, 0, 0}, 1});
    const bool found = patches_.find(hit.triangle, hit.barycentric) != kNone;
    const float r = length(Vec3{d.x, d.y, 0});
    if (r < kSpotRadius) {
      EXPECT_TRUE(found);
      ++on;
    } else if (r > 2 * kSpotRadius) {
      EXPECT_FALSE(found);
      ++off;
    }
  }
  EXPECT_GT(on, 100);
  EXPECT_GT(off, 100);
}

TEST_F(BrightPatchesTest, SamplesLieOnTheirPatch) {
  constexpr std::uint32_t kCount = 20000;
  const Vec3 from{-0.5f, 0.3f, 0};
  double elsewhere = 0, area = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    Sampler s(SamplerKind::independent, 5, 6, i);
    const Vec2 v = s.next2();
    const BrightPatches::Sample sample = patches_.sample(scene_.geometry(), from, s.next1(), v);
    ASSERT_NE(sample.patch, kNone);
    EXPECT_FLOAT_EQ(sample.density, patches_.density(from, sample.patch));
    const Hit hit = tracer_.intersect({sample.position - Vec3{0.1f, 0, 0}, 0, {1, 0, 0}, 1});
    // A place on the border of two cells may round to the other.
    elsewhere += patches_.find(hit.triangle, hit.barycentric) == sample.patch ? 0 : 1;
    area += 1 / sample.density / kCount;
  }
  EXPECT_LT(elsewhere, 0.001 * kCount);
  // The mean of 1 / density is the area of all patches: cells of a triangle, each at least once.
  EXPECT_GT(area, kPi * kSpotRadius * kSpotRadius);
  EXPECT_LT(area, kPi * 4 * kSpotRadius * kSpotRadius);
}

TEST_F(BrightPatchesTest, ThereAreNoneInEvenLight) {
  LitPlaces even = places_;
  for (std::size_t i = 0; i < even.flux.size(); ++i) even.irradiance[i] = even.flux[i] = 1;
  EXPECT_TRUE(BrightPatches(tracer_, even, radii_).empty());
}

TEST(SlowGatherGuiding, KeepsTheMeanAndReducesTheVarianceToAQuarter) {
  const Stage stage(floor_beside_a_spot());
  constexpr int kRenders = 6, kSide = 16;
  double mean[2] = {0, 0}, variance[2] = {0, 0};
  for (const bool guided : {false, true}) {
    std::vector<std::vector<double>> renders;
    for (int r = 0; r < kRenders; ++r) {
      RenderSettings settings = by_photons(kSide, 16, 64, 20'000, "blocked");
      settings.indirect_only = true;
      settings.gather_guiding = guided;
      settings.seed = static_cast<std::uint32_t>(r);
      std::vector<double>& values = renders.emplace_back();
      for (const RGB& p : pixels(stage.render(settings), true)) values.push_back(luminance(p));
    }
    for (std::size_t i = 0; i < renders[0].size(); ++i) {
      double sum = 0, squares = 0;
      for (const auto& render : renders) {
        sum += render[i] / kRenders;
        squares += render[i] * render[i] / kRenders;
      }
      mean[guided] += sum / static_cast<double>(renders[0].size());
      variance[guided] += (squares - sum * sum) * kRenders / (kRenders - 1) / static_cast<double>(renders[0].size());
    }
  }
  // Noise of pixels is independent: 4 standard errors of the difference of two means.
  const double error = std::sqrt((variance[0] + variance[1]) / (kRenders * kSide * kSide));
  EXPECT_NEAR(mean[1], mean[0], 4 * error);
  EXPECT_LT(error, 0.02 * mean[0]);
  EXPECT_LT(variance[1], variance[0] / 4);
}

}  // namespace
}  // namespace glowworm
