// Invalid files and settings: the program prints an error with its place, exits with status 1 and leaves no files.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>

#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
constexpr const char* kSquare = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3\nf 1 3 4\n";

class BadInputTest : public ProgramTest {
 protected:
  /// Renders a scene that must be refused, and looks for what is left behind.
  void expect_refused(const std::string& scene, const std::vector<std::string>& texts, int status = 1) {
    const auto before = names();
    EXPECT_TRUE(refused(render(scene, {"-o", "a.exr", "-o", "a.png", "--stats", "a.json"}), texts, status));
    EXPECT_EQ(names(), before);
    EXPECT_TRUE(refused(run({"info", scene}), texts, status));
  }
};

TEST_F(BadInputTest, MissingFile) { expect_refused("nowhere.obj", {"nowhere.obj", "no such scene file"}); }

TEST_F(BadInputTest, UnknownBuiltinScene) {
  expect_refused("builtin:kornell", {"kornell", "cornell, atrium, ajar"}, 2);
}

TEST_F(BadInputTest, UnknownFormat) { expect_refused(write("a.xyz", "1 2 3"), {"a.xyz", ".xyz", "Supported"}); }

TEST_F(BadInputTest, FolderForAFile) { expect_refused(folder_.string(), {folder_.string(), "folder"}); }

TEST_F(BadInputTest, PipesForFiles) {
  for (const char* name : {"a.obj", "a.gltf", "a.pbrt", "a.fbx", "a.json", "a.checkpoint"})
    ASSERT_EQ(mkfifo(path(name).c_str(), 0600), 0);
  for (const char* name : {"a.obj", "a.gltf", "a.pbrt", "a.fbx"})
    expect_refused(name, {std::string(name) + ": is not a regular file"});
  EXPECT_TRUE(refused(run({"view", "builtin:cornell", "--script", "a.json", "--out", "frames"}),
                      {"a.json: is not a regular file"}));
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "b.exr", "--resume=a.checkpoint"}),
                      {"a.checkpoint", "not a regular file"}));
}

TEST_F(BadInputTest, EmptyFile) {
  for (const char* name : {"a.obj", "a.gltf", "a.glb", "a.pbrt", "a.ply"})
    expect_refused(write(name, ""), {path(name)});
}

TEST_F(BadInputTest, TruncatedGlb) {
  // The header promises 1000 bytes.
  std::string glb("glTF\2\0\0\0\xe8\3\0\0", 12);
  glb += std::string("\x40\0\0\0JSON", 8) + R"({"asset":{"version":"2.0"},"sce)";
  expect_refused(write("cut.glb", glb), {"cut.glb"});
}

TEST_F(BadInputTest, ObjIndexOutOfRange) {
  expect_refused(write("a.obj", std::string(kTriangle) + "f 1 2 4\n"), {"a.obj:4", "4"});
  expect_refused(write("b.obj", std::string(kTriangle) + "f 1 2 -4\n"), {"b.obj:4"});
}

TEST_F(BadInputTest, PbrtMistakesHaveLineAndColumn) {
  expect_refused(write("a.pbrt", "WorldBegin\nShape \"sphere\" \"float radius\" [ \"one\" ]\n"), {"a.pbrt:2:"});
}

TEST_F(BadInputTest, VerticesThatAreNotNumbers) {
  // Either refused with the place, or mended with a word; never drawn in silence.
  const std::string scene = write("a.obj", std::string(kSquare) + "v nan 0 0\nf 1 2 5\n");
  const Outcome outcome = render(scene, {"-o", "a.png"});
  EXPECT_THAT(outcome.err, HasSubstr("a.obj"));
  if (outcome.status == 0) {
    EXPECT_THAT(names(), ElementsAre("a.obj", "a.png"));
  } else {
    EXPECT_TRUE(refused(outcome, {"a.obj"}));
    EXPECT_THAT(names(), ElementsAre("a.obj"));
  }
}

