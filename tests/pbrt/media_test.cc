#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_testing.h"
#include "scene/scene.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::has_note;
using pbrt_testing::kTriangle;
using pbrt_testing::load_text;

const std::string kFog =
    "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 2 3] \"rgb sigma_a\" [4 5 6] ";

/// The medium of a MakeNamedMedium directive with these parameters.
Medium medium(const std::string& parameters, const std::string& before = "") {
  const SceneDescription scene =
      load_text("WorldBegin " + before + " MakeNamedMedium \"m\" " + parameters + "\n" + kTriangle);
  return scene.media.at(0);
}

/// The material of the scene's only triangle.
const Material& material_of(const SceneDescription& scene) { return scene.materials.at(scene.geometry.material.at(0)); }

void expect_color(RGB a, RGB b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-4f * (1 + b[c]));
}

TEST(PbrtMedia, HomogeneousMediaHaveTheirCoefficients) {
  const Medium m = medium(
      "\"string type\" \"homogeneous\" \"rgb sigma_s\" [1 2 3] \"rgb sigma_a\" [4 5 6] \"float scale\" 2 \"float g\" "
      ".5 "
      "\"rgb Le\" [1 2 1] \"float Lescale\" 3");
  EXPECT_EQ(m.name, "m");
  expect_color(m.sigma_s, {2, 4, 6});
  expect_color(m.sigma_a, {8, 10, 12});
  expect_color(m.emission, {3, 6, 3});
  EXPECT_EQ(m.g, 0.5f);
  expect_color(medium("\"rgb Le\" [1 2 1] \"float LeScale\" 3").emission / medium("\"rgb Le\" [1 2 1]").emission,
               RGB(3.0f));
  EXPECT_FALSE(m.bounds || m.grid);
  expect_color(medium("\"string preset\" \"Ketchup\" \"float scale\" 10").sigma_s, {1.8f, 0.7f, 0.3f});
  expect_color(medium("").sigma_s, {2.55f, 3.21f, 3.77f});
}

TEST(PbrtMedia, PresetsAreMeasuredSubstances) {
  const Medium beer = medium("\"string preset\" \"Budweiser Beer\" \"float scale\" 100");
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(beer.sigma_s[c], RGB(2.4356e-3f, 2.4079e-3f, 1.0564e-3f)[c], 1e-7f);
    EXPECT_NEAR(beer.sigma_a[c], RGB(1.1492f, 2.4911f, 5.7786f)[c], 1e-4f);
  }
  EXPECT_EQ(beer.g, 0);
  // Coefficients stand behind a preset in pbrt-v4, and before it in pbrt-v3.
  const std::string both = "\"string preset\" \"Skimmilk\" \"rgb sigma_s\" [1 2 3] ";
  expect_color(medium(both).sigma_s, {0.70f, 1.22f, 1.90f});
  const Medium v3 =
      load_text("WorldBegin MakeNamedMedium \"m\" \"string type\" \"heterogeneous\" \"float density\" [1] " + both +
                kTriangle + "WorldEnd\n")
          .media.at(0);
  expect_color(v3.sigma_s, {1, 2, 3});
  expect_color(v3.sigma_a, {0.0014f, 0.0025f, 0.0142f});
}

TEST(PbrtMedia, GridsArePlacedByTheTransform) {
  const Medium m = medium(
      "\"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1 \"point3 p0\" [0 0 0] "
      "\"point3 p1\" [4 2 2] \"rgb sigma_s\" [1 1 1] \"rgb sigma_a\" [2 2 2] \"float density\" [1 3] \"rgb Le\" [1 1 "
      "1] "
      "\"float Lescale\" [5 0]",
      "Translate 10 0 0 Scale 2 2 2");
  const MediumPoint p = medium_point(m, {12, 2, 2});  // the centre of the first cell
  expect_color(p.sigma_s, RGB(1.0f));
  expect_color(p.sigma_a, RGB(2.0f));
  expect_color(p.emission, RGB(10.0f));
  expect_color(medium_point(m, {16, 2, 2}).sigma_s, RGB(3.0f));
  expect_color(medium_point(m, {9, 2, 2}).sigma_s, RGB(0.0f));
}

