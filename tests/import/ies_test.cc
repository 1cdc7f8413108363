// Photometric files: what they say of each direction, what is under the lamp, and files that are cut off.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "gltf_file.h"
#include "import/ies/luminaire.h"
#include "import/import.h"
#include "import/scene_changes.h"
#include "scene/light_power.h"
#include "scene/light_sampling.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// A direction of the luminaire's axes by the angles of type C, in degrees.
Vec3 direction_c(float c, float gamma) {
  const float a = c * kPi / 180, g = gamma * kPi / 180;
  return {std::sin(g) * std::cos(a), std::sin(g) * std::sin(a), std::cos(g)};
}

/// By the angles of types A and B: `latitude` from the plane across the pole, `azimuth` around it.
Vec3 direction_a(float azimuth, float latitude) {
  const float a = azimuth * kPi / 180, l = latitude * kPi / 180;
  return {std::cos(l) * std::sin(a), std::sin(l), std::cos(l) * std::cos(a)};
}

std::string header(const char* version, const char* counts, const char* type) {
  return std::string(version) + "\r\n[TEST] 1\r\nTILT=NONE\r\n1 -1 2 " + counts + " " + type +
         " 2 0.1 0.2 0\r\n0.5 1 30\r\n";
}

IntensityTable lm63(const std::string& text) { return parse_lm63(text, "lamp.ies").table; }

TEST(Lm63, KeepsQuadrantsOfTypeC) {
  const IntensityTable t =
      lm63(header("IESNA:LM-63-2002", "3 3", "1") + "0 45 90\r\n0 30 90\r\n100 80 60\r\n100 50 40\r\n100 20,10\r\n");
  for (const float turn : {0.0f, 180.0f})
    for (const float side : {1.0f, -1.0f}) {
      EXPECT_NEAR(t.intensity(direction_c(turn + side * 30, 45)), 50, 0.01f) << turn << ' ' << side;
      EXPECT_NEAR(t.intensity(direction_c(turn + side * 15, 45)), 65, 0.01f);
      EXPECT_NEAR(t.intensity(direction_c(turn + side * 90, 67.5f)), 15, 0.01f);
    }
  EXPECT_NEAR(t.intensity({0, 0, 1}), 100, 0.01f);
  EXPECT_EQ(t.intensity({0, 0, -1}), 0) << "above the last angle";
}

TEST(Lm63, KnowsTheOtherSymmetriesOfTypeC) {
  const IntensityTable halves = lm63(header("IESNA91", "2 3", "1") + "0 90\n0 90 180\n10 10\n20 30\n40 50\n");
  EXPECT_NEAR(halves.intensity(direction_c(270, 90)), 30, 0.01f);
  EXPECT_NEAR(halves.intensity(direction_c(180, 90)), 50, 0.01f);
  const IntensityTable other = lm63(header("IESNA91", "2 3", "1") + "0 90\n90 180 270\n10 10\n20 30\n40 50\n");
  EXPECT_NEAR(other.intensity(direction_c(0, 90)), 30, 0.01f);
  EXPECT_NEAR(other.intensity(direction_c(90, 90)), 10, 0.01f);
  EXPECT_NEAR(other.intensity(direction_c(315, 90)), 40, 0.01f);
  const IntensityTable open = lm63(header("IESNA91", "2 4", "1") + "0 90\n0 90 180 270\n1 1\n2 3\n4 5\n6 7\n");
  EXPECT_NEAR(open.intensity(direction_c(315, 90)), 4, 0.01f);
  const IntensityTable round = lm63(header("IESNA91", "2 1", "1") + "0 90\n0\n5 9\n");
  EXPECT_NEAR(round.intensity(direction_c(200, 45)), 7, 0.01f);
  EXPECT_THROW(lm63(header("IESNA91", "2 2", "1") + "0 90\n10 50\n1 1\n1 1\n"), Error);
}