TEST_F(BadInputTest, TrianglesWithoutArea) {
  const std::string some = write("some.obj", std::string(kSquare) + "f 1 1 2\n");
  const Outcome mended = render(some, {"-o", "some.png"});
  EXPECT_EQ(mended.status, 0) << mended.err;
  EXPECT_THAT(mended.err, HasSubstr("area"));
  expect_refused(write("all.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), {"triangle"});
}

TEST_F(BadInputTest, TextureThatIsNotAnImage) {
  write("bad.png", "this is not a picture");
  write("m.mtl", "newmtl m\nmap_Kd bad.png\n");
  const std::string scene =
      write("a.obj", "mtllib m.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nvt 0 0\nvt 0 1\nvt 1 1\nusemtl m\nf 1/1 2/2 3/3\n");
  const Outcome outcome = render(scene, {"-o", "a.exr", "-q"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("warning: "));
  EXPECT_THAT(outcome.err, HasSubstr("bad.png"));
}

TEST_F(BadInputTest, InvalidSizes) {
  for (const char* size : {"0x0", "0x16", "-4x4", "16", "16x", "16x16x16", "99999999999x1", "axb", "70000x10"})
    EXPECT_TRUE(refused(render("builtin:cornell", {"--size", size}), {std::string("--size '") + size, "65536"}, 2))
        << size;
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(BadInputTest, InvalidValues) {
  const std::vector<std::vector<std::string>> cases = {
      {"--samples", "0"},      {"--samples", "1.5"}, {"--gather", "-1"}, {"--photons", "many"},
      {"--photons", "nan"},    {"--photons", "9e9"}, {"--memory", "4Q"}, {"--memory", "inf"},
      {"--time", "soon"},      {"--time", "-5s"},    {"--nearest", ""},  {"--engine", "fastest"},
      {"--aov", "direct,sun"}, {"--simd", "mmx"},    {"--noise", "0"},   {"--threads", "-1"},
      {"--view", "1,2"},       {"--light", "sun"},   {"--kernel", "bx"}, {"--seed", "one"},
  };
  for (const auto& values : cases)
    EXPECT_TRUE(refused(render("builtin:cornell", values), {values[1] == "direct,sun" ? "sun" : values[1]}, 2))
        << values[0] << " " << values[1];
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(BadInputTest, ValidNamesAreListed) {
  EXPECT_TRUE(refused(render("builtin:cornell", {"--engine", "x"}), {"blocked", "forward", "knn", "brute"}, 2));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--engine", "foward"}), {"--engine 'foward'", "mean 'forward'"}, 2));
  EXPECT_TRUE(
      refused(render("builtin:cornell", {"--aov", "x"}), {"direct", "indirect", "albedo", "normal", "depth"}, 2));
  EXPECT_TRUE(refused(render("builtin:ajar", {"--camera", "x"}), {"main", "table"}, 2));
}

TEST_F(BadInputTest, InvalidCommandLines) {
  const std::vector<std::vector<std::string>> cases = {{},
                                                       {"draw"},
                                                       {"render"},
                                                       {"render", "builtin:cornell", "--fast"},
                                                       {"render", "builtin:cornell", "--integrator", "guess"},
                                                       {"render", "builtin:cornell", "--threads", "-1"},
                                                       {"render", "builtin:cornell", "--seed", "one"},
                                                       {"render", "builtin:cornell", "--noise", "0"},
                                                       {"compare", "a.exr"}};
  for (const auto& arguments : cases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << testing::PrintToString(arguments) << outcome.err;
    EXPECT_FALSE(outcome.err.empty());
  }
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(BadInputTest, OutputsThatCannotBeWritten) {
  std::filesystem::create_directory(folder_ / "folder.exr");
  for (const char* output : {"missing/a.exr", "folder.exr"})
    EXPECT_TRUE(refused(render("builtin:cornell", {"-o", output}), {output}));
  for (const char* output : {"a.bmp", "a"})
    EXPECT_TRUE(refused(render("builtin:cornell", {"-o", output}), {output}, 2));
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "a.png", "--stats", "missing/a.json"}), {"missing/a.json"}));
  EXPECT_THAT(names(), ElementsAre("folder.exr"));
  if (geteuid() == 0) return;  // nothing is closed to root
  std::filesystem::create_directory(folder_ / "closed");
  std::filesystem::permissions(folder_ / "closed", std::filesystem::perms::owner_read);
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "closed/a.exr"}), {"closed/a.exr"}));
}

TEST_F(BadInputTest, FileSizeLimitActsAsAFullDisk) {
  write("a.exr", "an older picture");
  const auto limit = [] {
    const rlimit bytes = {1000, 1000};
    setrlimit(RLIMIT_FSIZE, &bytes);
  };
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "a.exr", "-q"}, limit), {"a.exr"}));
  EXPECT_EQ(read(path("a.exr")), "an older picture");
  EXPECT_THAT(names(), ElementsAre("a.exr"));
}

TEST_F(BadInputTest, FullDisk) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "there is no /dev/full";
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "a.exr", "--stats", "/dev/full"}),
                      {"/dev/full", "No space left on device"}));
}

TEST_F(BadInputTest, TooLittleMemory) {
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "a.exr", "--memory", "1M", "--photons", "20k"}), {"memory"}));
  EXPECT_THAT(names(), IsEmpty());
}

