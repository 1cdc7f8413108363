// Daylight matrices: patches in Radiance's order, and rows that add up to the light of the whole sky.
#include "measure/sky_patches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "control/job.h"
#include "core/error.h"
#include "measure/measurement.h"
#include "scene/environment.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

TEST(SkyPatches, AreInTheOrderOfRadiance) {
  const SkyPatches tregenza(145), reinhart(577);
  EXPECT_EQ(tregenza.size(), 146u);
  EXPECT_EQ(reinhart.size(), 578u);
  EXPECT_EQ(tregenza.patch_of({0, -1, 0}), 0u);
  EXPECT_EQ(tregenza.patch_of(sky_direction(6, 0)), 1u) << "north at the horizon";
  EXPECT_EQ(tregenza.patch_of(sky_direction(6, 5.9f)), 1u);
  EXPECT_EQ(tregenza.patch_of(sky_direction(6, 354.1f)), 1u);
  EXPECT_EQ(tregenza.patch_of(sky_direction(6, 12)), 2u) << "then towards east";
  EXPECT_EQ(tregenza.patch_of(sky_direction(11.9f, 348)), 30u);
  EXPECT_EQ(tregenza.patch_of(sky_direction(12.1f, 0)), 31u);
  EXPECT_EQ(tregenza.patch_of(sky_direction(78, 300)), 144u);
  EXPECT_EQ(tregenza.patch_of({0, 1, 0}), 145u);
  EXPECT_EQ(reinhart.patch_of(sky_direction(6.3f, 0)), 61u);
  EXPECT_EQ(reinhart.patch_of({0, 1, 0}), 577u);
  EXPECT_THROW(SkyPatches(146), Error);
}

TEST(DaylightMatrix, RowsAddUpToTheLightOfTheWholeSky) {
  // A wall of reflectance 0.5 beside the sensors, on the floor.
  SceneDescription d;
  d.materials.resize(1);
  add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  add_quad(d, {-2, 0, -2}, {4, 0, 0}, {0, 2, 0});
  d.environment = Environment{};  // radiance 1 all around
  const Scene scene(d);
  Sensors sensors;
  sensors.add({0, 0.5f, 0}, {0, 1, 0});
  sensors.add({0, 0.5f, -1.5f}, {0, 0, 1});
  RenderSettings s;
  s.samples = 32;
  s.gather = 256;
  s.photons = 50'000;
  s.guiding = false;
  s.filter = Filtering::off;
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false, kPatchBatches));
  const auto lit = std::make_shared<const Scene>(scene_under_patches(scene, SkyPatches(145)));
  Job of_patches(lit, std::make_shared<const Tracer>(*lit), patch_settings(s), nullptr, 0, grid);
  of_patches.wait();
  const ColorMatrix m = daylight_matrix(of_patches, sensors.size());
  s.samples = 64;
  s.photons = 200'000;
  const auto shared = std::make_shared<const Scene>(d);
  Job job(shared, std::make_shared<const Tracer>(*shared), s, nullptr, 0, grid);
  job.wait();
  for (std::size_t i = 0; i < 2; ++i) {
    double sum = 0;
    for (std::size_t patch = 0; patch < m.columns; ++patch) sum += m.at(i, patch).g;
    const double whole = job.snapshot().radiance(i, false).g;
    EXPECT_NEAR(sum, whole, 0.01 * whole) << i;
  }
  // The patch over the sensor: its solid angle times the cosine, within three standard errors of this effort.
  const double overhead = M_PI * std::pow(std::sin(6 * M_PI / 180), 2);
  EXPECT_NEAR(m.at(0, 145).g, overhead, 0.04 * overhead);
}

/// A glowing medium above a sensor is no sun.
TEST(DaylightMatrix, SunsAreApartFromEmissiveMedia) {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[1].inside = 0;
  d.materials[1].outside = kNone;
  add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  add_quad(d, {-1, 3, -1}, {2, 0, 0}, {0, 0, 2}, 1);
  add_quad(d, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 1);
  Medium glow;
  glow.sigma_a = RGB(1.0f);
  glow.emission = RGB(10.0f);
  glow.bounds = Box3{{-1, 2, -1}, {1, 3, 1}};
  d.media.push_back(glow);
  const std::vector<Vec3> suns{normalize(Vec3{1, 0.3f, 0}), normalize(Vec3{-1, 0.2f, 0})};
  const auto lit = std::make_shared<const Scene>(scene_under_suns(Scene(d), suns));
  Sensors sensors;
  sensors.add({0, 0.5f, 0}, {0, 1, 0});
  RenderSettings s;
  s.samples = 256;
  s.gather = 1;
  s.photons = 5'000;
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false, kPatchBatches));
  Job job(lit, std::make_shared<const Tracer>(*lit), patch_settings(s), nullptr, 0, grid);
  job.wait();
  const ColorMatrix m = sun_matrix(job, 1, suns.size());
  for (std::size_t sun = 0; sun < suns.size(); ++sun) EXPECT_NEAR(m.at(0, sun).g, suns[sun].y, 0.02) << sun;
}

TEST(DaylightMatrix, IsWrittenAsRcontribDoes) {
  ColorMatrix m;
  m.rows = 2;
  m.columns = 3;
  for (int i = 0; i < 6; ++i) m.value.emplace_back(static_cast<float>(i), 0.5f, 1e-7f);
  const std::string text = matrix_text(m, "a\nb");
  EXPECT_THAT(text, testing::StartsWith("#?RADIANCE\na b\n"));
  EXPECT_THAT(text, testing::HasSubstr("\nNCOMP=3\nNROWS=2\nNCOLS=3\nFORMAT=ascii\n\n"));
  std::stringstream body(text.substr(text.find("\n\n") + 2));
  for (int i = 0; i < 6; ++i) {
    double r = -1, g = -1, b = -1;
    body >> r >> g >> b;
    EXPECT_EQ(r, i);
    EXPECT_EQ(g, 0.5);
    EXPECT_NEAR(b, 1e-7, 1e-13);
  }
}

}  // namespace
}  // namespace glowworm
