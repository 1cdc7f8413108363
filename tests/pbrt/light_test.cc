#include <gtest/gtest.h>

#include <cmath>

#include "image/image.h"
#include "import/pbrt/lights.h"
#include "pbrt/pbrt_testing.h"
#include "scene/environment.h"
#include "scene/light_groups.h"
#include "scene/light_power.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::expect_near;
using pbrt_testing::has_note;
using pbrt_testing::kTriangle;
using pbrt_testing::load_text;

Light light(const std::string& directives) { return load_text("WorldBegin\n" + directives).lights.at(0); }
Environment sky(const std::string& directives) { return *load_text("WorldBegin\n" + directives).environment; }

/// What a triangle of area 1/2 emits.
Emission emission(const std::string& directives) {
  const SceneDescription scene = load_text("WorldBegin\n" + directives + "\n" + kTriangle);
  return scene.emissions.at(scene.geometry.emission.at(0));
}

TEST(PbrtLight, Point) {
  const Light l =
      light("Translate 1 2 3 LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2 \"point3 from\" [0 1 0]");
  EXPECT_EQ(l.kind, LightKind::point);
  expect_near(l.intensity, {2, 4, 6});
  expect_near(l.position, {1, 3, 3});
  // 4 pi W of power make an intensity of 1.
  const std::string power = std::to_string(4 * M_PI);
  expect_near(light("LightSource \"point\" \"float power\" " + power).intensity, RGB(1.0f));
}

TEST(PbrtLight, NamesAreThoseOfAnAttribute) {
  const std::string attribute = "Attribute \"light\" \"string name\" \"desk\" ";
  EXPECT_EQ(light(attribute + "LightSource \"point\"").name, "desk");
  EXPECT_EQ(emission(attribute + "AreaLightSource \"diffuse\"").name, "desk");
}

TEST(PbrtLight, WithoutNamesAreGroupsOfTheirOwn) {
  const std::string lights =
      "LightSource \"point\" LightSource \"point\" LightSource \"spot\" LightSource \"infinite\"";
  const Scene scene(load_text("WorldBegin " + lights + "\n" + kTriangle));
  EXPECT_EQ(light_groups(scene).names,
            (std::vector<std::string>{"point light 1", "point light 2", "spot light", "environment"}));
}

TEST(PbrtLight, Spot) {
  const Light l = light(
      "Rotate 90 0 0 1 LightSource \"spot\" \"point3 from\" [1 0 0] \"point3 to\" [3 0 0] \"float coneangle\" 60 "
      "\"float conedeltaangle\" 15 \"rgb I\" [5 5 5]");
  EXPECT_EQ(l.kind, LightKind::spot);
  expect_near(l.position, {0, 1, 0});
  expect_near(l.direction, {0, 1, 0});
  EXPECT_NEAR(l.cos_outer, 0.5f, 1e-6);
  EXPECT_NEAR(l.cos_inner, std::sqrt(0.5f), 1e-6);
  EXPECT_EQ(l.falloff, SpotFalloff::smoothstep);
  expect_near(l.intensity, RGB(5.0f));
  const Light standard = light("LightSource \"spot\"");
  EXPECT_NEAR(standard.cos_outer, std::cos(30 * M_PI / 180), 1e-6);
  EXPECT_NEAR(standard.cos_inner, std::cos(25 * M_PI / 180), 1e-6);
  expect_near(standard.direction, {0, 0, 1});
}

TEST(PbrtLight, SpotPowerIsTheIntegralOfItsFalloff) {
  const Light l = light("LightSource \"spot\" \"float power\" 10");
  // Smoothstep of the cosine between the cones, by the midpoint rule.
  double integral = 0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double c = 1 - (i + 0.5) / kSteps * (1 - l.cos_outer);
    const double t = std::min((c - l.cos_outer) / (l.cos_inner - l.cos_outer), 1.0);
    integral += t * t * (3 - 2 * t) * 2 * M_PI * (1 - l.cos_outer) / kSteps;
  }
  EXPECT_NEAR(l.intensity.g * integral, 10, 1e-3);
}

