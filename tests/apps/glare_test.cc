// `glowworm glare`: views in, ratings out.
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

TEST_F(GlareTest, PicturesOfSourcesKeepTheirLuminanceAndCanBeRated) {
  std::ofstream(path("views.vf")) << kAtTheLamp;
  for (const char* name : {"s.hdr", "s.exr"}) {
    const Outcome outcome = run({"glare", "builtin:cornell", "--views", "views.vf", "-o", "g.csv", "--side", "128",
                                 "--samples", "1", "--gather", "2", "--photons", "2000", "--picture", name});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    ASSERT_EQ(run({"glare", name, "-o", "again.csv"}).status, 0) << name;
    const std::vector<double> rated = numbers_of_view(first_view(read(path("g.csv"))));
    const std::vector<double> again = numbers_of_view(first_view(read(path("again.csv"))));
    ASSERT_EQ(rated.size(), 5u);
    ASSERT_EQ(again.size(), 5u);
    // RGBE has eight bits for the largest channel.
    const Outcome by_task = run({"glare", name, "-o", "task.csv", "--task", "64,20,0.2"});
    EXPECT_THAT(by_task.err, testing::HasSubstr("the task has"));
    for (std::size_t i = 0; i < rated.size(); ++i) EXPECT_NEAR(again[i] / rated[i], 1, 0.01) << name << ' ' << i;
  }
  EXPECT_TRUE(refused(run({"glare", "s.hdr", "-o", "a.csv", "--view", "-vtv -vh 90 -vv 90"}), {"fisheye", "-vta"}));
  EXPECT_TRUE(refused(run({"glare", "builtin:cornell", "-o", "a.csv"}), {"--views FILE"}, 2));
  EXPECT_TRUE(refused(run({"glare", "s.hdr", "-o", "a.csv", "--task", "1,2"}), {"--task '1,2'"}, 2));
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
