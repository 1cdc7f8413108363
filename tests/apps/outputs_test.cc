// Output files when one of them cannot be written, or when two have the same name.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>

#include "film/checkpoint.h"
#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class OutputsTest : public ProgramTest {
 protected:
  /// A name that stands for a file on a full disk.
  void make_full(const std::string& name) const { fs::create_symlink("/dev/full", folder_ / name); }

  static std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
  }

  /// Status 2 and the reason, and all files as they were.
  void expect_one_file(const std::vector<std::string>& arguments) const {
    const auto state = [&] {
      std::string all;
      for (const std::string& name : names())
        if (fs::is_regular_file(folder_ / name)) all += name + ":" + read(folder_ / name) + "\n";
      return all;
    };
    const std::string before = state();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << testing::PrintToString(arguments) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("are the same file")) << testing::PrintToString(arguments);
    EXPECT_EQ(state(), before) << testing::PrintToString(arguments);
  }
};

TEST_F(OutputsTest, AFullDiskDoesNotAffectOtherFiles) {
  make_full("full.exr");
  const Outcome outcome = render("builtin:cornell", {"-o", "full.exr", "-o", "ok.png", "--stats", "s.json"});
  EXPECT_TRUE(refused(outcome, {"warning: full.exr", "No space left on device", "not written: full.exr"}));
  EXPECT_EQ(read_image(path("ok.png")).width(), 16);
  EXPECT_EQ(read_json("s.json").at("passes"), 1);
  make_full("full.json");
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "late.png", "--stats", "full.json"}), {"full.json"}));
  EXPECT_EQ(read_image(path("late.png")).width(), 16);
}

/// By the limit of file sizes, which the checkpoint reaches and the picture does not.
TEST_F(OutputsTest, AFailedCheckpointLosesNoPicture) {
  const auto limit = [] {
    const rlimit bytes = {12'000, 12'000};
    setrlimit(RLIMIT_FSIZE, &bytes);
  };
  const Outcome outcome = render("builtin:cornell", {"--size", "32x32", "-o", "ok.png", "--resume=c.ck"}, limit);
  EXPECT_TRUE(refused(outcome, {"warning: c.ck", "not written: c.ck"}));
  EXPECT_EQ(read_image(path("ok.png")).width(), 32);
  EXPECT_THAT(names(), ElementsAre("ok.png"));
}

TEST_F(OutputsTest, AFailedPreviewIsReportedOnceAndTheRenderContinues) {
  make_full("full.exr");
  const Outcome outcome = render("builtin:cornell", {"-o", "full.exr", "-o", "ok.png", "--preview", "--samples", "auto",
                                                     "--time", "2.5s", "--stats", "s.json"});
  EXPECT_TRUE(refused(outcome, {"not written: full.exr"}));
  EXPECT_EQ(count_of(outcome.err, "warning: full.exr"), 1u) << outcome.err;
  EXPECT_EQ(read_image(path("ok.png")).width(), 16);
  EXPECT_EQ(read_json("s.json").at("ending"), "time_up");
}

/// `render ... 2>&1 | true`, `2>/dev/full` and `2>&-`.
TEST_F(OutputsTest, UnreadMessagesLoseNoPicture) {
  const std::function<void()> streams[] = {[] {
                                             int ends[2];
                                             if (pipe(ends) != 0) _exit(99);
                                             close(ends[0]);
                                             dup2(ends[1], STDOUT_FILENO);
                                             dup2(ends[1], STDERR_FILENO);
                                             signal(SIGPIPE, SIG_DFL);
                                           },
                                           [] { dup2(open("/dev/full", O_WRONLY), STDERR_FILENO); },
                                           [] {
                                             close(STDIN_FILENO);
                                             close(STDOUT_FILENO);
                                             close(STDERR_FILENO);
                                           }};
  for (const auto& prepare : streams) {
    const Outcome outcome = render("builtin:cornell", {"-v", "-o", "a.exr", "-o", "b.png"}, prepare);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(read_image(path("a.exr")).width(), 16);
    EXPECT_EQ(read_image(path("b.png")).width(), 16);
    for (const std::string& name : names()) fs::remove(folder_ / name);
  }
}

TEST_F(OutputsTest, AStandardOutputThatIsFullIsAnError) {
  const auto full = [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); };
  EXPECT_TRUE(refused(run({"info", "builtin:cornell"}, full), {"standard output"}));
  EXPECT_EQ(run({"--help"}, full).status, 1);
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.exr", "-q"}).status, 0);
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "-o", "d.png"}, full), {"standard output"}));
  EXPECT_EQ(read_image(path("d.png")).width(), 16);
}