TEST(PbrtMedia, TemperaturesEmitAsBlackBodies) {
  const std::string grid =
      "\"string type\" \"uniformgrid\" \"integer nx\" 3 \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0] "
      "\"float temperature\" [0 1000 6000] ";
  const Medium m = medium(grid);
  const auto at = [](const Medium& medium, float x) { return medium_point(medium, {x, 0.5f, 0.5f}).emission; };
  EXPECT_TRUE(is_black(at(m, 1 / 6.0f)));
  EXPECT_GT(at(m, 0.5f).r, at(m, 0.5f).b);
  // The spectrum of 6000 K is 1 at its peak, which is visible; a spectrum of 1 everywhere has the luminance 106.857,
  // the integral of the CIE 1931 function y (pbrt-v4's CIE_Y_integral).
  EXPECT_NEAR(luminance(at(m, 5 / 6.0f)), 0.98f * 106.857f, 0.04f * 106.857f);
  expect_color(at(medium(grid + "\"float Lescale\" [1 1 2]"), 5 / 6.0f), at(m, 5 / 6.0f) * 2.0f);
  const Medium shifted = medium(grid + "\"float temperatureoffset\" 1000 \"float temperaturescale\" 2");
  EXPECT_TRUE(is_black(at(shifted, 0.5f)));
  const RGB hot = at(m, 5 / 6.0f), hotter = at(shifted, 5 / 6.0f);  // 6000 K, 10,000 K
  EXPECT_GT(hotter.b / hotter.r, hot.b / hot.r);
}

TEST(PbrtMedia, GridsOfColors) {
  const Medium m = medium(
      "\"string type\" \"rgbgrid\" \"integer nx\" 2 \"rgb sigma_s\" [1 2 3 4 5 6] \"rgb Le\" [0 0 0 2 0 0] \"float "
      "scale\" 2");
  expect_color(medium_point(m, {0.25f, 0.5f, 0.5f}).sigma_s, {2, 4, 6});
  expect_color(medium_point(m, {0.75f, 0.5f, 0.5f}).sigma_s, {8, 10, 12});
  expect_color(medium_point(m, {0.75f, 0.5f, 0.5f}).sigma_a, RGB(2.0f));
  const RGB emission = medium_point(m, {0.75f, 0.5f, 0.5f}).emission;
  EXPECT_NEAR(emission.r, 4 * 106.857f, 0.02f) << "pbrt-v4 does not scale these to luminance 1";
  EXPECT_EQ(emission.g, 0);
}

TEST(PbrtMedia, CloudsAreDenserBelowThanAbove) {
  const Medium m = medium("\"string type\" \"cloud\" \"rgb sigma_s\" [10 10 10] \"float frequency\" 2");
  double below = 0, above = 0;
  for (int i = 0; i < 1000; ++i) {
    const float x = static_cast<float>(i % 10) / 10, z = static_cast<float>(i / 10 % 10) / 10;
    const float y = static_cast<float>(i / 100) / 20;
    below += medium_point(m, {x, y, z}).sigma_s.r;
    above += medium_point(m, {x, y + 0.5f, z}).sigma_s.r;
  }
  EXPECT_GT(below, above);
  EXPECT_GT(above, 0);
  EXPECT_LE(greatest_extinction(m), 11.0f);
}

TEST(PbrtMedia, InterfacesNameSidesEvenBeforeTheMediumIsDefined) {
  const SceneDescription scene =
      load_text("WorldBegin MediumInterface \"fog\" \"\" Material \"interface\" " + std::string(kTriangle) + kFog);
  ASSERT_EQ(scene.media.size(), 1u);
  expect_color(scene.media[0].sigma_a, {4, 5, 6});
  EXPECT_EQ(material_of(scene).kind, MaterialKind::interface);
  EXPECT_EQ(material_of(scene).inside, 0u);
  EXPECT_EQ(material_of(scene).outside, kNone);
  EXPECT_EQ(scene.ambient_medium, kNone);
}

