// glowworm measure: tables of irradiance at sensors.
#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "apps/program.h"

namespace glowworm {
namespace {

/// A luminaire of 1000 cos(gamma) cd.
std::string cosine_lamp() {
  std::string angles, values;
  for (int i = 0; i <= 90; ++i) {
    angles += std::to_string(i) + " ";
    values += std::to_string(1000 * std::cos(i * M_PI / 180)) + "\n";
  }
  return "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 91 1 1 2 0 0 0 1 1 1\n" + angles + "0\n" + values;
}

/// The last line of a table, as numbers.
std::vector<double> last_row(const std::string& csv) {
  const std::size_t begin = csv.rfind('\n', csv.size() - 2) + 1;
  std::stringstream line(csv.substr(begin));
  std::vector<double> out;
  for (std::string word; std::getline(line, word, ',');) out.push_back(std::stod(word));
  return out;
}

class MeasureTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("a.pbrt",
          "LookAt 0 1 3 0 0 0 0 1 0 WorldBegin Material \"diffuse\" \"rgb reflectance\" [0 0 0] Shape \"trianglemesh\" "
          "\"point3 P\" [-2 0 -2 2 0 -2 2 0 2 -2 0 2] \"integer indices\" [0 2 1 0 3 2]\n");
    write("lamp.ies", cosine_lamp());
    write("a.pts", "# below, and aside\n0 0 0  0 1 0\n1.5 0 1.5  0 3 0\n");
  }
};
using SlowMeasureTest = MeasureTest;

