// Pictures in parts, as several machines render them.
#include <signal.h>

#include <optional>

#include "film/checkpoint.h"
#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class MergeTest : public ProgramTest {
 protected:
  Outcome render_atrium(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"render", "builtin:atrium", "--size", "24x16", "--gather",
                                          "4",      "--photons",      "2000",   "--aov", "depth,direct"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  void expect_same_pixels(const std::string& a, const std::string& b) const {
    const Image one = read_image(path(a)), other = read_image(path(b));
    ASSERT_EQ(one.channels().size(), other.channels().size());
    EXPECT_EQ(one.channels().size(), 7u);
    for (std::size_t i = 0; i < one.channels().size(); ++i)
      EXPECT_TRUE(one.channels()[i].samples == other.channels()[i].samples) << one.channels()[i].name;
  }
};

TEST_F(MergeTest, PartsInAnyOrderAreTheUndividedPicture) {
  ASSERT_EQ(render_atrium({"--samples", "5", "-o", "whole.exr", "--precision", "float"}).status, 0);
  std::vector<std::string> merge = {"merge", "--precision", "float", "-o", "merged.png", "-o", "merged.exr"};
  for (const char* i : {"3", "1", "5", "2", "4"}) {
    ASSERT_EQ(render_atrium({"--samples", "5", "--part", i + std::string("/5"), "--threads", "1"}).status, 0);
    merge.push_back(i + std::string("-of-5.part"));
  }
  const Outcome outcome = run(merge);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("merged 5 parts: 5 of 5 samples"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("missing")));
  expect_same_pixels("merged.exr", "whole.exr");
  EXPECT_EQ(read_image(path("merged.png")).width(), 24);
  // Without two of them.
  const Outcome fewer = run({"merge", "1-of-5.part", "4-of-5.part", "2-of-5.part", "-o", "fewer.exr"});
  EXPECT_EQ(fewer.status, 0);
  EXPECT_THAT(fewer.err, HasSubstr("samples 3, 5 of 5 are missing: the picture has 3 samples"));
}

/// With sanitizers large arrays stay in memory.
class SlowMergeTest : public MergeTest {};

TEST_F(SlowMergeTest, AFilmLargerThanTheMemoryIsInFiles) {
  ASSERT_EQ(render_atrium({"--samples", "2", "--part", "1/2", "-o", "1.part"}).status, 0);
  for (const char* memory : {"20M", "2G"})
    ASSERT_EQ(run({"merge", "1.part", "--memory", memory, "-o", std::string(memory) + ".exr"}).status, 0);
  expect_same_pixels("20M.exr", "2G.exr");
}

TEST_F(MergeTest, AKilledPartIsRepeated) {
  ASSERT_EQ(render_atrium({"--samples", "6", "-o", "whole.exr", "--precision", "float"}).status, 0);
  const std::vector<std::string> second = {"render",
                                           "builtin:atrium",
                                           "--size",
                                           "24x16",
                                           "--gather",
                                           "4",
                                           "--photons",
                                           "2000",
                                           "--aov",
                                           "depth,direct",
                                           "--samples",
                                           "6",
                                           "--part",
                                           "2/2",
                                           "-o",
                                           "2.part",
                                           "--resume=2.checkpoint"};
  {
    Running program(folder_, second);
    ASSERT_TRUE(program.wait_for_text("samples 4 to 6 of 6", 60));
    program.send(SIGKILL);
    EXPECT_EQ(program.wait().status, 128 + SIGKILL);
  }
  EXPECT_THAT(names(), Not(testing::Contains("2.part")));
  ASSERT_EQ(render_atrium({"--samples", "6", "--part", "1/2", "-o", "1.part"}).status, 0);
  EXPECT_TRUE(refused(run({"merge", "1.part", "2.part", "-o", "m.exr"}), {"2.part", "no such file"}));
  ASSERT_EQ(run(second).status, 0);
  EXPECT_EQ(run({"merge", "1.part", "2.part", "-o", "m.exr", "--precision", "float"}).status, 0);
  expect_same_pixels("m.exr", "whole.exr");
}

TEST_F(MergeTest, AnInterruptedPartHasFewerSamples) {
  std::optional<Outcome> outcome;
  {
    Running program(folder_, {"render", "builtin:atrium", "--size", "64x64", "--samples", "40k", "--photons", "2000",
                              "--part", "1/2", "-o", "1.part", "--resume=1.checkpoint"});
    ASSERT_TRUE(wait_for_file("1.checkpoint", 60));
    ASSERT_TRUE(wait_until([&] { return read_checkpoint(path("1.checkpoint"))->passes > 0; }, 60));
    program.send(SIGINT);
    outcome = program.wait();
  }
  EXPECT_EQ(outcome->status, 130) << outcome->err;
  const Outcome merged = run({"merge", "1.part", "-o", "m.exr"});
  EXPECT_EQ(merged.status, 0);
  EXPECT_THAT(merged.err, HasSubstr("a part was stopped before its end: some pixels have only"));
}

TEST_F(MergeTest, WrongCommandLinesAndFilesAreRefused) {
  ASSERT_EQ(render_atrium({"--samples", "2", "--part", "1/2", "-o", "1.part"}).status, 0);
  ASSERT_EQ(render_atrium({"--samples", "2", "--part", "2/2", "--gather", "5", "-o", "2.part"}).status, 0);
  const std::string before = read(path("1.part"));
  EXPECT_TRUE(refused(run({"merge", "1.part", "2.part", "-o", "m.exr"}), {"1.part", "2.part", "--gather is 4 in"}));
  EXPECT_TRUE(refused(run({"merge", "1.part", "1.part", "-o", "m.exr"}), {"samples in common: 1 to 1"}));
  EXPECT_TRUE(refused(run({"merge", "1.part", "-o", "1.part"}), {"are the same file"}, 2));
  EXPECT_TRUE(refused(run({"merge", "1.part", "-o", "m.jpg"}), {"'m.jpg' ends neither"}, 2));
  EXPECT_TRUE(refused(run({"merge", "1.part", "-o", "m.exr", "--memory", "20M", "--disk", "never"}), {"--memory"}));
  for (const char* part : {"0/2", "3/2", "1", "1/", "/2", "1/2/3", "-1/2", "1/99999999999"})
    EXPECT_TRUE(refused(render_atrium({"--part", part}), {"--part", "is not a part", "3/8"}, 2)) << part;
  EXPECT_TRUE(refused(render_atrium({"--part", "1/2", "--noise", "1%"}), {"--part", "--noise"}, 2));
  EXPECT_TRUE(refused(render_atrium({"--part", "1/2", "--time", "9s"}), {"--part", "--samples"}, 2));
  EXPECT_TRUE(refused(render_atrium({"-o", "x.part", "--noise", "1%"}), {"x.part", "--samples"}, 2));
  EXPECT_TRUE(refused(render_atrium({"--part", "3/9", "--samples", "2"}), {"--samples 9"}, 2));
  EXPECT_EQ(read(path("1.part")), before);
  EXPECT_THAT(names(), ElementsAre("1.part", "2.part"));
}

}  // namespace
}  // namespace glowworm