TEST(Lm63, PlacesAnglesOfTypesAAndB) {
  const std::string body = "-30 0 60\n-20 0 40\n1 2 3\n4 5 6\n7 8 9\n";
  const IntensityTable a = lm63(header("IESNA:LM-63-1995", "3 3", "3") + body);
  EXPECT_NEAR(a.intensity(direction_a(0, 0)), 5, 0.01f);
  EXPECT_NEAR(a.intensity(direction_a(40, 59.9f)), 9, 0.02f);
  EXPECT_NEAR(a.intensity(direction_a(-10, -15)), 3, 0.01f);
  EXPECT_EQ(a.intensity(direction_a(60, 0)), 0);
  const IntensityTable b = lm63(header("IESNA:LM-63-1995", "3 3", "2") + body);
  // Of type B, the horizontal angle is the latitude towards the right, the vertical one turns up around it.
  const auto direction_b = [](float vertical, float horizontal) {
    const Vec3 d = direction_a(vertical, horizontal);
    return Vec3{d.y, d.x, d.z};
  };
  EXPECT_NEAR(b.intensity(direction_b(0, 0)), 5, 0.01f);
  EXPECT_NEAR(b.intensity(direction_b(59.9f, 40)), 9, 0.02f);
  EXPECT_NEAR(b.intensity(direction_b(-15, -10)), 3, 0.01f);
  const IntensityTable lateral = lm63(header("IESNA:LM-63-1995", "2 2", "2") + "-90 90\n0 90\n4 4\n2 2\n");
  EXPECT_NEAR(lateral.intensity(direction_b(10, -45)), 3, 0.01f);
}

TEST(Lm63, TakesTiltAndFactors) {
  const std::string numbers = "1 1000 2 2 1 1 1 0 0 0 0.5 0.9 10 0 90 0 10 20\n";
  const IntensityTable tilted = lm63("NAME\nTILT=INCLUDE\n1 3 -90 0 90 0.8 0.95 0.7\n" + numbers);
  EXPECT_NEAR(tilted.intensity({0, 0, 1}), 10 * 2 * 0.5 * 0.9, 1e-3);
  EXPECT_NEAR(tilted.tilt_factor({0, -1, 0}), 0.95, 1e-6) << "down";
  EXPECT_NEAR(tilted.tilt_factor({std::sqrt(0.5f), -std::sqrt(0.5f), 0}), (0.95 + 0.7) / 2, 1e-6);
  EXPECT_NEAR(tilted.tilt_factor({0, 0, -1}), 0.7, 1e-6) << "level";
  EXPECT_NEAR(tilted.tilt_factor({0, 1, 0}), 0.7, 1e-6) << "beyond the last angle";
  EXPECT_EQ(lm63("NAME\nTILT=NONE\n" + numbers).tilt_factor({0, 0, -1}), 1);
  EXPECT_THROW(lm63("NAME\nTILT=INCLUDE\n1 2 90 0 1 1\n" + numbers), Error);
  EXPECT_THROW(lm63("NAME\nTILT=INCLUDE\n1 2 0 90 1 -1\n" + numbers), Error);
  EXPECT_NEAR(lm63("IES:LM-63-2019\nTILT=NONE\n" + numbers).intensity({0, 0, 1}), 10 * 2 * 0.5, 1e-3)
      << "the second factor is a code since 2019";
}

TEST(Lm63, SkipsAByteOrderMark) {
  const std::string text = "IES:LM-63-2019\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 0.5 1\n0 90\n0\n10 20\n";
  EXPECT_NEAR(lm63("\xef\xbb\xbf" + text).intensity({0, 0, 1}), 10, 1e-4) << "the edition is that behind the mark";
}

TEST(Lm63, TakesTiltInAnyCase) {
  const std::string numbers = "1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n10 20\n";
  for (const char* line : {"TILT=NONE", "Tilt=None", "tilt=none"})
    EXPECT_NEAR(lm63(std::string("IESNA91\n") + line + "\n" + numbers).intensity({0, 0, 1}), 10, 1e-4) << line;
  EXPECT_NEAR(lm63("IESNA91\ntilt=Include\n1 1 0 0.5\n" + numbers).tilt_factor({0, -1, 0}), 0.5, 1e-6);
}

