// Closed scenes: if every surface emits 1 and reflects half, radiance is 2 everywhere.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// Emission over one minus albedo.
constexpr double kFurnace = 2;
constexpr double kFurnaceTolerance = 0.005;

void expect_furnace(const Film& film) {
  const Mean found = mean(film);
  for (const double v : found.value) EXPECT_NEAR(v / kFurnace, 1, kFurnaceTolerance);
}

class Furnace : public testing::TestWithParam<const char*> {};

TEST_P(Furnace, ByPathTracing) {
  const Stage stage(builtin_scene(GetParam()));
  expect_furnace(stage.render(by_path(16, 256)));
}

/// At the settings that a render has by itself.
TEST_P(Furnace, ByPhotonMapping) {
  const Stage stage(builtin_scene(GetParam()));
  for (const char* engine : {"knn", "blocked"}) {
    SCOPED_TRACE(engine);
    expect_furnace(stage.render(by_photons(16, 4, 25, 500'000, engine)));
  }
}

/// Secondary gathers sample lights that touch the corners that they start in: no sample may be far off.
TEST(SlowFurnaceCorners, HaveNoBrightSpecks) {
  const Stage stage(builtin_scene("furnace-box"));
  for (const RGB& pixel : pixels(stage.render(by_photons(48, 16, 16, 100'000)))) EXPECT_NEAR(pixel.r, kFurnace, 0.2);
}

class SlowFurnace : public Furnace {};

/// The gathered light by itself, where nothing exact makes an error look smaller: the mean over four photon maps, whose
/// standard error is 0.13%.
TEST_P(SlowFurnace, IndirectLightAlone) {
  const Stage stage(builtin_scene(GetParam()));
  for (const char* engine : {"knn", "blocked"}) {
    RenderSettings settings = by_photons(16, 4, 25, 500'000, engine);
    settings.indirect_only = true;
    Mean sum{};
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
      settings.seed = seed;
      const Mean found = mean(stage.render(settings), true);
      for (int c = 0; c < 3; ++c) sum.value[c] += found.value[c] / 4;
    }
    for (const double v : sum.value) EXPECT_NEAR(v, 0.5, 0.5 * kFurnaceTolerance) << engine;
  }
}

/// A furnace of 2 m with a grid of glossy rods above its floor, thinner than the photons' radii, which the camera sees
/// from below the grid.
SceneDescription furnace_with_rods() {
  SceneDescription d;
  constexpr std::uint32_t kWall = 0, kMetal = 1;
  d.materials.resize(2);
  d.materials[kMetal].reflectance.value = RGB(1.0f);
  const std::uint32_t lamp = add_emission(d, RGB(0.5f));
  d.materials[kMetal].kind = MaterialKind::conductor;
  d.materials[kMetal].use_reflectance = true;
  d.materials[kMetal].roughness_u.value = d.materials[kMetal].roughness_v.value = 0.1f;
  add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, kWall, lamp);
  add_quad(d, {-1, -1, 2}, {0, 2, 0}, {2, 0, 0}, kWall, lamp);
  add_quad(d, {-1, -1, 0}, {0, 2, 0}, {0, 0, 2}, kWall, lamp);
  add_quad(d, {1, -1, 0}, {0, 0, 2}, {0, 2, 0}, kWall, lamp);
  add_quad(d, {-1, -1, 0}, {0, 0, 2}, {2, 0, 0}, kWall, lamp);
  add_quad(d, {-1, 1, 0}, {2, 0, 0}, {0, 0, 2}, kWall, lamp);
  constexpr int kRods = 20, kSides = 8;
  constexpr float kApart = 2.0f / kRods, kRadius = 0.01f;
  for (int i = 0; i < kRods; ++i)
    for (int side = 0; side < kSides; ++side) {
      const auto corner = [&](int at) {
        const float turn = 2 * kPi * static_cast<float>(at) / kSides;
        return Vec3{-0.99f, (static_cast<float>(i) + 0.5f) * kApart - 1 + kRadius * std::cos(turn),
                    0.2f + kRadius * std::sin(turn)};
      };
      add_quad(d, corner(side), corner(side + 1) - corner(side), {1.98f, 0, 0}, kMetal);
    }
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.15f, 1));
  return d;
}

/// Photons near the end of a gather ray would bring too little light of rods: the directions of many lie behind the
/// surface there.
TEST(FurnaceOfRods, KeepsTheirReflections) {
  const Stage stage(furnace_with_rods());
  for (const char* engine : {"knn", "blocked"}) {
    SCOPED_TRACE(engine);
    const Mean found = mean(stage.render(by_photons(16, 16, 16, 200'000, engine)));
    for (const double v : found.value) EXPECT_NEAR(v, 1, kFurnaceTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowFurnace, testing::Values("furnace-box", "furnace-sphere"),
                         [](const auto& info) { return std::string(info.param) == "furnace-box" ? "box" : "sphere"; });
INSTANTIATE_TEST_SUITE_P(Closed, Furnace, testing::Values("furnace-box", "furnace-sphere"),
                         [](const auto& info) { return std::string(info.param) == "furnace-box" ? "box" : "sphere"; });

}  // namespace
}  // namespace glowworm
