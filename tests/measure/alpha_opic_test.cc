// Alpha-opic quantities: efficacies of illuminants by CIE S 026, and sums over lamps.
#include "measure/alpha_opic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "control/job.h"
#include "core/error.h"
#include "measure/measurement.h"
#include "scene/scene_parts.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// Melanopic equivalent daylight illuminance of 1 lx.
double melanopic_ratio(const SampledSpectrum& spectrum) {
  return equivalent_daylight(alpha_opic_efficacy(spectrum)[kMelanopic], kMelanopic);
}

TEST(AlphaOpicEfficacies, OfDaylightAreThoseOfTheStandard) {
  // CIE S 026:2018, table 4, mW/lm.
  const AlphaOpic expected = {0.8173e-3, 1.4558e-3, 1.6289e-3, 1.4497e-3, 1.3262e-3};
  const AlphaOpic efficacy = alpha_opic_efficacy(spectrum_of_text("D65"));
  for (std::size_t k = 0; k < kAlphaOpicCount; ++k) {
    EXPECT_NEAR(efficacy[k], expected[k], 4e-4 * expected[k]) << kAlphaOpicNames[k];
    EXPECT_NEAR(equivalent_daylight(efficacy[k], k), 1, 1e-12) << "lx of D65";
  }
}

TEST(AlphaOpicEfficacies, OfOtherIlluminantsHaveTheirKnownRatios) {
  EXPECT_NEAR(melanopic_ratio(spectrum_of_text("A")), 0.4959, 5e-4);
  EXPECT_NEAR(melanopic_ratio(spectrum_of_text("E")), 0.9058, 1e-3);
  EXPECT_NEAR(melanopic_ratio(spectrum_of_text("2856")), melanopic_ratio(spectrum_of_text("A")), 1e-3);
  EXPECT_NEAR(melanopic_ratio(spectrum_of_text("6504")), 1, 1e-3);
  double before = 0;
  for (const char* kelvin : {"2700", "3000", "4000", "5000", "6500", "8000", "20000"}) {
    const double ratio = melanopic_ratio(spectrum_of_text(kelvin));
    EXPECT_GT(ratio, before) << kelvin;
    before = ratio;
  }
  for (const char* bad : {"B", "D60", "500", "30000", "-4000"}) EXPECT_THROW(spectrum_of_text(bad), Error) << bad;
}

/// Chromaticity under the matching functions of the renderer.
std::pair<double, double> chromaticity(const SampledSpectrum& spectrum) {
  // These are tabled every 10 nm; means around them keep lines between.
  SampledSpectrum coarse;
  for (double nm = 380; nm <= 780; nm += 10) {
    coarse.wavelengths.push_back(nm);
    coarse.values.push_back(spectrum.at(nm) / 2 + (spectrum.at(nm - 5) + spectrum.at(nm + 5)) / 4);
  }
  const RGB c = illuminant_rgb(coarse);
  // IEC 61966-2-1.
  const double x = 0.4124 * c.r + 0.3576 * c.g + 0.1805 * c.b, y = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b,
               z = 0.0193 * c.r + 0.1192 * c.g + 0.9505 * c.b;
  return {x / (x + y + z), y / (x + y + z)};
}

TEST(Spectra, OfIlluminantsHaveTheChromaticityOfTheirTables) {
  struct Case {
    const char* name;
    double x, y, tolerance;
  };
  // CIE 15:2004, tables T.3 and T.8.
  for (const Case& c :
       {Case{"A", 0.4476, 0.4074, 2e-3}, Case{"D50", 0.3457, 0.3585, 2e-3}, Case{"D65", 0.3127, 0.3290, 2e-3},
        Case{"D75", 0.2990, 0.3149, 2e-3}, Case{"E", 1.0 / 3, 1.0 / 3, 2e-3}, Case{"F2", 0.3721, 0.3751, 2e-3},
        Case{"F7", 0.3129, 0.3292, 2e-3}, Case{"F11", 0.3805, 0.3769, 2e-3}}) {
    const auto [x, y] = chromaticity(spectrum_of_text(c.name));
    EXPECT_NEAR(x, c.x, c.tolerance) << c.name;
    EXPECT_NEAR(y, c.y, c.tolerance) << c.name;
  }
}

class SpectrumFiles : public FolderTest {};

TEST_F(SpectrumFiles, AreTablesWithOrWithoutAHeader) {
  for (const std::string text : {"380 1\n780 1\n", "Wavelength (nm),Power\n380,1\n780,1\n",
                                 "\"nm\";\"W\"\r\n380;1\r\n780;1\r\n", "# lamp\n380 1 780 1\n"}) {
    write("lamp.csv", text);
    EXPECT_NEAR(melanopic_ratio(spectrum_of_text((folder_ / "lamp.csv").string())),
                melanopic_ratio(spectrum_of_text("E")), 1e-9)
        << text;
  }
  EXPECT_THAT(message_of([] { parse_spectrum_table("380,1\n400,-1\n", "lamp.csv"); }), HasSubstr("negative"));
  EXPECT_THAT(message_of([] { parse_spectrum_table("380,1\n400,x\n", "lamp.csv"); }), HasSubstr("lamp.csv:2"));
  EXPECT_THAT(message_of([] { alpha_opic_efficacy(parse_spectrum_table("380 0 780 0", "dark.spd")); }),
              HasSubstr("no visible light"));
  for (const std::string cut : {"1000 1 1200 1", "0.38 1 0.78 1", "450 1 780 1", "380 1 650 1"})
    EXPECT_THAT(message_of([&] { parse_spectrum_table(cut, "cut.spd"); }), HasSubstr("cut.spd: its spectrum from"))
        << cut;
  EXPECT_EQ(parse_spectrum_table("400 1 700 1", "lamp.spd").values.size(), 2u);
  EXPECT_EQ(parse_spectrum_table("450 0 550 1 650 0", "lamp.spd").values.size(), 3u) << "dark at its ends";
}