TEST(Lm63, TakesAnglesThatRoundingMovesBeyondTheirRange) {
  const auto flux = [](const std::string& counts, const std::string& numbers) {
    return lm63("IESNA91\nTILT=NONE\n1 -1 1 " + counts + " 1 2 0 0 0\n1 1 1\n" + numbers).integral();
  };
  EXPECT_NEAR(flux("3 1", "-0.005 0 90\n0\n100 100 100\n"), 100 * 2 * M_PI, 0.01);
  EXPECT_NEAR(flux("4 1", "0 90 180 180.005\n0\n100 100 100 100\n"), 100 * 4 * M_PI, 0.01);
  EXPECT_NEAR(flux("3 1", "-0.005 90 180.005\n0\n100 100 100\n"), 100 * 4 * M_PI, 0.01);
  EXPECT_NEAR(flux("2 3", "0 180\n0 90 90.005\n100 100 100 100 100 100\n"), 100 * 4 * M_PI, 0.01);
  EXPECT_NEAR(flux("2 3", "0 180\n-0.005 0 180\n1 1 100 100 100 100\n"), 100 * 4 * M_PI, 0.01)
      << "the angle that was not moved counts";
  EXPECT_NEAR(flux("2 3", "0 180\n0.004 180 359.994\n100 100 100 100 100 100\n"), 100 * 4 * M_PI, 0.001);
  EXPECT_THROW(flux("3 1", "-0.02 0 90\n0\n100 100 100\n"), Error);
}

/// The text of a EULUMDAT file with 8 C planes 45 degrees apart, and the angles 0, 90 and 180.
std::string eulumdat(int symmetry, int rows) {
  std::string text =
      "Maker\r\n1\r\n" + std::to_string(symmetry) + "\r\n8\r\n45\r\n3\r\n90\r\nreport\r\nname\r\n1\r\nf\r\nd\r\n";
  for (int i = 0; i < 11; ++i) text += "100\r\n";
  text += "1,0\r\n0\r\n1\r\n1\r\nLED\r\n2000\r\nwhite\r\n80\r\n25\r\n";
  for (int i = 0; i < 10; ++i) text += "0.5\r\n";
  for (int i = 0; i < 8; ++i) text += std::to_string(45 * i) + "\r\n";
  text += "0\r\n90\r\n180\r\n";
  for (int i = 0; i < rows; ++i) text += "100\r\n" + std::to_string(10 * (i + 1)) + "\r\n0\r\n";
  return text;
}

TEST(Eulumdat, KnowsEverySymmetry) {
  struct Case {
    int symmetry, rows;
    float at[8];  ///< at the angle 90 of each C plane, cd for 2000 lm
  };
  for (const Case& c : {Case{0, 8, {20, 40, 60, 80, 100, 120, 140, 160}}, Case{1, 1, {20, 20, 20, 20, 20, 20, 20, 20}},
                        Case{2, 5, {20, 40, 60, 80, 100, 80, 60, 40}}, Case{3, 5, {60, 80, 100, 80, 60, 40, 20, 40}},
                        Case{4, 3, {20, 40, 60, 40, 20, 40, 60, 40}}}) {
    const IntensityTable t = parse_eulumdat(eulumdat(c.symmetry, c.rows), "lamp.ldt").table;
    for (int i = 0; i < 8; ++i)
      EXPECT_NEAR(t.intensity(direction_c(45 * i, 90)), c.at[i], 0.01f) << "symmetry " << c.symmetry << ", plane " << i;
    EXPECT_NEAR(t.intensity({0, 0, 1}), 200, 0.01f);
  }
}

TEST(Eulumdat, AcceptsBlanksOnlyWhereNoNumberIsNeeded) {
  std::vector<std::string> lines;
  std::istringstream text(eulumdat(4, 3));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  // Type of luminaire, distances, sizes and shares, tilt, number and power of lamps, direct ratios; from 1.
  std::set<std::size_t> optional = {2, 5, 7, 25, 27, 32};
  for (std::size_t i = 13; i <= 23; ++i) optional.insert(i);
  for (std::size_t i = 33; i <= 42; ++i) optional.insert(i);
  const std::set<std::size_t> texts = {1, 8, 9, 10, 11, 12, 28, 30, 31};
  const auto with = [&](const std::set<std::size_t>& changed, const char* word) {
    std::string out;
    for (std::size_t i = 1; i <= lines.size(); ++i) out += changed.contains(i) ? word : lines[i - 1] + "\n";
    return out;
  };
  for (const char* blank : {"\n", " \t\r\n"}) {
    const IntensityTable t = parse_eulumdat(with(optional, blank), "a.ldt").table;
    EXPECT_NEAR(t.intensity(direction_c(90, 90)), 60, 0.01f);
    for (std::size_t i = 1; i <= lines.size(); ++i) {
      if (optional.contains(i) || texts.contains(i)) continue;
      EXPECT_THROW(parse_eulumdat(with({i}, blank), "a.ldt"), Error) << "line " << i;
    }
  }
  for (const std::size_t i : optional) EXPECT_THROW(parse_eulumdat(with({i}, "x\n"), "a.ldt"), Error) << "line " << i;
}

