// Luminaires with openings, melanopic light and reports, as the program gives them.
#include <fmt/format.h>

#include <cmath>

#include "apps/program.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// A luminaire of 1000 cos(gamma) cd with a luminous opening. @param sizes width, length and height in m
std::string lamp_with(const std::string& sizes) {
  std::string angles, values;
  for (int i = 0; i <= 90; i += 2) {
    angles += std::to_string(i) + " ";
    values += std::to_string(1000 * std::cos(i * M_PI / 180)) + "\n";
  }
  return "IESNA:LM-63-2002\n[LUMINAIRE] Panel\nTILT=NONE\n1 -1 1 46 1 1 2 " + sizes + " 1 1 25\n" + angles + "0\n" +
         values;
}

class LuminaireTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    // A grey room of 4 x 3 x 4 m, open to nothing.
    write(
        "room.obj",
        "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -2 3 -2\nv 2 3 -2\nv 2 3 2\nv -2 3 2\no floor\nf 4 3 2 1\no shell\n"
        "f 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 4 1 5 8\nf 2 3 7 6\n");
    write("panel.ies", lamp_with("0.6 0.6 0"));
    write("point.ies", lamp_with("0 0 0"));
    write("tube.ies", lamp_with("0.01 1.2 0"));
    write("black.pbrt",
          "WorldBegin Material \"diffuse\" \"rgb reflectance\" [0 0 0] Shape \"trianglemesh\" \"point3 P\" [-2 0 -2 2 "
          "0 -2 "
          "2 0 2 -2 0 2] \"integer indices\" [0 2 1 0 3 2]\n");
    write("up.pts", "0 0.8 0  0 1 0\n0.9 0.8 -0.7  0 1 0\n");
  }

  /// Illuminance at the sensors of up.pts.
  std::vector<double> measured(const std::vector<std::string>& more, const std::string& scene = "room.obj") {
    std::vector<std::string> words = {"measure", scene, "--points", "up.pts", "-o", "a.json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<double> lux;
    const nlohmann::json table = read_json("a.json");
    for (const nlohmann::json& point : table.at("points")) lux.push_back(point.at("E_lx"));
    return lux;
  }
};
using SlowLuminaireTest = LuminaireTest;

TEST_F(LuminaireTest, LightsNearPlacesByItsOpening) {
  for (const double distance : {0.5, 1.0, 2.0}) {
    const double a = std::atan(0.6 / distance), lux = 1000 * (a + std::sin(a) * std::cos(a)) / (1.2 * distance);
    const std::string lamp = fmt::format("tube.ies@0,{},0", 0.8 + distance);
    for (const std::string integrator : {"gather", "path"})
      EXPECT_NEAR(measured({"--light", lamp, "--integrator", integrator, "--samples",
                            integrator == "path" ? "16384" : "256", "--photons", "1000", "--gather", "16"},
                           "black.pbrt")[0],
                  lux, 0.01 * lux)
          << integrator << ' ' << distance;
    const std::vector<double> point =
        measured({"--light", lamp, "--lamp-openings", "off", "--samples", "2", "--integrator", "path"}, "black.pbrt");
    EXPECT_NEAR(point[0], 1000 / (distance * distance), 0.01 * 1000 / (distance * distance)) << "a point";
  }
}

TEST_F(SlowLuminaireTest, LightsRoomsAlikeByEveryIntegrator) {
  // In the ceiling's plane.
  const std::vector<double> path =
      measured({"--light", "panel.ies@0.2,3,0.1", "--integrator", "path", "--samples", "4000"});
  const std::vector<double> gather = measured({"--light", "panel.ies@0.2,3,0.1", "--integrator", "gather", "--samples",
                                               "12", "--photons", "30k", "--gather", "64"});
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_NEAR(gather[i], path[i], 0.03 * path[i]);
  // It stops no light: all of the room that a point lights, it lights, too.
  const std::vector<double> point =
      measured({"--light", "point.ies@0.2,2.99,0.1", "--integrator", "path", "--samples", "4000"});
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_NEAR(point[i], path[i], 0.05 * path[i]);
}

TEST_F(LuminaireTest, HasFiguresAndAPolarCurve) {
  const Outcome outcome = run({"info", "panel.ies", "-o", "curve.png"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* part : {"luminaire  Panel", "lm, 100% of it down", "1000 cd at C 0, gamma 0", "around the axis",
                           "rectangle, 0.6 x 0.6", "efficacy   125.7 lm/W"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
  EXPECT_GT(read(path("curve.png")).size(), 2000u);
  EXPECT_NEAR(nlohmann::json::parse(run({"info", "panel.ies", "--json"}).out).at("flux_lm").get<double>(), 1000 * M_PI,
              2);
  EXPECT_NE(run({"info", "room.obj", "-o", "curve.png"}).status, 0);
}

TEST_F(LuminaireTest, GivesMelanopicLightByTheSpectrum) {
  std::vector<std::string> words = {
      "measure",   "room.obj", "--points", "up.pts", "--light",     "panel.ies@0,2.9,0", "--integrator", "path",
      "--samples", "16",       "-o",       "a.json", "--melanopic", "--spectrum",        "panel.ies=A"};
  const Outcome outcome = run(words);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json table = read_json("a.json");
  for (const nlohmann::json& point : table.at("points"))
    EXPECT_NEAR(point.at("melanopic_EDI_lx").get<double>(), 0.4957 * point.at("E_lx").get<double>(),
                1e-3 * point.at("E_lx").get<double>());
  words.back() = "desk=A";
  EXPECT_TRUE(refused(run(words), {"desk", "panel.ies"}, 2));
}

TEST_F(LuminaireTest, WritesAReportOfZones) {
  const Outcome outcome =
      run({"measure", "room.obj", "--zone", "desk=-1,0.8,-1,1,0.8,1", "--zone", "ground=floor,1", "--light",
           "panel.ies@0.5,2.9,0,0,-1,0,0,maintenance=0.8", "--light", "panel.ies@-0.5,2.9,0,maintenance=0.8",
           "--integrator", "path", "--samples", "64", "--report", "room.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string page = read(path("room.html"));
  // Two of 0.8 * 1000 pi lm and 25 W.
  for (const char* part :
       {"desk", "ground", "panel.ies", "Panel, factor 0.8</td>", "<td>2</td><td>2513</td><td>25.0</td><td>101</td>",
        "<td>50.0</td>", "<td>panel.ies</td><td>502", "0.5, 2.9, 0; -0.5, 2.9, 0", "<svg", "Glowworm"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_NE(run({"measure", "room.obj", "--grid", "y=0.8,1", "--report", "room.html"}).status, 0) << "without zones";
}

}  // namespace
}  // namespace glowworm