TEST(PbrtLight, SpotsOfVersion3FallByTheFourthPower) {
  const Light l = light("LightSource \"spot\" \"float conedeltaangle\" 10\nWorldEnd");
  EXPECT_EQ(l.falloff, SpotFalloff::quartic);
  EXPECT_NEAR(spot_falloff(l, (l.cos_inner + l.cos_outer) / 2), 1.0f / 16, 1e-4f);
}

TEST(PbrtLight, Distant) {
  const Light l =
      light("Scale 2 2 2 LightSource \"distant\" \"rgb L\" [3 2 1] \"point3 from\" [0 5 0] \"point3 to\" [0 1 0]");
  EXPECT_EQ(l.kind, LightKind::directional);
  expect_near(l.direction, {0, -1, 0});
  expect_near(l.intensity, {3, 2, 1});
  expect_near(light("LightSource \"distant\" \"float illuminance\" 7").intensity, RGB(7.0f));
  expect_near(light("LightSource \"distant\" \"float scale\" 4").intensity, RGB(4.0f));
}

TEST(PbrtLight, ConstantSky) {
  const Environment e = sky("LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" .5");
  expect_near(e.scale, {0.5f, 1, 1.5f});
  EXPECT_TRUE(e.pixels.empty());
  // Irradiance of a sky of radiance 1 is pi.
  const std::string pi = std::to_string(M_PI);
  expect_near(sky("LightSource \"infinite\" \"float illuminance\" " + pi).scale, RGB(1.0f));
}

TEST(PbrtLight, InfiniteLightsAddUp) {
  const SceneDescription two = load_text(
      "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 0 0] LightSource \"infinite\" \"rgb L\" [0 0 1] "
      "LightSource \"infinite\" \"rgb L\" [0 0.5 0.5]");
  expect_near(two.environment->scale, {1, 0.5f, 1.5f});
  EXPECT_TRUE(has_note(two, "infinite lights are added up"));
}

TEST(PbrtLight, SpectraOfLightsHaveLuminanceOne) {
  EXPECT_NEAR(luminance(light("LightSource \"point\" \"blackbody I\" 3000").intensity), 1, 1e-3);
  EXPECT_NEAR(luminance(light("LightSource \"point\" \"spectrum I\" [300 9 900 9]").intensity), 1, 1e-3);
  EXPECT_NEAR(luminance(light("LightSource \"point\" \"spectrum I\" \"stdillum-D50\" \"float scale\" 3").intensity), 3,
              3e-3);
  expect_near(light("LightSource \"point\"").intensity, RGB(1.0f));
}

TEST(PbrtLight, Version3ScalesByColourAndReadsAbsoluteSpectra) {
  const SceneDescription scene = load_text(
      "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3] \"rgb scale\" [2 1 1] "
      "LightSource \"point\" \"spectrum I\" [300 9 900 9] WorldEnd");
  expect_near(scene.lights[0].intensity, {2, 2, 3});
  EXPECT_NEAR(luminance(scene.lights[1].intensity), 9, 1e-2);
}

TEST(PbrtLight, Version3BlackBodiesAreRelativeToTheirPeak) {
  const SceneDescription scene = load_text("WorldBegin LightSource \"point\" \"blackbody I\" [2700 10] WorldEnd");
  // Planck's law by Wyman's formula of the eye's sensitivity, as in spectrum_test.cc.
  EXPECT_NEAR(luminance(scene.lights[0].intensity), 2.767, 0.05);
}

/// Writes a picture of floats, rows from top to bottom.
void write_sky(const TemporaryFolder& folder, int width, int height, const std::vector<RGB>& pixels) {
  Image image(width, height);
  image.add_rgb("", pixels);
  write_exr(folder.path("sky.exr"), image, ExrPrecision::single);
}

TEST(PbrtLight, EqualAreaImage) {
  const TemporaryFolder folder;
  // The middle of the square is +z, its corners are -z, the middle of its right side is +x, that of the lower is +y.
  std::vector<RGB> pixels(25, RGB(0.0f));
  pixels[12] = {1, 0, 0};
  pixels[14] = {0, 1, 0};
  pixels[22] = {0, 0, 1};
  for (const int corner : {0, 4, 20, 24}) pixels[corner] = RGB(5.0f);  // the four meet in -z
  write_sky(folder, 5, 5, pixels);
  const SceneDescription scene = load_scene(folder.write(
      "s.pbrt",
      "WorldBegin Rotate -90 1 0 0 LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 2"));
  const Environment& e = *scene.environment;
  EXPECT_EQ(e.mapping, EnvironmentMapping::equal_area);
  // The rotation takes z to y and y to -z.
  expect_near(radiance(e, {0, 1, 0}), {2, 0, 0});
  expect_near(radiance(e, {1, 0, 0}), {0, 2, 0});
  expect_near(radiance(e, {0, 0, -1}), {0, 0, 2});
  expect_near(radiance(e, {0, -1, 0}), RGB(10.0f));
}

TEST(PbrtLight, ImagesAndConstantsAddUp) {
  const TemporaryFolder folder;
  std::vector<RGB> pixels(25, RGB(0.0f));
  pixels[12] = {1, 0, 0};
  write_sky(folder, 5, 5, pixels);
  const std::string image = "LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 2\n";
  const std::string constant = "LightSource \"infinite\" \"rgb L\" [0 0.5 1]\n";
  const auto read = [&](const std::string& lights) {
    return *load_scene(folder.write("s.pbrt", "WorldBegin\n" + lights)).environment;
  };
  for (const std::string& lights : {image + constant, constant + image}) {
    const Environment e = read(lights);
    expect_near(radiance(e, {0, 0, 1}), {2, 0.5f, 1});
    expect_near(radiance(e, {1, 0, 0}), {0, 0.5f, 1});
  }
  // The same image twice, once turned upside down.
  const Environment both = read(image + "Rotate 180 1 0 0\n" + image);
  EXPECT_GT(radiance(both, {0, 0, 1}).r, 1);
  EXPECT_NEAR(radiance(both, {0, 0, 1}).r, 2, 0.7f) << "averaged over the pixel";
  const RGB once = environment_integral(read(image)), twice = environment_integral(both);
  EXPECT_NEAR(twice.r, 2 * once.r, 0.03f * once.r);
}

TEST(PbrtLight, LatLongImage) {
  const TemporaryFolder folder;
  // Four columns: phi from 0 to 360 degrees from +x over +y; three rows from +z down.
  std::vector<RGB> pixels(18, RGB(0.0f));
  for (int x = 0; x < 6; ++x) pixels[x] = RGB(7.0f);
  pixels[6] = {1, 0, 0};
  pixels[7] = {0, 1, 0};
  write_sky(folder, 6, 3, pixels);
  const SceneDescription scene =
      load_scene(folder.write("s.pbrt", "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\""));
  const Environment& e = *scene.environment;
  EXPECT_EQ(e.mapping, EnvironmentMapping::lat_long);
  const auto horizontal = [](double degrees) {
    return Vec3{static_cast<float>(std::cos(degrees * M_PI / 180)), static_cast<float>(std::sin(degrees * M_PI / 180)),
                0};
  };
  expect_near(radiance(e, {0, 0, 1}), RGB(7.0f));
  expect_near(radiance(e, horizontal(30)), {1, 0, 0});
  expect_near(radiance(e, horizontal(90)), {0, 1, 0});
  expect_near(radiance(e, horizontal(200)), RGB(0.0f));
}

TEST(PbrtLight, IlluminanceOfAnImage) {
  const TemporaryFolder folder;
  write_sky(folder, 8, 8, std::vector<RGB>(64, RGB(3.0f)));
  const SceneDescription scene = load_scene(folder.write(
      "s.pbrt", "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float illuminance\" " +
                    std::to_string(2 * M_PI)));
  expect_near(radiance(*scene.environment, {0, 0, 1}), RGB(2.0f), 1e-4f);
}

TEST(PbrtLight, Area) {
  const Emission e = emission("AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2");
  expect_near(e.radiance.value, {2, 4, 6});
  EXPECT_FALSE(e.two_sided);
  EXPECT_TRUE(emission("AreaLightSource \"diffuse\" \"bool twosided\" true").two_sided);
  expect_near(emission("AreaLightSource \"diffuse\"").radiance.value, RGB(1.0f));
}

TEST(PbrtLight, AreaLightPower) {
  // pi W from 1/2 m^2 by radiance 2, whatever was said before; half of it to each of two sides.
  const std::string pi = std::to_string(M_PI);
  expect_near(emission("AreaLightSource \"diffuse\" \"float power\" " + pi).radiance.value, RGB(2.0f));
  expect_near(emission("AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" " + pi).radiance.value,
              RGB(1.0f));
  expect_near(emission("Scale 2 2 2 AreaLightSource \"diffuse\" \"float power\" " + pi).radiance.value, RGB(0.5f));
}

TEST(PbrtLight, PowerIsOfEachTriangleButOfAWholeSphere) {
  const SceneDescription mesh = load_text(
      "WorldBegin AreaLightSource \"diffuse\" \"float power\" 1 Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 "
      "3] "
      "\"point3 P\" [0 0 0 1 0 0 1 1 0 0 3 0]");
  for (std::uint32_t t = 0; t < 2; ++t) {
    const RGB l = mesh.emissions.at(mesh.geometry.emission.at(t)).radiance.value;
    EXPECT_NEAR(l.g * M_PI * mesh.geometry.area(t), 1, 1e-5) << t;
  }
  const SceneDescription sphere =
      load_text("WorldBegin AreaLightSource \"diffuse\" \"float power\" 1 Shape \"sphere\"");
  ASSERT_EQ(sphere.emissions.size(), 1u);
  EXPECT_NEAR(sphere.emissions[0].radiance.value.g * M_PI * 4 * M_PI, 1, 1e-5);
}

TEST(PbrtLight, PowerIsOfEachFaceOfAPlyMesh) {
  const TemporaryFolder folder;
  folder.write("m.ply",
               "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
               "0 0 0 2 0 0 2 2 0 0 2 0 5 1 0 4 0 1 2 3 3 1 4 2\n");
  const SceneDescription scene = load_scene(folder.write("s.pbrt",
                                                         "WorldBegin AreaLightSource \"diffuse\" \"float power\" 100 "
                                                         "Shape \"plymesh\" \"string filename\" \"m.ply\""));
  ASSERT_EQ(scene.geometry.triangle_count(), 3u);
  EXPECT_EQ(scene.emissions.size(), 2u);
  double power = 0;
  for (std::uint32_t t = 0; t < 3; ++t) {
    power += scene.emissions.at(scene.geometry.emission.at(t)).radiance.value.g * M_PI * scene.geometry.area(t);
  }
  EXPECT_NEAR(power, 200, 1e-3);
}

TEST(PbrtLight, EmissionIsSharedWhereItIsTheSame) {
  const SceneDescription scene = load_text(std::string("WorldBegin AreaLightSource \"diffuse\"\n") + kTriangle +
                                           kTriangle + "AttributeBegin AttributeEnd\n" + kTriangle);
  EXPECT_EQ(scene.emissions.size(), 1u);
  EXPECT_EQ(scene.geometry.triangle_count(), 3u);
  EXPECT_EQ(scene.geometry.emission[2], 0u);
}

TEST(PbrtLight, AreaLightsEndWithTheirAttributes) {
  const SceneDescription scene = load_text(std::string("WorldBegin AttributeBegin AreaLightSource \"diffuse\"\n") +
                                           kTriangle + "AttributeEnd\n" + kTriangle);
  EXPECT_EQ(scene.geometry.emission[0], 0u);
  EXPECT_EQ(scene.geometry.emission[1], kNone);
}

TEST(PbrtLight, AreaLightsOfObjectsShineAtEachPlace) {
  std::string text = std::string(
                         "WorldBegin ObjectBegin \"o\" Shape \"sphere\" AttributeBegin AreaLightSource "
                         "\"diffuse\"\n") +
                     kTriangle + "AttributeEnd ObjectEnd\n";
  for (int i = 0; i < 4; ++i) text += "Translate 3 0 0 ObjectInstance \"o\"\n";
  const Scene scene(load_text(text));
  EXPECT_EQ(scene.emissive_triangles().size(), 4u);
  EXPECT_EQ(scene.emissions().size(), 1u);
  EXPECT_EQ(scene.geometry().instances.size(), 3u);
  const Geometry& g = scene.geometry();
  EXPECT_FLOAT_EQ(g.positions[g.triangles[scene.emissive_triangles()[3]][0]].x -
                      g.positions[g.triangles[scene.emissive_triangles()[0]][0]].x,
                  9);
}

TEST(PbrtLight, AreaLightsOfAlphaZeroAreLeftOutAndNoted) {
  const char* note = "not supported, left out with its light: area light of a shape with an alpha of 0";
  const std::string lamp = "WorldBegin AreaLightSource \"diffuse\" Shape \"disk\" \"float alpha\" ";
  const SceneDescription scene = load_text(lamp + "0");
  EXPECT_EQ(scene.geometry.triangle_count(), 0u);
  EXPECT_TRUE(has_note(scene, note));
  EXPECT_FALSE(has_note(load_text(lamp + ".5"), note));
  EXPECT_FALSE(has_note(load_text("WorldBegin Shape \"disk\" \"float alpha\" 0"), note));
}

TEST(PbrtLight, UnsupportedKindsAreNoted) {
  const SceneDescription scene = load_text(
      "WorldBegin LightSource \"projection\" \"string filename\" \"x.png\" LightSource \"goniometric\" \"rgb I\" [2 2 "
      "2]");
  ASSERT_EQ(scene.lights.size(), 1u);
  expect_near(scene.lights[0].intensity, RGB(2.0f));
  EXPECT_TRUE(has_note(scene, "not supported, left out: projection light"));
  EXPECT_TRUE(has_note(scene, "not supported, read as a point light: goniometric light"));
  EXPECT_EQ(scene.notes.size(), 2u);
}

TEST(PbrtLight, MistakesAreErrorsWithPlaces) {
  const struct {
    const char *text, *message;
  } kCases[] = {
      {"LightSource \"lamp\"", "scene.pbrt:1:1: unknown light \"lamp\""},
      {"AreaLightSource \"lamp\"", "scene.pbrt:1:1: unknown area light \"lamp\""},
      {"LightSource \"distant\" \"point3 from\" [0 0 1]", "scene.pbrt:1:1: the light has no direction"},
      {"LightSource \"spot\" \"float coneangle\" 0", "scene.pbrt:1:1: a spot light needs a coneangle"},
      {"LightSource \"point\" \"blackbody I\" 0", "scene.pbrt:1:21: a black body of 0 K"},
      {"LightSource \"point\" \"texture I\" \"t\"", "scene.pbrt:1:21: \"I\" cannot be a texture here"},
      {"Scale 0 1 1 LightSource \"point\"", "scene.pbrt:1:13: the transform of the light cannot be inverted"},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_NE(error_of(text).find(message), std::string::npos) << text << "\n" << error_of(text);
  }
}

}  // namespace
}  // namespace glowworm