TEST_F(OutputsTest, NamesThatAreNotUtf8DoNotBreakStatistics) {
  write("a.mtl", "newmtl L\xe4mpchen\nKd 0 0 0\nKe 1 1 1\n");
  const std::string scene = write("a.obj", "mtllib a.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl L\xe4mpchen\nf 1 2 3\n");
  const Outcome outcome = render(scene, {"-o", "a.exr", "--stats", "s.json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_json("s.json").at("passes"), 1);
}

TEST_F(OutputsTest, TwoOutputsWithOneNameAreRejected) {
  const std::string scene = write("a.obj", "v -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\n");
  write("old.exr", "older");
  fs::create_symlink("old.exr", path("link.exr"));
  fs::create_symlink("new.exr", path("dangling.exr"));
  fs::create_hard_link(path("old.exr"), path("hard.exr"));
  fs::create_directory_symlink(".", path("here"));
  const std::vector<std::vector<std::string>> cases = {
      {"-o", "a.exr", "-o", "./a.exr"},
      {"-o", "a.png", "--stats", "a.png"},
      {"-o", "a.exr", "--resume=a.exr"},
      {"-o", "a.exr", "--stats", "a.exr.checkpoint", "--resume"},
      {"-o", "a.exr", "--stats", "b", "--resume=b"},
      {"-o", "old.exr", "-o", "link.exr"},
      {"-o", "old.exr", "-o", "hard.exr"},
      {"-o", "new.exr", "-o", "dangling.exr"},
      {"-o", "a.exr", "-o", "here/a.exr"},
      {"-o", "a.exr", "--stats", "a.obj"},
      {"-o", "a.exr", "--resume=here/a.obj"},
  };
  for (std::vector<std::string> arguments : cases) {
    arguments.insert(arguments.begin(), {"render", scene});
    expect_one_file(arguments);
  }
}

/// Files that only reading the scene brings to light.
TEST_F(OutputsTest, FilesOfTheSceneAreNotOverwritten) {
  write_scenes();
  const std::string pbrt = path("a.pbrt"), obj = path("a.obj"), gltf = path("a.gltf");
  fs::create_symlink("sky.exr", path("link.exr"));
  const std::vector<std::string> tiny = {"--size", "8x8", "--samples", "1", "--photons", "100"};
  const auto render_of = [&](const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render", scene};
    all.insert(all.end(), tiny.begin(), tiny.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  expect_one_file(render_of(pbrt, {"-o", "wood.png", "--preview"}));
  expect_one_file(render_of(pbrt, {"-o", "link.exr"}));
  expect_one_file(render_of(pbrt, {"-o", "x.exr", "--stats", "./inner.pbrt"}));
  expect_one_file(render_of(pbrt, {"-o", "x.exr", "--stats", "part.ply"}));
  expect_one_file(render_of(obj, {"-o", "wood.png"}));
  expect_one_file(render_of(obj, {"-o", "x.exr", "--stats", "a.mtl"}));
  expect_one_file(render_of(gltf, {"-o", "x.exr", "--stats", "a.bin"}));
  // A session's frames and screenshots, too.
  fs::create_directory(path("frames"));
  fs::copy_file(path("wood.png"), path("frames/00001.png"));
  const std::string framed = write("framed.obj", "mtllib b.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl m\nf 1 2 3\n");
  write("b.mtl", "newmtl m\nmap_Kd frames/00001.png\n");
  expect_one_file({"view", framed, "--frames", "3", "--size", "8x8", "--out", "frames"});
  EXPECT_THAT(run(render_of(pbrt, {"-o", "wood.png"})).err, HasSubstr("'" + path("wood.png") + "' and -o"));
}

TEST_F(OutputsTest, AnUnreadPipeLosesNoOtherFile) {
  ASSERT_EQ(mkfifo(path("pipe.exr").c_str(), 0600), 0);
  const Outcome outcome = render("builtin:cornell", {"-o", "pipe.exr", "-o", "ok.png"});
  EXPECT_TRUE(
      refused(outcome, {"pipe.exr: nothing reads from this pipe", "Start the program", "not written: pipe.exr"}));
  EXPECT_EQ(read_image(path("ok.png")).width(), 16);
}

TEST_F(OutputsTest, APipeTakesAPictureAsAFileDoes) {
  ASSERT_EQ(mkfifo(path("pipe.exr").c_str(), 0600), 0);
  const int reader = open(path("pipe.exr").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_EQ(render("builtin:cornell", {"-o", "pipe.exr", "-o", "a.exr", "-q"}).status, 0);
  std::string bytes(1 << 16, '\0');
  const ssize_t count = ::read(reader, bytes.data(), bytes.size());
  close(reader);
  ASSERT_GT(count, 0);
  bytes.resize(static_cast<std::size_t>(count));
  EXPECT_EQ(bytes, read(path("a.exr")));
}

TEST_F(OutputsTest, AComparisonDoesNotOverwriteItsPictures) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.png", "-o", "b.png", "-q"}).status, 0);
  expect_one_file({"compare", "a.png", "b.png", "-o", "a.png"});
  expect_one_file({"compare", "a.png", "b.png", "-o", "./b.png"});
}

TEST_F(OutputsTest, FilesOfASessionMustDiffer) {
  const std::string scene = write("scene.obj", "v -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\n");
  fs::create_directory(path("frames"));
  fs::create_symlink("../scene.obj", path("frames/00002.png"));
  const std::vector<std::string> view = {"view", scene, "--script", "script.json", "--out"};
  const auto played = [&](const std::string& screenshot, const std::string& folder) {
    write("script.json", R"({"frames": 4, "size": [8, 8], "moves": [{"at": 1, "screenshot": ")" + screenshot + "\"}]}");
    std::vector<std::string> arguments = view;
    arguments.push_back(folder);
    return arguments;
  };
  expect_one_file(played("shot.png", "frames"));  // by its third frame
  expect_one_file(played("00001.png", "new"));
  expect_one_file(played("./00001.png", "new"));
  EXPECT_FALSE(fs::exists(path("new")));
}

TEST_F(OutputsTest, AFailedFrameDoesNotEndTheSession) {
  fs::create_directory(path("frames"));
  make_full("frames/00001.png");
  const Outcome outcome =
      run({"view", "builtin:cornell", "--size", "8x8", "--photons", "1k", "--frames", "4", "--out", "frames"});
  EXPECT_TRUE(refused(outcome, {"wrote 3 frames and frames.csv", "not written: frames/00001.png"}));
  EXPECT_EQ(read_image(path("frames/00003.png")).width(), 8);
  const std::string table = read(path("frames/frames.csv"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5);
}

/// Frames of a view at rest are sums of passes, and come from the filter; the first frame does not.
TEST_F(OutputsTest, ARestingViewKeepsTheLightOfMedia) {
  const Outcome outcome = run({"view", "builtin:window-room", "--haze", "5m", "--size", "24x24", "--photons", "5k",
                               "--frames", "4", "--format", "exr", "--out", "frames"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto mean = [&](const std::string& name) {
    const std::vector<RGB> pixels = read_image(path(name)).rgb();
    return luminance(std::accumulate(pixels.begin(), pixels.end(), RGB())) / static_cast<float>(pixels.size());
  };
  // Without it 5% are left.
  EXPECT_NEAR(mean("frames/00003.exr") / mean("frames/00000.exr"), 1, 0.1f);
}

TEST_F(OutputsTest, AnInterruptedSessionCountsItsFrames) {
  Running program(
      folder_, {"view", "builtin:cornell", "--size", "8x8", "--photons", "1k", "--frames", "5000", "--out", "frames"});
  ASSERT_TRUE(wait_for_file("frames/00002.png", 60));
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 128 + SIGINT);
  std::size_t frames = 0;
  for (const auto& entry : fs::directory_iterator(path("frames"))) frames += entry.path().extension() == ".png";
  EXPECT_GE(frames, 3u);
  EXPECT_LT(frames, 5000u);
  EXPECT_THAT(outcome.err, HasSubstr("wrote " + std::to_string(frames) + " frames and frames.csv"));
}

TEST_F(OutputsTest, ASessionThatFailsKeepsTheTableOfItsFrames) {
  write("script.json", R"({"frames": 4, "size": [8, 8], "moves": [{"at": 2, "drop": "missing.obj"}]})");
  const Outcome outcome =
      run({"view", "builtin:cornell", "--photons", "1k", "--script", "script.json", "--out", "frames"});
  EXPECT_TRUE(refused(outcome, {"missing.obj", "wrote 2 frames and frames.csv"}));
  const std::string table = read(path("frames/frames.csv"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
}

}  // namespace
}  // namespace glowworm