TEST(LampSpectra, AreFoundByTheNamesOfLights) {
  LightGroups groups;
  groups.names = {"lamp.ies", "sky", "sun"};
  std::vector<std::string> without;
  const auto found =
      efficacies_of_groups(groups, {parse_lamp_spectrum("lamp.ies=2700"), parse_lamp_spectrum("sky=D75")}, without);
  EXPECT_EQ(found[0], alpha_opic_efficacy(spectrum_of_text("2700")));
  EXPECT_EQ(found[1], alpha_opic_efficacy(spectrum_of_text("D75")));
  EXPECT_EQ(found[2], alpha_opic_efficacy(spectrum_of_text("D65")));
  EXPECT_EQ(without, std::vector<std::string>{"sun"});
  EXPECT_EQ(efficacies_of_groups(groups, {{"all", "A"}, {"sun", "E"}}, without)[1],
            alpha_opic_efficacy(spectrum_of_text("A")));
  EXPECT_THROW(efficacies_of_groups(groups, {{"lamp", "A"}}, without), Error);
  for (const char* bad : {"lamp", "=A", "lamp=", "lamp=none"}) EXPECT_THROW(parse_lamp_spectrum(bad), Error) << bad;
}

TEST(LampSpectra, ColouredMaterialsAreNamed) {
  SceneDescription d = floor_description();
  d.materials[0].name = "grey";
  d.materials.emplace_back();
  d.materials[1].name = "red";
  d.materials[1].reflectance.value = RGB(0.8f, 0.2f, 0.1f);
  d.materials.push_back(d.materials[1]);
  d.materials[2].name = "unused";
  add_quad(d, {-2, -2, 0}, {0, 0, 1}, {0, 4, 0}, 1);
  EXPECT_EQ(coloured_materials(Scene(std::move(d))), std::vector<std::string>{"red"});
}

/// Lights a floor from above by two distant lights of 300 and 200 lx, under a ceiling that is grey and open.
std::shared_ptr<const Scene> two_lights() {
  SceneDescription d = floor_description();
  for (const float lux : {300.0f, 200.0f}) {
    Light light;
    light.name = lux == 300 ? "day" : "lamp";
    light.kind = LightKind::directional;
    light.intensity = RGB(lux / kLuminousEfficacy);
    light.direction = {0, 0, -1};
    d.lights.push_back(light);
  }
  return std::make_shared<const Scene>(std::move(d));
}

TEST(AlphaOpic, AddsUpOverLightsByTheirRatios) {
  const auto scene = two_lights();
  const auto tracer = std::make_shared<const Tracer>(*scene);
  Sensors sensors;
  sensors.add({0.1f, 0.2f, 1}, {0, 0, 1});
  sensors.add({0.5f, -0.2f, 0.5f}, {0, std::sqrt(0.5f), std::sqrt(0.5f)});
  RenderSettings settings = sensor_settings(RenderSettings());
  settings.integrator = Integrator::path;
  settings.samples = 16384;
  settings.light_groups = settings.separate_layers = true;
  settings.memory_bytes = 1 << 28;
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false, kSensorBatches));
  Job job(scene, tracer, settings, nullptr, end_of_sensors(), grid);
  job.wait();
  ASSERT_NE(job.light_groups(), nullptr);
  ASSERT_EQ(job.light_groups()->names, (std::vector<std::string>{"day", "lamp"}));
  // A lamp whose melanopic ratio is 0.45.
  AlphaOpic day = alpha_opic_efficacy(spectrum_of_text("D65")), lamp = day;
  for (double& e : lamp) e *= 0.45;
  const Film film = job.snapshot();
  Measurement m = measurement_of(sensors, film, *scene);
  m.alpha_opic = alpha_opic_irradiances(film, sensors.size(), {day, lamp});
  EXPECT_NEAR(illuminance(m.irradiance[0]), 500, 0.01);
  // A sample chooses one of the lights.
  EXPECT_NEAR(equivalent_daylight(m.alpha_opic[0][kMelanopic], kMelanopic), 390, 1);
  m.alpha_opic = alpha_opic_irradiances(film, sensors.size(), {day, day});
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(equivalent_daylight(m.alpha_opic[i][kMelanopic], kMelanopic), illuminance(m.irradiance[i]), 0.01)
        << "lx of D65";
  EXPECT_THAT(measurement_csv(m, "test"), HasSubstr("relative_error,melanopic_EDI_lx,E_S_cone_opic_W_m2"));
  for (const std::string& text : {measurement_json(m, "t"), measurement_ply(m, "t"), measurement_vtk(m, "t")})
    EXPECT_THAT(text, HasSubstr("E_rhodopic_W_m2"));
}

}  // namespace
}  // namespace glowworm
