// Daylight matrices: patches in Radiance's order, and rows that add up to the light of the whole sky.
#include "measure/sky_patches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/error.h"
#include "measure/measurement.h"
#include "render/job.h"
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

TEST(SkyPatches, LightTheDirectionsThatLieInThem) {
  const SkyPatches patches(145);
  for (const std::size_t patch :
       {std::size_t{0}, std::size_t{1}, std::size_t{20}, std::size_t{100}, std::size_t{145}}) {
    const Environment e = patches.light(patch);
    for (int i = 0; i < 2000; ++i) {
      // Directions that are farther than a texel from the edges of patches.
      const Vec3 d = sky_direction(static_cast<float>(-80 + 0.085 * i), static_cast<float>((37 * i) % 360));
      bool near_edge = false;
      for (const float up : {-1.0f, 1.0f})
        for (const float around : {-1.0f, 1.0f}) {
          const float altitude = static_cast<float>(-80 + 0.085 * i) + up;
          near_edge = near_edge || patches.patch_of(sky_direction(
                                       altitude, static_cast<float>((37 * i) % 360) +
                                                     around / std::max(0.05f, std::cos(altitude * kPi / 180)))) !=
                                       patches.patch_of(d);
        }
      if (near_edge) continue;
      ASSERT_NEAR(radiance(e, d).g, patches.patch_of(d) == patch ? 1 : 0, 1e-4) << "patch " << patch << ", " << i;
    }
  }
}

TEST(SkyPatches, TogetherAreTheSameAllAround) {
  const SkyPatches patches(577);
  std::vector<Vec3> directions;
  for (int i = 0; i < 50; ++i)
    directions.push_back(sky_direction(static_cast<float>(-60 + 3 * i), static_cast<float>((77 * i) % 360)));
  std::vector<double> sum(directions.size(), 0.0);
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    const Environment e = patches.light(patch);
    for (std::size_t i = 0; i < directions.size(); ++i) sum[i] += radiance(e, directions[i]).g;
  }
  for (const double s : sum) EXPECT_NEAR(s, 1, 1e-4);
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
  s.gather = 16;
  s.photons = 5'000;
  s.guiding = false;
  s.filter = Filtering::off;
  std::size_t calls = 0;
  const DaylightMatrix m =
      measure_sky_patches(scene, sensors, false, SkyPatches(145), s, [&](std::size_t) { ++calls; });
  EXPECT_EQ(calls, 147u);
  s.samples = 64;
  s.gather = 256;
  s.photons = 200'000;
  const auto shared = std::make_shared<const Scene>(d);
  Job job(shared, std::make_shared<const Tracer>(*shared), s, nullptr, 0,
          std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
  job.wait();
  for (std::size_t i = 0; i < 2; ++i) {
    double sum = 0;
    for (std::size_t patch = 0; patch < m.patches; ++patch) sum += m.at(i, patch).g;
    const double whole = job.snapshot().radiance(i, false).g;
    EXPECT_NEAR(sum, whole, 0.01 * whole) << i;
  }
  // The patch over the sensor: its solid angle times the cosine, within three standard errors of this effort.
  const double overhead = M_PI * std::pow(std::sin(6 * M_PI / 180), 2);
  EXPECT_NEAR(m.at(0, 145).g, overhead, 0.04 * overhead);
}

TEST(DaylightMatrix, IsWrittenAsRcontribDoes) {
  DaylightMatrix m;
  m.sensors = 2;
  m.patches = 3;
  for (int i = 0; i < 6; ++i) m.coefficient.emplace_back(static_cast<float>(i), 0.5f, 1e-7f);
  const std::string text = daylight_matrix_text(m, "a\nb");
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
