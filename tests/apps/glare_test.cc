// `glowworm glare`: views in, ratings out.
#include "measure/glare.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.h"

namespace glowworm {
namespace {

class GlareTest : public ProgramTest {
 protected:
  Outcome rate(const std::string& scene, const std::string& views) const {
    std::ofstream(path("views.vf")) << views;
    return run({"glare", scene, "--views", "views.vf", "-o", "g.csv", "--side", "128", "--samples", "2", "--gather",
                "4", "--photons", "2000"});
  }
};
using SlowGlareTest = GlareTest;

constexpr const char* kAtTheLamp = "rview -vta -vp 0.28 0.28 -0.5 -vd 0 0.6 1 -vu 0 1 0\n";

TEST_F(GlareTest, RatesEveryViewAndListsItsSources) {
  const Outcome outcome = rate("builtin:cornell", kAtTheLamp + std::string("# a comment\n") + kAtTheLamp);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string table = read(path("g.csv"));
  EXPECT_THAT(table, testing::HasSubstr("view,source,DGP,DGI,UGR,E_v_lx"));
  for (const char* row : {"\n1,,", "\n1,1,", "\n2,,", "\n2,1,"}) EXPECT_THAT(table, testing::HasSubstr(row));
  EXPECT_THAT(outcome.err, testing::Not(testing::HasSubstr("without size")));
}

/// The numbers of the first view of a table.
std::string first_view(const std::string& table) {
  const std::size_t begin = table.find("\n1,,") + 1;
  return table.substr(begin, table.find('\n', begin) - begin);
}

/// DGP, DGI, UGR, illuminance and background.
std::vector<double> numbers_of_view(const std::string& row) {
  std::vector<double> out;
  std::istringstream in(row.substr(row.find(",,") + 2));
  for (std::string text; std::getline(in, text, ',') && !text.empty();) out.push_back(std::stod(text));
  return out;
}

TEST_F(SlowGlareTest, PicturesOfSourcesKeepTheirLuminanceAndCanBeRated) {
  std::ofstream(path("views.vf")) << kAtTheLamp;
  std::vector<double> by_format;
  for (const char* name : {"s.hdr", "s.exr"}) {
    const Outcome outcome = run({"glare", "builtin:cornell", "--views", "views.vf", "-o", "g.csv", "--side", "128",
                                 "--samples", "1", "--gather", "2", "--photons", "2000", "--picture", name});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    ASSERT_EQ(run({"glare", name, "-o", "again.csv"}).status, 0) << name;
    const std::vector<double> rated = numbers_of_view(first_view(read(path("g.csv"))));
    const std::vector<double> again = numbers_of_view(first_view(read(path("again.csv"))));
    ASSERT_EQ(rated.size(), 5u);
    ASSERT_EQ(again.size(), 5u);
    const Outcome by_task = run({"glare", name, "-o", "task.csv", "--task", "64,20,0.2"});
    EXPECT_THAT(by_task.err, testing::HasSubstr("the task has"));
    // RGBE has eight bits for the largest channel. A picture has no places within pixels, which indices depend on.
    EXPECT_NEAR(again[3] / rated[3], 1, 0.01) << name;
    if (by_format.empty()) by_format = again;
    for (std::size_t i = 0; i < again.size(); ++i) EXPECT_NEAR(again[i] / by_format[i], 1, 0.01) << i;
  }
  EXPECT_TRUE(refused(run({"glare", "s.hdr", "-o", "a.csv", "--view", "-vtv -vh 90 -vv 90"}), {"fisheye", "-vta"}));
  EXPECT_TRUE(refused(run({"glare", "builtin:cornell", "-o", "a.csv"}), {"--views FILE"}, 2));
  EXPECT_TRUE(refused(run({"glare", "s.hdr", "-o", "a.csv", "--task", "1,2"}), {"--task '1,2'"}, 2));
}

/// A disc of a few pixels straight ahead, whose edges are most of it, before an even sky.
TEST_F(GlareTest, SmallSourcesHaveTheirSizeAndLuminance) {
  constexpr double kRadiance = 100, kLamp = 179 * kRadiance, kSky = 179;
  for (const double radius : {0.03, 0.05, 0.1}) {
    std::ofstream(path("disc.pbrt")) << "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
                                        "AreaLightSource \"diffuse\" \"rgb L\" [100 100 100] \"bool twosided\" true\n"
                                        "Translate 0.013 0.017 -1\nShape \"disk\" \"float radius\" "
                                     << radius << "\n";
    const Outcome outcome = rate("disc.pbrt", "rview -vta -vp 0 0 0 -vd 0 0 -1 -vu 0 1 0\n");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const double solid_angle = 2 * M_PI * (1 - std::cos(std::atan(radius)));
    const std::vector<double> found = numbers_of_view(first_view(read(path("g.csv"))));
    ASSERT_EQ(found.size(), 5u);
    const double weight = solid_angle / std::pow(position_index(normalize(Vec3{0.013f, 0.017f, 1})), 2);
    EXPECT_NEAR(found[2], 8 * std::log10(0.25 / kSky * kLamp * kLamp * weight), 0.1) << radius;
    EXPECT_NEAR(found[4], kSky, 0.02 * kSky) << radius;
  }
}

TEST_F(GlareTest, SaysThatLampsWithoutSizeAreMissing) {
  std::ofstream(path("a.pbrt")) << "WorldBegin\nLightSource \"point\" \"rgb I\" [9 9 9]\nMaterial \"diffuse\"\n"
                                   "Shape \"sphere\" \"float radius\" 5\n";
  const Outcome outcome = rate("a.pbrt", kAtTheLamp);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("lamps without size: 1"));
}

TEST_F(GlareTest, RefusesFilesWithoutViews) {
  EXPECT_TRUE(refused(rate("builtin:cornell", "# nothing\n"), {"views.vf", "no view"}));
  EXPECT_TRUE(refused(rate("builtin:cornell", "rview -vp 0 0\n"), {"views.vf:1"}));
}

}  // namespace
}  // namespace glowworm
