#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "builtin/ornaments.h"
#include "builtin/sky.h"
#include "mesh_checks.h"
#include "scene/light_sampling.h"

namespace glowworm {
namespace {

TEST(Atrium, HasTheDocumentedNumberOfTriangles) {
  EXPECT_GE(builtin_scene("atrium").geometry.triangle_count(), 60000u);
  EXPECT_LE(builtin_scene("atrium").geometry.triangle_count(), 250000u);
  EXPECT_GE(builtin_scene("atrium-large").geometry.triangle_count(), 1200000u);
}

TEST(Atrium, HasTheDocumentedSize) {
  for (const char* name : {"atrium", "atrium-large"}) {
    const Vec3 size = builtin_scene(name).geometry.bounds().diagonal();
    EXPECT_NEAR(size.x, 31.2, 0.3) << name;
    EXPECT_NEAR(size.y, 12.2, 0.3) << name;
    EXPECT_NEAR(size.z, 16.2, 0.3) << name;
  }
}

TEST(Atrium, BothFinenessesHaveTheSameCameras) {
  const SceneDescription a = builtin_scene("atrium"), b = builtin_scene("atrium-large");
  ASSERT_EQ(a.cameras.size(), 3u);
  ASSERT_EQ(b.cameras.size(), 3u);
  const char* names[] = {"main", "gallery", "overview"};
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(a.cameras[k].name, names[k]);
    EXPECT_EQ(a.cameras[k].to_world.translation, b.cameras[k].to_world.translation);
  }
}

TEST(Sky, IsBrightestTowardsTheSunAndBluestAwayFromIt) {
  const Vec3 to_sun = normalize(Vec3{-0.4f, 0.85f, -0.36f});
  const Vec3 across = normalize(Vec3{0.4f, 0.5f, 0.36f});
  const RGB near_sun = clear_sky_radiance(to_sun, to_sun, 3), far = clear_sky_radiance(across, to_sun, 3);
  EXPECT_GT(luminance(near_sun), 2 * luminance(far));
  EXPECT_GT(far.b / far.r, near_sun.b / near_sun.r);
  EXPECT_GT(far.b, 1.5f * far.r);
}

TEST(Sky, ZenithHasTheLuminanceOfThePaper) {
  // Preetham et al., appendix A.2, at turbidity 3 and 30 degrees from the zenith, by hand:
  // (4.0453*3 - 4.9710) tan((4/9 - 3/120)(pi - pi/3)) - 0.2155*3 + 2.4192 = 7.1649*tan(0.878446) + 1.7727 kcd/m^2.
  const Vec3 to_sun{0.5f, std::sqrt(0.75f), 0};
  const double expected = (7.1649 * std::tan(0.878446) + 1.7727) / 10;
  EXPECT_NEAR(luminance(clear_sky_radiance({0, 1, 0}, to_sun, 3)), expected, 0.01 * expected);
}

TEST(Sky, SunOutshinesTheSkyAsOnAClearDay) {
  const Vec3 to_sun = normalize(Vec3{-0.4f, 0.85f, -0.36f});
  const Environment sky = clear_sky(to_sun, 2, 64);
  double irradiance = 0;
  for (int row = 0; row < sky.height / 2; ++row)
    for (int column = 0; column < sky.width; ++column) {
      const double theta = 3.14159265358979 * (row + 0.5) / sky.height;
      irradiance += luminance(sky.pixels[static_cast<std::size_t>(row * sky.width + column)]) * std::cos(theta) *
                    std::sin(theta) * std::pow(3.14159265358979 / sky.height, 2);
    }
  const double sun = luminance(clear_sun(to_sun).intensity) * to_sun.y;
  EXPECT_NEAR(luminance(clear_sun(to_sun).intensity), 9, 1e-4);
  EXPECT_GT(sun / irradiance, 3);
  EXPECT_LT(sun / irradiance, 10);
}

TEST(Sky, IsAlignedWithTheSun) {
  const Scene scene(builtin_scene("atrium"));
  const Vec3 to_sun = -scene.lights()[0].direction;
  const float sun = luminance(environment_radiance(scene, to_sun));
  for (const Vec3 other :
       {Vec3{-to_sun.x, to_sun.y, to_sun.z}, Vec3{to_sun.x, to_sun.y, -to_sun.z}, Vec3{-to_sun.x, to_sun.y, -to_sun.z}})
    EXPECT_GT(sun, 1.5f * luminance(environment_radiance(scene, other)));
  EXPECT_NEAR(sun, luminance(clear_sky_radiance(to_sun, to_sun, 2)), 0.1f * sun);
}

TEST(Ornaments, CurtainsAreSheetsThatLookOutwards) {
  Geometry g;
  MeshBuilder mesh(g);
  add_curtain(mesh, 2, 2.5f, 9, 8, 0.3f);
  EXPECT_EQ(wrong_normals(g), 0u);
  // About the sheet's thickness of 1 cm times its width and height, seen along z.
  EXPECT_NEAR(signed_volume(g), 2 * 2.5 * 0.01, 2 * 2.5 * 0.01 * 0.05);
}

TEST(Ornaments, UrnsAndBalustersAreClosedButForTheGround) {
  Geometry urn, baluster;
  MeshBuilder a(urn), b(baluster);
  add_urn(a, 1, {24, 4});
  add_baluster(b, 0.7f, {12, 3});
  EXPECT_EQ(unmatched_edges(urn), 24u);
  EXPECT_EQ(unmatched_edges(baluster), 2u * 12);  // the rail closes its top
  EXPECT_EQ(wrong_normals(urn) + wrong_normals(baluster), 0u);
}

TEST(Ornaments, ASweptRectangleOfAClosedOutlineIsClosed) {
  Geometry g;
  MeshBuilder mesh(g);
  const MeshBuilder::ProfilePoint square[] = {{1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 0}};
  sweep_rectangle(mesh, square, 3);
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_NEAR(signed_volume(g), 4 * (5 * 2 - 4 * 1), 1e-4);
}

}  // namespace
}  // namespace glowworm