TEST_F(MeasureTest, MeasuresALuminaireByTheCosineLaw) {
  const Outcome outcome = run({"measure", "a.pbrt", "--points", "a.pts", "--light", "lamp.ies@0,3,0", "--samples", "2",
                               "--photons", "1000", "-o", "a.csv", "-o", "a.json", "-o", "a.ply", "-o", "a.vtk"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("wrote a.vtk"));
  const std::vector<double> row = last_row(read(path("a.csv")));
  ASSERT_EQ(row.size(), 12u);
  // CIE 171:2006, 5.2: I0 h^2 / d^4.
  EXPECT_NEAR(row[10], 1000 * 9 / (13.5 * 13.5), 0.05);
  EXPECT_NEAR(row[6], row[10] / 179, 1e-4);
  EXPECT_LT(row[11], 1e-4);
  EXPECT_NEAR(read_json("a.json").at("points").at(0).at("E_lx").get<double>(), 1000 / 9.0, 0.05);
}

// A quarter of a cylinder of one sheet is no lens: less light than without it reaches the floor.
TEST_F(MeasureTest, PassesLightThroughCurvedSheetsOfGlassStraight) {
  write("m.mtl", "newmtl floor\nKd 0 0 0\nnewmtl glass\nKd 0 0 0\nNi 1.5\nillum 7\n");
  std::string obj = "mtllib m.mtl\nusemtl floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 4 3 2 1\nusemtl glass\n";
  constexpr int kSteps = 8;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = M_PI / 4 + i * M_PI / 2 / kSteps, x = std::cos(angle), y = 0.5 + std::sin(angle);
    for (const int z : {-1, 1}) obj += fmt::format("v {} {} {}\n", x, y, z);
    if (i > 0) obj += fmt::format("f {} {} {} {}\n", 2 * i + 3, 2 * i + 4, 2 * i + 6, 2 * i + 5);
  }
  write("sheet.obj", obj);
  const Outcome outcome = run({"measure", "sheet.obj", "--points", "a.pts", "--light", "lamp.ies@0,3,0", "--samples",
                               "4", "--photons", "20000", "-o", "a.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const double lux = read_json("a.json").at("points").at(0).at("E_lx").get<double>();
  EXPECT_LT(lux, 1000 / 9.0);
  // At normal incidence, both sides of a pane reflect 0.04.
  EXPECT_NEAR(lux, 1000 / 9.0 * 0.96 / 1.04, 1);
}

TEST_F(MeasureTest, StopsAtTheErrorAskedFor) {
  const Outcome outcome = run({"measure", "builtin:cornell", "--grid", "y=0.5,0.25", "--photons", "20k", "--gather",
                               "16", "--noise", "5%", "-o", "-", "--stats", "s.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<double> row = last_row(outcome.out);
  ASSERT_EQ(row.size(), 12u);
  EXPECT_GT(row[10], 0);
  EXPECT_GT(row[11], 0);
  EXPECT_LT(row[11], 0.5);
  const nlohmann::json statistics = read_json("s.json");
  EXPECT_EQ(statistics.at("ending"), "noise_reached");
  EXPECT_EQ(statistics.at("settings").at("noise_target"), 0.05);
  EXPECT_GT(statistics.at("time_s").at("total"), statistics.at("time_s").at("load"));
}

TEST_F(MeasureTest, GivesTheCandelaOfAGltfFileBack) {
  // A black triangle below a light of 1000 cd.
  write("a.gltf",
        R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}], "extensionsUsed": ["KHR_lights_punctual"],
    "nodes": [{"mesh": 0}, {"translation": [0, 1, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1000}]}},
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, -1, 0], "max": [1, 0, 1]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgL8AAIA/"}]})");
  write("a.pts", "0 0 0  0 1 0\n2 0 0  0 1 0\n");
  const Outcome outcome =
      run({"measure", "a.gltf", "--points", "a.pts", "--samples", "2", "--photons", "1000", "-o", "a.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json points = read_json("a.json").at("points");
  EXPECT_NEAR(points.at(0).at("E_lx").get<double>(), 1000, 1);
  EXPECT_NEAR(points.at(1).at("E_lx").get<double>(), 1000 / (5 * std::sqrt(5.0)), 0.1);
}

TEST_F(MeasureTest, MeasuresNothingWithoutLight) {
  const Outcome outcome =
      run({"measure", "a.pbrt", "--points", "a.pts", "--samples", "2", "--photons", "1000", "-o", "-"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("warning: the scene has no light"));
  EXPECT_EQ(last_row(outcome.out)[10], 0);
}

/// A room with y up, or with z up and its corner at a place.
std::string room_of(bool z_up, double east = 0, double north = 0) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    const int x = i & 1 ? 6 : 0, up = i & 2 ? 3 : 0, back = i & 4 ? 4 : 0;
    text += "v " + std::to_string(east + x) + " " + std::to_string(z_up ? north + back : up) + " " +
            std::to_string(z_up ? up : -back) + "\n";
  }
  return text + "f 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\nf 1 5 7 3\nf 2 4 8 6\n";
}

TEST_F(MeasureTest, TurnsSensorsAndLampsWithTheUpAxis) {
  write("z.obj", room_of(true));
  write("y.obj", room_of(false));
  write("z.pts", "3 1 0.75 0 0 1\n1 2 1 1 0 0\n");
  write("y.pts", "3 0.75 -1 0 1 0\n1 1 -2 1 0 0\n");
  const auto measure = [&](const std::string& scene, const std::string& lamp, std::vector<std::string> more) {
    more.insert(more.begin(), {"measure", scene, "--light", "lamp.ies@" + lamp, "--samples", "2", "--photons", "1000",
                               "--gather", "16", "-o", "-"});
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out.substr(outcome.out.find("relative_error\n"));
  };
  const std::vector<double> z = last_row(measure("z.obj", "3,2,2.5,0,0,-1", {"--up", "z", "--points", "z.pts"}));
  const std::vector<double> y = last_row(measure("y.obj", "3,2.5,-2,0,-1,0", {"--points", "y.pts"}));
  EXPECT_EQ(std::vector<double>(z.begin(), z.begin() + 6), (std::vector<double>{1, 2, 1, 1, 0, 0}));
  EXPECT_GT(z[10], 10);
  EXPECT_EQ(std::vector<double>(z.begin() + 6, z.end()), std::vector<double>(y.begin() + 6, y.end()));
  // The last cell of a plane is another corner: -y where z is up, and that is z.
  const std::vector<double> level = last_row(measure("z.obj", "3,2,2.5", {"--up", "z", "--grid", "z=0.75,1"}));
  EXPECT_EQ(std::vector<double>(level.begin(), level.begin() + 6), (std::vector<double>{5.5, 3.5, 0.75, 0, 0, 1}));
  EXPECT_GT(level[10], 10);
  const Outcome info = run({"info", "z.obj", "--up", "z", "--json"});
  ASSERT_EQ(info.status, 0) << info.err;
  EXPECT_EQ(nlohmann::json::parse(info.out).at("bounds_m"), nlohmann::json({{0, 0, 0}, {6, 4, 3}}));
}

/// Coordinates of a map, whose millimetres floats do not hold, and z up: places of all options and of all results.
TEST_F(SlowMeasureTest, KeepsTheFilesCoordinatesFarFromTheOrigin) {
  write("near.obj", room_of(true, -3.002, -2.044));
  write("far.obj", room_of(true, 512345.123, 5412345.456));
  write("near.pts", "-1 -1 0.75 0 0 1\n-1.002 1.4 1 1 0 0\n");
  write("far.pts", "512347.125 5412346.5 0.75 0 0 1\n512347.123 5412348.9 1 1 0 0\n");
  const auto measure = [&](const std::string& scene, const std::string& lamp, std::vector<std::string> more) {
    more.insert(more.begin(), {"measure", scene, "--up", "z", "--light", "lamp.ies@" + lamp, "--samples", "2",
                               "--photons", "1000", "--gather", "16", "-o", "-"});
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return last_row(outcome.out.substr(outcome.out.find("relative_error\n")));
  };
  const std::string near_lamp = "0.25,0,2.5", far_lamp = "512348.375,5412347.5,2.5";
  const auto expect_same = [](const std::vector<double>& far, const std::vector<double>& near) {
    EXPECT_NEAR(far.at(0), near.at(0) + 512348.125, 1e-4);
    EXPECT_NEAR(far.at(1), near.at(1) + 5412347.5, 1e-4);
    EXPECT_GT(far.at(10), 1);
    EXPECT_EQ(std::vector<double>(far.begin() + 2, far.end()), std::vector<double>(near.begin() + 2, near.end()));
  };
  expect_same(measure("far.obj", far_lamp, {"--points", "far.pts"}),
              measure("near.obj", near_lamp, {"--points", "near.pts"}));
  expect_same(measure("far.obj", far_lamp, {"--grid", "-y=5412347.9,1"}),
              measure("near.obj", near_lamp, {"--grid", "-y=0.4,1"}));
  const auto picture = [&](const std::string& scene, const std::string& lamp, const std::string& option,
                           const std::string& places) {
    const Outcome outcome = run({"render", scene, "--up", "z", "--light", "lamp.ies@" + lamp, "--size", "8x8",
                                 "--samples", "1", "--photons", "1000", option, places, "-o", scene + ".exr"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  };
  picture("far.obj", far_lamp, "--look-at", "512346.126,5412346.5,1,512349.125,5412347.625,1");
  picture("near.obj", near_lamp, "--look-at", "-1.999,-1,1,1,0.125,1");
  EXPECT_EQ(run({"compare", "far.obj.exr", "near.obj.exr", "--limit", "0"}).status, 0);
  picture("far.obj", far_lamp, "--view", "512346.126,5412346.5,1,512349.125,5412347.625,1,0,0,1");
  picture("near.obj", near_lamp, "--view", "-1.999,-1,1,1,0.125,1,0,0,1");
  EXPECT_EQ(run({"compare", "far.obj.exr", "near.obj.exr", "--limit", "0"}).status, 0);
  const Outcome info = run({"info", "far.obj", "--up", "z", "--json"});
  ASSERT_EQ(info.status, 0) << info.err;
  const nlohmann::json bounds = nlohmann::json::parse(info.out).at("bounds_m");
  const double corners[2][3] = {{512345.123, 5412345.456, 0}, {512351.123, 5412349.456, 3}};
  for (std::size_t corner : {0, 1})
    for (std::size_t axis : {0, 1, 2})
      EXPECT_NEAR(bounds.at(corner).at(axis).get<double>(), corners[corner][axis], 1e-4);
  EXPECT_THAT(info.out, testing::HasSubstr("(512348.125, 5412347.5, 0) m is subtracted"));
}

TEST_F(MeasureTest, WarnsOfWhatIsHardlyMeant) {
  write("room.obj", room_of(true));
  write("in.pts", "3 1 0.75 0 0 1\n");
  write("below.pts", "3 1 0.75 0 0 1\n3 1 -0.75 0 0 1\n");
  const auto told = [&](const std::string& points, const std::string& lamp, std::vector<std::string> more) {
    more.insert(more.begin(), {"measure", "room.obj", "--up", "z", "--points", points, "--light", "lamp.ies@" + lamp,
                               "--samples", "2", "--photons", "1000", "--gather", "16", "-o", "-"});
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  using testing::HasSubstr;
  EXPECT_THAT(told("in.pts", "3,2,2.5", {}), testing::Not(HasSubstr("warning")));
  const std::string above = told("in.pts", "3,2,3.25", {});
  EXPECT_THAT(above, HasSubstr("no sensor sees the light \"lamp.ies\" at (3, 2, 3.25)"));
  EXPECT_THAT(above, HasSubstr("1 of 1 sensors measured no light at all"));
  EXPECT_THAT(told("below.pts", "3,2,2.5", {}),
              HasSubstr("1 of 2 sensors are outside of the room, the first of them at (3, 1, -0.75)"));
  write("in.pts", "3000 1000 750 0 0 1\n");
  EXPECT_THAT(told("in.pts", "3000,2000,2500", {"--scale", "1000"}), HasSubstr("is its unit the metre?"));
}

TEST_F(MeasureTest, LightsBySkies) {
  const Outcome outcome = run({"measure", "a.pbrt", "--points", "a.pts", "--sky", "cie:12,50,135,20000", "--samples",
                               "64", "--gather", "256", "--photons", "1000", "-o", "-"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NEAR(last_row(outcome.out)[10], 20'000, 200);
}

TEST_F(MeasureTest, RefusesWithReasons) {
  const auto measure = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"measure", "a.pbrt"});
    return run(more);
  };
  EXPECT_TRUE(refused(measure({"-o", "a.csv"}), {"no sensors", "--points"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "--grid", "y=0,1", "-o", "a.csv"}), {"more than one way"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "-o", "a.txt"}), {"a.txt", ".csv"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "none.pts", "-o", "a.csv"}), {"none.pts"}));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "-o", "a.pts"}), {"a.pts"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "--samples", "1", "-o", "a.csv"}), {"--samples"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "--sky", "cie:17", "-o", "a.csv"}), {"cie:17"}, 2));
  EXPECT_TRUE(refused(measure({"--points", "a.pts", "--light", "none.ies@0,3,0", "-o", "a.csv"}), {"none.ies"}, 2));
  write("bad.pts", "0 0 0 0 0 0\n");
  EXPECT_TRUE(refused(measure({"--points", "bad.pts", "-o", "a.csv"}), {"bad.pts:1", "no length"}));
  EXPECT_EQ(names(), (std::vector<std::string>{"a.pbrt", "a.pts", "bad.pts", "lamp.ies"}));
}

}  // namespace
}  // namespace glowworm
