// glowworm bake, as a person runs it.
#include "apps/program.h"
#include "image/image.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

class BakeCommand : public ProgramTest {
 protected:
  static std::vector<std::string> words(std::vector<std::string> more) {
    std::vector<std::string> all{"bake", "builtin:cornell", "--atlas", "64", "--samples", "1", "--photons", "5k"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(BakeCommand, WritesAFileInEveryFormat) {
  for (const char* format : {"emissive", "unlit", "lightmap", "vertex"}) {
    const Outcome outcome = run(words({"--format", format, "-o", "lit.glb", "--atlas-picture", "light.png"}));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("texels per metre"));
    EXPECT_EQ(read(path("lit.glb")).substr(0, 4), "glTF");
    EXPECT_EQ(read(path("light.png")).substr(1, 3), "PNG");
    EXPECT_EQ(run({"info", "lit.glb"}).status, 0);
  }
  const Outcome probes = run(words({"--format", "probes", "--spacing", "0.2", "-o", "probes.json"}));
  EXPECT_EQ(probes.status, 0) << probes.err;
  EXPECT_EQ(read_json("probes.json")["probes"].size(), 8u);
}

TEST_F(BakeCommand, WritesTexturesOfFullRangeBesideTheFile) {
  const Outcome outcome = run(words({"--texture", "exr", "-o", "lit.glb", "--atlas-picture", "light.exr"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_image(path("lit.0.exr")).rgb(), read_image(path("light.exr")).rgb());
  EXPECT_THAT(read(path("lit.glb")), HasSubstr(R"("light":{"file":"lit.0.exr","texCoord":1})"));
  const Outcome same = run(words({"--texture", "exr", "-o", "a.glb", "--atlas-picture", "a.0.exr"}));
  EXPECT_TRUE(refused(same, {"a.0.exr"}, 2));
  EXPECT_TRUE(refused(run(words({"--texture", "exr", "--format", "vertex", "-o", "a.glb"})), {"no textures"}, 2));
}

TEST_F(BakeCommand, GoesOnFromACheckpointToTheSameFile) {
  const std::vector<std::string> line = words({"-o", "lit.glb", "--resume", "bake.checkpoint"});
  EXPECT_EQ(run(line).status, 0);
  const std::string once = read(path("lit.glb"));
  EXPECT_EQ(run(line).status, 0);
  EXPECT_EQ(read(path("lit.glb")), once);
}

TEST_F(BakeCommand, GivesTheSameLightInLittleMemory) {
  const auto bake = [&](const char* memory, const std::vector<std::string>& more) {
    std::vector<std::string> line{"bake",
                                  "builtin:cornell",
                                  "--atlas",
                                  "256",
                                  "--samples",
                                  "2",
                                  "--gather",
                                  "4",
                                  "--photons",
                                  "5k",
                                  "-o",
                                  "lit.glb",
                                  "--atlas-picture",
                                  "light.exr",
                                  "--memory",
                                  memory};
    line.insert(line.end(), more.begin(), more.end());
    return run(line);
  };
  ASSERT_EQ(bake("1G", {}).status, 0);
  const std::vector<RGB> whole = read_image(path("light.exr")).rgb();
  const Outcome bands = bake("64M", {});
  ASSERT_EQ(bands.status, 0) << bands.err;
  EXPECT_THAT(bands.err, HasSubstr("rows 256 of 256, as --memory allows"));
  EXPECT_TRUE(read_image(path("light.exr")).rgb() == whole);
  EXPECT_TRUE(refused(bake("64M", {"--resume", "bake.checkpoint"}), {"--resume", "--memory"}));
  EXPECT_TRUE(refused(bake("2M", {}), {"--memory"}));
}

TEST_F(BakeCommand, SaysWhatIsWrongWithACommandLine) {
  const auto refuses = [&](const std::vector<std::string>& more, const char* text) {
    const Outcome outcome = run(words(more));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  refuses({"-o", "lit.png"}, "does not end in .glb");
  refuses({"-o", "lit.glb", "--format", "emisive"}, "Did you mean 'emissive'?");
  refuses({"-o", "lit.glb", "--light", "direct"}, "--light 'direct' is not known");
  refuses({"-o", "lit.glb", "--atlas", "64.5"}, "not a whole number");
  refuses({"-o", "lit.glb", "--atlas", "1"}, "not a number from 16");
  refuses({"-o", "lit.glb", "--texels-per-metre", "-1"}, "--texels-per-metre '-1'");
  refuses({"-o", "probes.json", "--format", "probes"}, "Give --spacing");
  refuses({"-o", "lit.glb", "--atlas-picture", "lit.glb"}, "lit.glb");
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace glowworm