TEST(PhotometricFiles, EndInAnErrorWhereverTheyAreCut) {
  const std::string ies =
      "IESNA:LM-63-2002\n[MANUFAC] M\nTILT=INCLUDE\n1 2\n0 90\n1 0.9\n1 1000 1 3 3 1 2 0 0 0\n1 1 10\n0 45 "
      "90\n0 45 90\n100 80 60\n100 50 40\n100 20 10\n";
  const std::string ldt = eulumdat(4, 3);
  ASSERT_NO_THROW(parse_lm63(ies, "a.ies"));
  ASSERT_NO_THROW(parse_eulumdat(ldt, "a.ldt"));
  // Many files end without a line end, so that digits missing from the last number cannot be noticed.
  const std::size_t last_of_ies = ies.find_last_of(' '), last_of_ldt = ldt.find_last_of('0');
  for (std::size_t size = 0; size <= last_of_ies; ++size)
    EXPECT_THROW(parse_lm63(ies.substr(0, size), "a.ies"), Error) << ies.substr(0, size);
  for (std::size_t size = 0; size <= last_of_ldt; ++size)
    EXPECT_THROW(parse_eulumdat(ldt.substr(0, size), "a.ldt"), Error) << ldt.substr(0, size);
}

TEST(PhotometricFiles, MayEndWithoutALineEnd) {
  const std::string ies = "IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n10 20";
  const std::string ldt = eulumdat(4, 3);
  for (const char* end : {"", " ", "\n", "\r\n\r\n", "\x1a"}) {
    EXPECT_NEAR(lm63(ies + end).intensity({0, 1, 0}), 20, 1e-4);
    const IntensityTable t = parse_eulumdat(ldt.substr(0, ldt.find_last_of('0') + 1) + end, "a.ldt").table;
    EXPECT_NEAR(t.intensity({0, 0, 1}), 200, 0.01f);
  }
}

TEST(PhotometricFiles, RefuseNumbersThatAreLeftOver) {
  const std::string ies = "IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n10 20\n";
  EXPECT_THROW(lm63(ies + "30\n"), Error);
  EXPECT_THROW(lm63(ies + "\n\n+1e400\n"), Error) << "too large, yet a number";
  EXPECT_NO_THROW(lm63(ies + "made by a program\n"));
  EXPECT_THROW(parse_eulumdat(eulumdat(1, 2), "a.ldt"), Error) << "two planes for symmetry 1";
}