/// Runs without sanitizers, which reserve more address space than the limit allows.
class SlowBadInputTest : public BadInputTest {};

TEST_F(SlowBadInputTest, FilmsLargerThanTheBudgetAreNeverMade) {
  const auto limit = [] {
    const rlimit bytes = {rlim_t{4} << 30, rlim_t{4} << 30};
    setrlimit(RLIMIT_AS, &bytes);
  };
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "a.exr", "--memory", "64M", "--size", "65536x65536"}, limit),
                      {"film", "budget of 64.0 MB", "--memory", "TMPDIR"}));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(BadInputTest, ScenesLargerThanTheBudgetListTheirMemory) {
  std::string scene = "WorldBegin ObjectBegin \"o\" Shape \"sphere\" ObjectEnd\n";
  for (int i = 0; i < 1000; ++i) scene += "ObjectInstance \"o\"\n";
  EXPECT_TRUE(refused(render(write("a.pbrt", scene), {"-o", "a.exr", "--memory", "64M"}),
                      {"a.pbrt:", "budget of 64.0 MB", "of triangles (held: ", "object meshes", "--memory"}));
}

TEST_F(BadInputTest, InfoReadsNoTexelsThatItDoesNotNeed) {
  // Only reading its pixels shows that the picture is damaged.
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.png", "-q"}).status, 0);
  std::string picture = read(path("a.png"));
  picture.resize(picture.size() - 40);  // metadata stand before the pixels
  write("a.png", picture);
  const std::string scene = write("a.pbrt",
                                  "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\"\n"
                                  "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"\n");
  const Outcome info = run({"info", scene});
  EXPECT_EQ(info.status, 0) << info.err;
  EXPECT_THAT(info.out + info.err, Not(HasSubstr("magenta")));
  EXPECT_THAT(render(scene, {"-o", "b.exr"}).err, HasSubstr("magenta"));
  // A light's picture is needed.
  const std::string light =
      write("b.pbrt", "WorldBegin AreaLightSource \"diffuse\" \"string filename\" \"a.png\" Shape \"sphere\"\n");
  EXPECT_THAT(run({"info", light}).err, HasSubstr("is left out"));
}

TEST_F(BadInputTest, NoPixelIsEverInfinite) {
  // A light as bright as can be, close above the floor and within the camera's view.
  const std::string scene = write("a.pbrt",
                                  "LookAt 0 -3 2  0 0 0  0 0 1 Camera \"perspective\" \"float fov\" 10 WorldBegin\n"
                                  "LightSource \"point\" \"rgb I\" [1e30 1e30 1e30] \"point3 from\" [0 0 0.2]\n"
                                  "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n");
  for (const char* integrator : {"gather", "path", "photons"}) {
    const Outcome outcome = render(scene, {"-o", "a.exr", "-o", "a.png", "--precision", "float", "--integrator",
                                           integrator, "--aov", "direct,indirect"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    if (integrator != std::string("photons")) {
      EXPECT_THAT(outcome.err,
                  HasSubstr("camera samples are black, because their light was beyond what pictures hold"));
    }
    const Image image = read_image(path("a.exr"));
    for (const ImageChannel& channel : image.channels())
      for (const float sample : channel.samples)
        ASSERT_TRUE(std::isfinite(sample)) << integrator << ' ' << channel.name;
  }
}

TEST_F(BadInputTest, InvalidComparisons) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.exr", "-q"}).status, 0);
  ASSERT_EQ(render("builtin:cornell", {"-o", "b.exr", "--size", "8x8", "-q"}).status, 0);
  write("c.exr", "no image");
  EXPECT_TRUE(refused(run({"compare", "a.exr", "b.exr"}), {"16", "8"}));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "c.exr"}), {"c.exr"}));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "missing.exr"}), {"missing.exr"}));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "-o", "d.exr"}), {"d.exr", ".png"}, 2));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "-o", "missing/d.png"}), {"missing/d.png"}));
  EXPECT_THAT(names(), ElementsAre("a.exr", "b.exr", "c.exr"));
  Image picture(1000, 1000);
  picture.add_rgb("", std::vector<RGB>(picture.pixel_count()));
  write_png(path("large.png"), picture);
  const std::vector<std::string> large{"compare", "large.png", "large.png", "--memory"};
  const auto within = [&](const char* memory) {
    std::vector<std::string> words = large;
    words.emplace_back(memory);
    return run(words);
  };
  EXPECT_TRUE(refused(within("16M"), {"no room for", "of pictures", "larger --memory, or reduce the pictures"}));
  EXPECT_EQ(within("1G").status, 0);
}

}  // namespace
}  // namespace glowworm