TEST(PbrtMedia, TheCameraStandsInTheMediumOutside) {
  const auto of = [](const std::string& interfaces) {
    return load_text(kFog + interfaces + " Camera \"perspective\" WorldBegin " + kTriangle);
  };
  EXPECT_EQ(of("MediumInterface \"\" \"fog\"").ambient_medium, 0u);
  EXPECT_EQ(of("MediumInterface \"fog\"").ambient_medium, 0u);
  EXPECT_EQ(of("MediumInterface \"fog\" \"\"").ambient_medium, kNone);
  EXPECT_EQ(of("").ambient_medium, kNone);
  // The interface stays in force for shapes.
  EXPECT_EQ(material_of(of("MediumInterface \"\" \"fog\"")).outside, 0u);
  EXPECT_EQ(material_of(of("MediumInterface \"\" \"fog\"")).inside, kNone);
  EXPECT_EQ(material_of(of("MediumInterface \"fog\"")).outside, kUnnamed);
}

TEST(PbrtMedia, AttributeEndEndsAnInterface) {
  const SceneDescription scene = load_text(kFog + "WorldBegin AttributeBegin MediumInterface \"fog\" \"\" " +
                                           kTriangle + "AttributeEnd Translate 0 0 1 " + kTriangle);
  EXPECT_EQ(material_of(scene).inside, 0u);
  EXPECT_EQ(scene.materials[scene.geometry.material[1]].inside, kUnnamed);
}

TEST(PbrtMedia, InterfacesDoNotEmit) {
  const SceneDescription scene = load_text(
      kFog + "WorldBegin MediumInterface \"fog\" \"\" Material \"interface\" AreaLightSource \"diffuse\" " + kTriangle);
  EXPECT_EQ(scene.geometry.emission.at(0), kNone);
}

TEST(PbrtMedia, MistakesAreErrorsWithTheirPlace) {
  const auto of = [](const std::string& parameters) {
    return error_of("WorldBegin\nMakeNamedMedium \"m\" " + parameters + "\n" + kTriangle);
  };
  const std::string grid = "\"string type\" \"uniformgrid\" \"integer nx\" 2 ";
  for (const std::string& parameters : {
           std::string("\"rgb sigma_a\" [-1 0 0]"),
           std::string("\"float g\" 1"),
           std::string("\"float scale\" -1"),
           std::string("\"rgb Le\" [-1 -1 -1]"),
           std::string("\"string type\" \"smoke\""),
           std::string("\"string preset\" \"Beer\""),
           grid + "\"float density\" [1 2 3]",
           grid + "\"float density\" [1 -2]",
           grid,
           grid + "\"float density\" [1 2] \"point3 p1\" [1 0 1]",
           grid + "\"float density\" [1 2] \"integer nz\" -1",
           grid + "\"float density\" [1 2] \"rgb Le\" [1 1 1] \"float Lescale\" [1]",
           grid + "\"float temperature\" [900 900] \"rgb Le\" [1 1 1]",
           grid + "\"float temperature\" [900 900] \"float LeScale\" 10",
           std::string("\"string type\" \"rgbgrid\" \"rgb sigma_a\" [1 1 1 1 1 1]"),
           std::string("\"string type\" \"rgbgrid\""),
           std::string("\"string type\" \"cloud\" \"float frequency\" -1"),
           std::string("\"string type\" \"nanovdb\" \"string filename\" \"none.nvdb\""),
           std::string("\"string type\" \"nanovdb\""),
       })
    EXPECT_THAT(of(parameters), testing::HasSubstr("scene.pbrt:2:")) << parameters;
  EXPECT_THAT(error_of(std::string("WorldBegin MediumInterface \"mist\" \"\" ") + kTriangle),
              testing::HasSubstr("there is no medium \"mist\""));
}

}  // namespace
}  // namespace glowworm
