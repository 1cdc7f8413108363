// Thin slats close together, as of blinds: photons of one slat lie within the radii of the next.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <utility>

#include "render/render_testing.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

/// A room of 4 x 3 x 4 metres whose only light comes through a window with slats 4 cm apart, most of it by bounces
/// between them.
SceneDescription room_behind_blinds() {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[0].reflectance.value = RGB(0.6f);
  d.materials[1].reflectance.value = RGB(0.0f);
  add_quad(d, {-0.3f, 0.9f, 1.3f}, {0, 1.2f, 0}, {0, 0, 1.4f}, 1, add_emission(d, RGB(10.0f)));  // behind the window
  add_quad(d, {0, 0, 0}, {0, 0, 4}, {4, 0, 0});                                                  // floor
  add_quad(d, {0, 3, 0}, {4, 0, 0}, {0, 0, 4});                                                  // ceiling
  add_quad(d, {0, 0, 0}, {4, 0, 0}, {0, 3, 0});
  add_quad(d, {0, 0, 4}, {0, 3, 0}, {4, 0, 0});
  add_quad(d, {4, 0, 0}, {0, 0, 4}, {0, 3, 0});
  add_quad(d, {0, 0, 0}, {0, 3, 0}, {0, 0, 1.5f});  // the wall around the window, 1 x 1 m
  add_quad(d, {0, 0, 2.5f}, {0, 3, 0}, {0, 0, 1.5f});
  add_quad(d, {0, 0, 1.5f}, {0, 1, 0}, {0, 0, 1});
  add_quad(d, {0, 2, 1.5f}, {0, 1, 0}, {0, 0, 1});
  constexpr int kSlats = 25;
  constexpr float kApart = 1.0f / kSlats, kWide = 0.8f * kApart;
  for (int i = 0; i < kSlats; ++i)
    add_quad(d, {-0.02f - kWide, 1 + kApart * (static_cast<float>(i) + 0.9f), 1.4f}, {kWide, -kWide, 0}, {0, 0, 1.2f});
  d.cameras.push_back(look_at({2, 1.5f, 3.9f}, {2, 1.3f, 0}, {0, 1, 0}, 60));
  return d;
}

RunningMean means_of_seeds(const Stage& stage, RenderSettings settings, std::uint32_t seeds) {
  RunningMean out;
  for (settings.seed = 0; settings.seed < seeds; ++settings.seed) out.add(mean(stage.render(settings)).luminance());
  return out;
}

void expect_mean_of_paths(const RunningMean& photons, const RunningMean& paths, double bias) {
  const double error = std::hypot(paths.standard_error(), photons.standard_error()) / paths.mean();
  fmt::print("photons / paths {:.4f} +- {:.4f}\n", photons.mean() / paths.mean(), error);
  ASSERT_LT(error, 0.005);
  EXPECT_NEAR(photons.mean() / paths.mean(), 1, bias + 4 * error);
}

TEST(SlowSlats, LetThroughAsMuchLightByPhotonsAsByPaths) {
  const Stage stage(room_behind_blinds());
  const RunningMean paths = means_of_seeds(stage, by_path(16, 512), 8);
  // Kernels may change the mean by 1%; beside that 4 standard errors, a false alarm in 16,000 choices of seeds. Light
  // that is wrong by 5% is found with the same confidence.
  expect_mean_of_paths(means_of_seeds(stage, by_photons(16, 16, 25, 1'000'000, "blocked"), 4), paths, 0.01);
  RenderSettings small;  // by default
  small.width = small.height = 32;
  small.filter = Filtering::off;
  expect_mean_of_paths(means_of_seeds(stage, small, 8), paths, 0.01);
}

enum class Slats { sheets, boxes };

/// A room of 6 x 3 x 4 metres whose window, one wall, has slats of 7 cm, 5 cm apart, in the sun. @param flipped every
/// triangle has the other winding, so that boxes are inside out
SceneDescription room_in_the_sun(Slats slats, bool flipped) {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[0].reflectance.value = RGB(0.5f);
  d.materials[1].reflectance.value = RGB(0.7f);
  add_quad(d, {0, 0, 0}, {0, 0, 4}, {6, 0, 0});
  add_quad(d, {0, 3, 0}, {6, 0, 0}, {0, 0, 4}, 1);
  add_quad(d, {0, 0, 0}, {6, 0, 0}, {0, 3, 0});
  add_quad(d, {0, 0, 4}, {0, 3, 0}, {6, 0, 0});
  add_quad(d, {6, 0, 0}, {0, 0, 4}, {0, 3, 0});
  add_quad(d, {0, 0, 0}, {0, 1, 0}, {0, 0, 4});
  const Vec3 across{-0.06f, -0.04f, 0}, along{0, 0, 4}, down{0.001f, -0.0015f, 0};
  for (int i = 0; i < 40; ++i) {
    const Vec3 corner{0, 1.03f + 0.05f * static_cast<float>(i), 0};
    add_quad(d, corner, across, along, 1);
    if (slats == Slats::sheets) continue;
    add_quad(d, corner + down, along, across, 1);
    add_quad(d, corner, down, across, 1);
    add_quad(d, corner + along, across, down, 1);
    add_quad(d, corner, along, down, 1);
    add_quad(d, corner + across, down, along, 1);
  }
  if (flipped)
    for (auto& [a, b, c] : d.geometry.triangles) std::swap(b, c);
  Light& sun = d.lights.emplace_back();
  sun.kind = LightKind::directional;
  sun.direction = normalize(Vec3{1, -1, -0.2f});
  sun.intensity = RGB(10.0f);
  d.cameras.push_back(look_at({5, 1.5f, 2}, {0, 1.6f, 2}, {0, 1, 0}, 70));
  return d;
}

/// Slats hide nothing from each other, whichever side is their front.
TEST(SlowSlats, AreAsBrightOfEitherWinding) {
  for (const Integrator integrator : {Integrator::gather, Integrator::photons})
    for (const Slats slats : {Slats::sheets, Slats::boxes}) {
      RenderSettings settings;
      settings.integrator = integrator;
      settings.width = settings.height = 32;
      settings.filter = Filtering::off;
      settings.samples = 16;
      const RunningMean front = means_of_seeds(Stage(room_in_the_sun(slats, false)), settings, 6),
                        back = means_of_seeds(Stage(room_in_the_sun(slats, true)), settings, 6);
      const double error = std::hypot(front.standard_error(), back.standard_error()) / front.mean();
      fmt::print("back / front {:.4f} +- {:.4f}\n", back.mean() / front.mean(), error);
      ASSERT_LT(error, 0.01);
      EXPECT_NEAR(back.mean() / front.mean(), 1, 0.01 + 4 * error) << static_cast<int>(slats);
    }
}

}  // namespace
}  // namespace glowworm