TEST(PhotometricFiles, ErrorsNameThePlace) {
  const auto message = [](const std::string& text) {
    try {
      parse_lm63(text, "a.ies");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(message("IESNA91\nTILT=NONE\n1 -1 1 2 1\n1 x 0 0 0\n"), HasSubstr("a.ies:4: 'x' is no number"));
  EXPECT_THAT(message("IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n1 1\n7 8\n"),
              HasSubstr("a.ies:7: '7' stands behind the intensities"));
  EXPECT_THAT(message("IESNA91\nTILT=NONE\n1 -1 1 99999 99999 1 2 0 0 0 1 1 1\n0 90\n"), HasSubstr("the file ends"));
  EXPECT_THAT(message("IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n90 0\n0\n1 1\n"), HasSubstr("out of order"));
  EXPECT_THAT(message("IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n1 -1\n"), HasSubstr("-1 cd"));
}

/// A luminaire of I = 1000 cos(gamma) cd, in steps of a degree.
std::string cosine_lamp() {
  std::string angles, values;
  for (int i = 0; i <= 90; ++i) {
    angles += std::to_string(i) + "\n";
    values += std::to_string(1000 * std::cos(i * M_PI / 180)) + "\n";
  }
  return "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 91 1 1 2 0 0 0 1 1 1\n" + angles + "0\n" + values;
}

Emission dark_emission() {
  Emission out;
  out.radiance.value = RGB(0.0f);
  return out;
}

class LuminaireScene : public FolderTest {
 protected:
  LuminaireScene() { write("lamp.ies", cosine_lamp()); }
};

TEST_F(LuminaireScene, LightsThePlaneBelowByTheCosineLaw) {
  SceneDescription d = load_scene("builtin:cornell");
  d.lights.clear();
  d.emissions.assign(d.emissions.size(), dark_emission());
  SceneChanges changes;
  changes.luminaires = {(folder_ / "lamp.ies").string() + "@0.25,3,0.5"};
  change_scene(d, changes, loading_budget());
  const Scene scene(std::move(d));
  EXPECT_NEAR(luminance(scene.source_powers().back()) * kLuminousEfficacy, 1000 * M_PI, 1000 * M_PI * 2e-4) << "lm";
  for (const float x : {0.25f, 1.0f, 3.0f}) {
    const LightSample s = sample_light(scene, {x, 0, 0.5f}, 0.5f, {0.5f, 0.5f});
    const double squared = 9 + (x - 0.25) * (x - 0.25);
    // I cos / d^2 with I = I0 cos, and cos = h / d.
    const double expected = 1000 * 9 / (squared * squared);
    EXPECT_NEAR(luminance(s.radiance) * s.direction.y * kLuminousEfficacy, expected, expected * 2e-4);
  }
  RGB flux;
  double upward = 0;
  for (int i = 0; i < 1024; ++i) {
    const auto u = static_cast<float>(i) / 1024;
    const EmittedPhoton photon = sample_emission(scene, 0.5f, {0.5f, 0.5f}, {0.5f, u});
    flux += photon.flux / 1024;
    upward += photon.direction.y > 1e-6f;
  }
  EXPECT_NEAR(luminance(flux) * kLuminousEfficacy, 1000 * M_PI, 1000 * M_PI * 2e-4) << "all photons together";
  EXPECT_EQ(upward, 0);
}

TEST_F(LuminaireScene, IsAsBrightAsItsTiltSays) {
  std::ofstream(folder_ / "tilt.ies")
      << "IESNA91\nTILT=INCLUDE\n1 3 0 90 180 1 0.8 0.5\n1 -1 1 3 1 1 2 0 0 0 1 1 1\n0 90 "
         "180\n0\n1000 1000 1000\n";
  const std::string lamp = (folder_ / "tilt.ies").string() + "@0.5,0.5,0.5,";
  const auto flux = [&](const std::string& aim, bool z_up) {
    SceneDescription d = load_scene("builtin:cornell");
    d.lights = {luminaire_of_text(lamp + aim)};
    d.emissions.assign(d.emissions.size(), dark_emission());
    SceneChanges changes;
    changes.z_up = z_up;
    change_scene(d, changes, loading_budget());
    const Scene scene(std::move(d));
    RGB photons;
    for (int i = 0; i < 64; ++i)
      photons += sample_emission(scene, 0.5f, {0.5f, 0.5f}, {0.5f, (static_cast<float>(i) + 0.5f) / 64}).flux / 64;
    const double candela = luminance(scene.lights()[0].intensity) * table_intensity(scene.lights()[0], {1, 0, 0});
    EXPECT_NEAR(luminance(scene.source_powers().back()) / candela, 4 * M_PI, 1e-3);
    EXPECT_NEAR(luminance(photons) / candela, 4 * M_PI, 1e-3);
    return candela * kLuminousEfficacy;
  };
  EXPECT_NEAR(flux("0,-1,0", false), 1000, 0.1);
  EXPECT_NEAR(flux("1,0,0", false), 800, 0.1);
  EXPECT_NEAR(flux("0,1,0", false), 500, 0.1);
  EXPECT_NEAR(flux("0,0,-1", true), 1000, 0.1) << "down where z is up";
}

TEST_F(LuminaireScene, TakesAimAndTurnFromTheText) {
  const std::string file = (folder_ / "lamp.ies").string();
  const Light light = luminaire_of_text(file + "@1,2,3,0,0,-2,90");
  EXPECT_LT(length(light.position - Vec3{1, 2, 3}), 1e-6f);
  EXPECT_LT(length(light.direction - Vec3{0, 0, -1}), 1e-6f);
  EXPECT_LT(length(light.right - Vec3{0, 1, 0}), 1e-6f);
  EXPECT_TRUE(is_luminaire_text("a@b/LAMP.IES@1,2,3"));
  EXPECT_FALSE(is_luminaire_text("lamp,off"));
  for (const char* bad : {"@1,2", "@1,2,x", "@1,2,3,0,0,0", "@1,2,3,", "@"})
    EXPECT_THROW(luminaire_of_text(file + bad), Error) << bad;
  EXPECT_THROW(luminaire_of_text("missing.ies@0,0,0"), Error);
}

TEST_F(LuminaireScene, IsAGoniometricLightOfPbrt) {
  std::ofstream(folder_ / "a.pbrt") << "WorldBegin Translate 1 2 3 LightSource \"goniometric\" \"string filename\" "
                                       "\"lamp.ies\" \"float scale\" 2 Shape \"sphere\"\n";
  const SceneDescription d = load_scene((folder_ / "a.pbrt").string());
  ASSERT_EQ(d.lights.size(), 1u);
  EXPECT_EQ(d.lights[0].kind, LightKind::luminaire);
  EXPECT_NEAR(d.lights[0].intensity.g * kLuminousEfficacy, 2, 1e-5f);
  EXPECT_LT(length(d.lights[0].position - Vec3{1, 2, 3}), 1e-6f);
  EXPECT_LT(length(d.lights[0].direction - Vec3{0, 0, -1}), 1e-6f);
  std::ofstream(folder_ / "a.pbrt") << "WorldBegin LightSource \"goniometric\" \"string filename\" \"none.ies\" Shape "
                                       "\"sphere\"\n";
  try {
    load_scene((folder_ / "a.pbrt").string());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.pbrt:1"));
  }
}

TEST_F(LuminaireScene, IsMirroredWhereItsPlaceIs) {
  write("lamp.ies",
        header("IESNA:LM-63-2002", "3 5", "1") + "0 45 90\n0 90 180 270 360\n9 1 2\n9 3 4\n9 5 6\n9 7 8\n9 1 2\n");
  for (const char* type : {"2", "3"})
    write(std::string("lamp") + type + ".ies",
          header("IESNA:LM-63-2002", "3 3", type) + "-90 0 90\n-90 0 90\n1 2 3\n4 5 6\n7 8 9\n");
  const auto light_of = [&](const std::string& suffix, const std::string& text) {
    write("a" + suffix, text);
    return load_scene((folder_ / ("a" + suffix)).string()).lights.at(0);
  };
  for (const std::string file : {"lamp.ies", "lamp2.ies", "lamp3.ies"}) {
    const auto by_pbrt = [&](const std::string& scale) {
      return light_of(".pbrt", "WorldBegin Rotate 50 1 2 3 Scale " + scale +
                                   " LightSource \"goniometric\" \"string filename\" \"" + file +
                                   "\" Rotate -20 3 1 1 Shape \"sphere\"\n");
    };
    const auto by_gltf = [&](const std::vector<float>& scale) {
      GltfFile gltf;
      gltf.add("nodes", {{"mesh", gltf.add_triangle()}});
      gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
          {{"type", "point"}, {"extras", {{"luminaire", file}}}}};
      const int lamp = gltf.add(
          "nodes", {{"rotation", {0.5, 0.1, 0.7, 0.5}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
      gltf.add("nodes", {{"scale", scale}, {"children", {lamp}}});
      return light_of(".glb", gltf.glb());
    };
    // pbrt mirrors the lamp about its own x, glTF about that of the world.
    const Light plain = by_pbrt("1 1 1"), mirrored = by_pbrt("-1 1 1");
    const Light hung = by_gltf({1, 1, 1}), hung_mirrored = by_gltf({-1, 1, 1});
    const Frame axes = luminaire_axes(plain.right, plain.direction);
    for (const Vec3 d :
         {Vec3{0.3f, 0.5f, 0.6f}, Vec3{-0.4f, 0.6f, 0.5f}, Vec3{0.2f, -0.7f, 0.4f}, Vec3{0, 0.4f, 0.9f}}) {
      const Vec3 across = normalize(axes.to_world(d)), back = normalize(axes.to_world({-d.x, d.y, d.z}));
      EXPECT_GT(table_intensity(plain, across), 0.5f);
      EXPECT_NEAR(table_intensity(mirrored, back), table_intensity(plain, across), 1e-3f) << file;
      const Vec3 there = normalize(luminaire_axes(hung.right, hung.direction).to_world(d));
      EXPECT_NEAR(table_intensity(hung_mirrored, {-there.x, there.y, there.z}), table_intensity(hung, there), 1e-3f)
          << file << " in glTF";
    }
  }
}

}  // namespace
}  // namespace glowworm
