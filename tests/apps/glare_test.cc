// `glowworm glare`: views in, ratings out.
#include <fstream>

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
