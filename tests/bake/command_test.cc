// glowworm bake, as a person runs it.
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "image/image.h"

namespace glowworm {
namespace {

using testing::HasSubstr;
using testing::Not;

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
  const Outcome probes =
      run(words({"--format", "probes", "--spacing", "0.2", "--texture", "exr", "-o", "probes.json"}));
  EXPECT_EQ(probes.status, 0) << probes.err;
  const nlohmann::json grid = read_json("probes.json");
  ASSERT_EQ(grid["probes"].size(), 8u);
  const Image picture = read_image(path("probes.exr"));
  EXPECT_EQ(picture.metadata.at("spacing"), grid["spacing"].dump());
  const std::vector<RGB> coefficient = picture.rgb("Y3");
  ASSERT_EQ(coefficient.size(), 8u);
  for (std::size_t i = 0; i < coefficient.size(); ++i)
    EXPECT_NEAR(coefficient[i].g, grid["probes"][i].is_null() ? 0 : grid["probes"][i][3][1].get<float>(), 1e-3);
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

TEST_F(BakeCommand, KeepsTheTextureCoordinatesOfTexturesOnly) {
  ASSERT_EQ(run(words({"-o", "lit.glb", "--atlas-picture", "light.png"})).status, 0);
  write("room.mtl", "newmtl picture\nmap_Kd light.png\nnewmtl plain\nKd 0.5 0.5 0.5\n");
  write("room.obj",
        "mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "usemtl picture\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 3/3 4/4\n");
  const Outcome outcome = run({"bake", "room.obj", "--environment", "1,1,1", "--format", "lightmap", "--atlas", "64",
                               "--samples", "1", "--photons", "5k", "-o", "room.glb"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string glb = read(path("room.glb"));
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, sizeof size);
  const auto file = nlohmann::json::parse(glb.substr(20, size));
  std::size_t primitives = 0;
  for (const auto& mesh : file["meshes"])
    for (const auto& primitive : mesh["primitives"]) {
      const auto& attributes = primitive["attributes"];
      const bool own = file["materials"][primitive["material"].get<std::size_t>()]["name"] == "picture";
      EXPECT_EQ(attributes["TEXCOORD_0"] != attributes["TEXCOORD_1"], own);
      ++primitives;
    }
  EXPECT_EQ(primitives, 2u);
}

TEST_F(BakeCommand, GoesOnFromACheckpointToTheSameFile) {
  const std::vector<std::string> line = words({"-o", "lit.glb", "--resume", "bake.checkpoint"});
  EXPECT_EQ(run(line).status, 0);
  const std::string once = read(path("lit.glb"));
  EXPECT_EQ(run(line).status, 0);
  EXPECT_EQ(read(path("lit.glb")), once);
}

/// A bake of the Cornell box that 64 MB hold in bands.
std::vector<std::string> banded(const std::string& memory, const std::vector<std::string>& more = {}) {
  std::vector<std::string> line{"bake", "builtin:cornell", "--atlas", "256", "--samples", "2", "--gather", "4"};
  line.insert(line.end(), {"--photons", "5k", "-o", "lit.glb", "--atlas-picture", "light.exr", "--memory", memory});
  line.insert(line.end(), {"--threads", "2"});  // each takes some of the memory
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST_F(BakeCommand, GivesTheSameLightInLittleMemory) {
  ASSERT_EQ(run(banded("1G")).status, 0);
  const std::vector<RGB> whole = read_image(path("light.exr")).rgb();
  const Outcome bands = run(banded("64M"));
  ASSERT_EQ(bands.status, 0) << bands.err;
  EXPECT_THAT(bands.err, HasSubstr("rows 256 of 256, as --memory allows"));
  EXPECT_TRUE(read_image(path("light.exr")).rgb() == whole);
  EXPECT_TRUE(refused(run(banded("2M")), {"--memory"}));
}

TEST_F(BakeCommand, GoesOnFromACheckpointOfABand) {
  ASSERT_EQ(run(banded("1G")).status, 0);
  const std::vector<RGB> whole = read_image(path("light.exr")).rgb();
  // A checkpoint of an early band, as an interrupted bake leaves it: for little memory, and for much.
  Running bake(folder_, banded("64M", {"--resume", "bake.checkpoint"}));
  ASSERT_TRUE(bake.wait_for_text("rows 192 of 256", 60));
  bake.send(SIGINT);
  bake.wait();
  std::filesystem::copy_file(path("bake.checkpoint"), path("copy.checkpoint"));
  std::filesystem::remove(path("light.exr"));
  for (const char* memory : {"1G", "64M"}) {
    std::filesystem::copy_file(path("copy.checkpoint"), path("bake.checkpoint"),
                               std::filesystem::copy_options::overwrite_existing);
    const Outcome rest = run(banded(memory, {"--resume", "bake.checkpoint"}));
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_THAT(rest.err, Not(HasSubstr("rows 96 of 256")));
    EXPECT_TRUE(read_image(path("light.exr")).rgb() == whole) << memory;
  }
  EXPECT_TRUE(refused(run(words({"-o", "a.glb", "--resume", "bake.checkpoint"})), {"checkpoint", "--atlas"}));
}

TEST_F(BakeCommand, MergesPartsToTheSameFile) {
  const auto of_samples = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"bake", "builtin:cornell", "--atlas", "64", "--samples", "3", "--photons", "5k"});
    return run(more);
  };
  ASSERT_EQ(of_samples({"-o", "lit.glb", "--atlas-picture", "whole.exr"}).status, 0);
  ASSERT_EQ(of_samples({"--part", "1/2", "-o", "1.part"}).status, 0);
  const Outcome second = of_samples({"--part", "2/2", "-o", "2.part"});
  ASSERT_EQ(second.status, 0) << second.err;
  ASSERT_EQ(run({"merge", "2.part", "1.part", "-o", "all.part"}).status, 0);
  const std::vector<std::string> bake{"bake", "builtin:cornell", "--atlas", "64"};
  const auto from = [&](std::vector<std::string> more) {
    more.insert(more.begin(), bake.begin(), bake.end());
    more.insert(more.end(), {"--from", "all.part", "-o", "merged.glb"});
    return run(more);
  };
  const Outcome merged = from({"--atlas-picture", "merged.exr"});
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_TRUE(read_image(path("merged.exr")).rgb() == read_image(path("whole.exr")).rgb());
  EXPECT_TRUE(refused(from({"--light", "indirect"}), {"all.part", "--indirect-only"}));
  EXPECT_TRUE(refused(from({"--photons", "6k"}), {"all.part", "--photons"}));
  EXPECT_TRUE(refused(from({"--part", "1/2"}), {"--from"}, 2));
  EXPECT_TRUE(refused(run({"bake", "builtin:cornell", "--atlas", "32", "--from", "all.part", "-o", "a.glb"}),
                      {"points", "--atlas"}));
  EXPECT_TRUE(refused(of_samples({"--noise", "1%", "-o", "a.part"}), {"--samples"}, 2));
}

TEST_F(BakeCommand, WritesTexturesWithAMultiplierBesideTheFile) {
  const Outcome outcome = run(words({"--texture", "rgbm", "-o", "lit.glb", "--atlas-picture", "light.exr"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read(path("lit.0.rgbm.png")).substr(1, 3), "PNG");
  const std::string glb = read(path("lit.glb")), mark = R"("light":{"file":"lit.0.rgbm.png","rgbm":)";
  const std::size_t at = glb.find(mark);
  ASSERT_NE(at, std::string::npos);
  const std::vector<RGB> light = read_image(path("light.exr")).rgb();
  float peak = 0;
  for (const RGB& texel : light) peak = std::max(peak, max_component(texel));
  EXPECT_NEAR(std::stof(glb.substr(at + mark.size())), peak, 1e-3f * peak);
  EXPECT_TRUE(refused(run(words({"--texture", "ktx2", "-o", "a.glb"})), {"KTX2", "--texture rgbm"}, 2));
}

TEST_F(BakeCommand, SaysWhatIsWrongWithACommandLine) {
  const auto refuses = [&](const std::vector<std::string>& more, const char* text) {
    const Outcome outcome = run(words(more));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  refuses({"-o", "lit.png"}, "does not end in .glb or .part");
  refuses({"-o", "lit.glb", "--format", "emisive"}, "Did you mean 'emissive'?");
  refuses({"-o", "lit.glb", "--light", "direct"}, "--light 'direct' is not known");
  refuses({"-o", "lit.glb", "--atlas", "64.5"}, "not a whole number");
  refuses({"-o", "lit.glb", "--atlas", "1"}, "not a whole number from 16");
  refuses({"-o", "lit.glb", "--texels-per-metre", "-1"}, "--texels-per-metre '-1'");
  refuses({"-o", "probes.json", "--format", "probes"}, "Give --spacing");
  refuses({"-o", "lit.glb", "--atlas-picture", "lit.glb"}, "lit.glb");
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace glowworm
