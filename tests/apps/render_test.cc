// Results of a render: images with layers and metadata, statistics and exit status.
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "film/checkpoint.h"
#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class RenderTest : public ProgramTest {
 protected:
  Image rendered(const std::string& scene, std::vector<std::string> more, const std::string& name = "a.exr") {
    more.insert(more.end(), {"-o", name, "-q", "--precision", "float"});
    const Outcome outcome = render(scene, more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return read_image(path(name));
  }
  static bool same_pixels(const Image& a, const Image& b) {
    if (a.channels().size() != b.channels().size()) return false;
    for (std::size_t i = 0; i < a.channels().size(); ++i)
      if (a.channels()[i].name != b.channels()[i].name || a.channels()[i].samples != b.channels()[i].samples)
        return false;
    return true;
  }
};
using SlowRenderTest = RenderTest;

TEST_F(RenderTest, HelpNamesEnginesScenesAndExamples) {
  const Outcome outcome = run({"render", "--help"});
  EXPECT_EQ(outcome.status, 0);
  for (const char* text : {"auto|blocked|", "builtin:atrium", "Examples:", "metres", "--gather", "130"})
    EXPECT_THAT(outcome.out, HasSubstr(text));
  EXPECT_EQ(run({"--help"}).status, 0);
  EXPECT_THAT(run({"--version"}).out, HasSubstr("glowworm "));
}

TEST_F(RenderTest, HelpNamesWhatEachOptionTakes) {
  for (const char* command : {"render", "bake", "measure", "daylight", "glare", "view", "info", "compare", "merge"}) {
    const std::string help = run({command, "--help"}).out;
    // CLI11's own names of types.
    for (const char* type : {" TEXT ", " INT ", " UINT ", " FLOAT "})
      EXPECT_EQ(help.find(type), std::string::npos) << command << type;
  }
}

TEST_F(RenderTest, SameSeedSamePixels) {
  for (const std::vector<std::string>& method :
       {std::vector<std::string>{"--engine", "knn"}, {"--engine", "blocked"}, {"--integrator", "path"}}) {
    std::vector<std::string> two = method;
    two.insert(two.end(), {"--seed", "7", "--threads", "2"});
    std::vector<std::string> one = method, other = method;
    one.insert(one.end(), {"--seed", "7", "--threads", "1"});
    other.insert(other.end(), {"--seed", "8"});
    const Image first = rendered("builtin:cornell", two), again = rendered("builtin:cornell", two, "b.exr");
    EXPECT_TRUE(same_pixels(first, again)) << method[1];
    EXPECT_TRUE(same_pixels(first, rendered("builtin:cornell", one))) << method[1];
    EXPECT_FALSE(same_pixels(first, rendered("builtin:cornell", other))) << method[1];
  }
}

TEST_F(RenderTest, LayersAddUpAndHaveTheirMeaning) {
  const Image image = rendered("builtin:cornell", {"--aov", "emitted,direct,indirect,caustic,albedo,normal,depth"});
  std::set<std::string> found;
  for (const ImageChannel& channel : image.channels()) found.insert(channel.name);
  for (const char* layer : {"emitted", "direct", "indirect", "caustic", "albedo"})
    for (const char* channel : {".R", ".G", ".B"}) EXPECT_EQ(found.count(std::string(layer) + channel), 1u) << layer;
  for (const char* name : {"R", "G", "B", "normal.X", "normal.Y", "normal.Z", "depth.Z"})
    EXPECT_EQ(found.count(name), 1u) << name;
  const auto all = image.channel("R");
  double sum = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    float parts = 0;
    for (const char* name : {"emitted.R", "direct.R", "indirect.R", "caustic.R"}) parts += image.channel(name)[i];
    EXPECT_NEAR(all[i], parts, 1e-5f * (1 + parts));
    sum += image.channel("indirect.R")[i];
    // The box is open towards the camera and no pixel sees past it from a metre away.
    if (!std::isfinite(image.channel("depth.Z")[i])) continue;
    EXPECT_GT(image.channel("depth.Z")[i], 0.5f);
    const float x = image.channel("normal.X")[i], y = image.channel("normal.Y")[i], z = image.channel("normal.Z")[i];
    EXPECT_NEAR(std::hypot(x, y, z), 1, 1e-4f);
    EXPECT_LE(image.channel("albedo.R")[i], 1);
  }
  EXPECT_GT(sum, 0);
}

TEST_F(RenderTest, IndirectOnlyIsTheIndirectLayer) {
  const Image image = rendered("builtin:cornell", {"--indirect-only", "--aov", "indirect,direct", "--filter", "off"});
  const auto all = image.channel("G"), indirect = image.channel("indirect.G"), direct = image.channel("direct.G");
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    EXPECT_EQ(all[i], indirect[i]);
    EXPECT_EQ(direct[i], 0);
  }
}

TEST_F(RenderTest, MetadataRecordsTheCommandLine) {
  const Image image = rendered("builtin:cornell", {"--seed", "5"});
  EXPECT_THAT(image.metadata.at("Software"), HasSubstr("Glowworm"));
  EXPECT_EQ(image.metadata.at("glowworm:scene"), "cornell");
  EXPECT_EQ(image.metadata.at("glowworm:seed"), "5");
  EXPECT_EQ(image.metadata.at("glowworm:passes"), "1");
  EXPECT_GT(std::stod(image.metadata.at("glowworm:seconds")), 0);
  const auto settings = nlohmann::json::parse(image.metadata.at("glowworm:settings"));
  EXPECT_EQ(settings.at("gather"), 4);
  EXPECT_EQ(settings.at("photons"), 2000);
  EXPECT_NE(settings.at("engine"), "auto");
}

TEST_F(RenderTest, PngCurvesAndExposure) {
  const auto mean_of = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o", name, "-q"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(render("builtin:cornell", arguments).status, 0);
    const Image image = read_image(path(name));
    double sum = 0;
    for (const float v : image.channel("G")) {
      EXPECT_TRUE(v >= 0 && v <= 1);
      sum += v;
    }
    return sum / static_cast<double>(image.pixel_count());
  };
  const double filmic = mean_of("filmic.png", {}), srgb = mean_of("srgb.png", {"--tone", "srgb", "--exposure", "0"});
  EXPECT_NE(filmic, srgb);
  EXPECT_GT(mean_of("bright.png", {"--tone", "srgb", "--exposure", "2"}), 1.5 * srgb);
  EXPECT_LT(mean_of("dark.png", {"--tone", "srgb", "--exposure", "-3"}), 0.5 * srgb);
}

TEST_F(RenderTest, SeveralOutputsOfOneRender) {
  const Outcome outcome = render("builtin:cornell", {"-o", "a.exr", "-o", "a.png", "--stats", "a.json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(names(), ElementsAre("a.exr", "a.json", "a.png"));
  EXPECT_THAT(outcome.err, HasSubstr("wrote a.exr"));
  EXPECT_THAT(outcome.err, HasSubstr("wrote a.png"));
  EXPECT_THAT(outcome.out, IsEmpty());
}

TEST_F(RenderTest, QuietAndVerbose) {
  EXPECT_THAT(render("builtin:cornell", {"-o", "a.png", "-q"}).err, IsEmpty());
  EXPECT_THAT(render("builtin:cornell", {"-o", "a.png"}).err, Not(HasSubstr("trace_photons")));
  EXPECT_THAT(render("builtin:cornell", {"-o", "a.png", "-v"}).err, HasSubstr("trace_photons"));
}

TEST_F(RenderTest, OptionsWithoutEffectAreReported) {
  const Outcome outcome = render("builtin:cornell", {"-o", "a.png", "-q", "--integrator", "path", "--engine", "knn"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.err, HasSubstr("warning: --engine has no effect"));
}

TEST_F(RenderTest, TimeLimitEndsItWithAWholeImage) {
  const Outcome outcome = render(
      "builtin:cornell", {"-o", "a.exr", "--stats", "a.json", "--samples", "auto", "--time", "1s", "--threads", "2"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto statistics = read_json("a.json");
  EXPECT_EQ(statistics.at("ending"), "time_up");
  EXPECT_GE(statistics.at("passes"), 1);
  EXPECT_EQ(read_image(path("a.exr")).width(), 16);
}

TEST_F(RenderTest, NoiseTargetEndsIt) {
  const Outcome outcome =
      render("builtin:cornell", {"-o", "a.exr", "--stats", "a.json", "--samples", "auto", "--noise", "0.5"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto statistics = read_json("a.json");
  EXPECT_EQ(statistics.at("ending"), "noise_reached");
  EXPECT_GE(statistics.at("passes"), 2);
}

/// Time of the processor that a process has used.
double processor_seconds(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  // The name of the program, in parentheses, is the second field; user and system time are fields 14 and 15.
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  double ticks = 0;
  for (int field = 3; field <= 15 && fields >> text; ++field)
    if (field >= 14) ticks += std::stod(text);
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

TEST_F(SlowRenderTest, InterruptWritesTheImageSoFar) {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    Running program(folder_, {"render", "builtin:cornell", "--size", "64x64", "--samples", "1M", "--gather", "4",
                              "--photons", "2k", "-o", "a.exr", "-o", "a.png", "--stats", "a.json"});
    ASSERT_TRUE(program.wait_for_text("64x64", 60));
    // Time of the processor, so that a busy or slow machine has rendered something, too.
    ASSERT_TRUE(wait_until([&] { return processor_seconds(program.id()) > 2.5; }, 300));
    program.send(signal_number);
    // A terminal that closes may send two.
    if (signal_number == SIGHUP) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      program.send(SIGHUP);
    }
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.status, 128 + signal_number) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("interrupted"));
    EXPECT_THAT(names(), ElementsAre("a.exr", "a.json", "a.png"));
    const Image image = read_image(path("a.exr"));
    EXPECT_EQ(image.metadata.at("glowworm:scene"), "cornell");
    EXPECT_EQ(read_json("a.json").at("ending"), "cancelled");
    for (const std::string& name : names()) std::filesystem::remove(folder_ / name);
  }
}

TEST_F(RenderTest, ResumedRenderIsTheSameAsOneInOneGo) {
  const Image whole = rendered("builtin:cornell", {"--samples", "4"});
  rendered("builtin:cornell", {"--samples", "2", "--resume", "c.checkpoint"}, "b.exr");
  EXPECT_TRUE(same_pixels(whole, rendered("builtin:cornell", {"--samples", "4", "--resume", "c.checkpoint"}, "c.exr")));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--seed", "9", "--resume", "c.checkpoint"}), {"another render"}));
  write("d.checkpoint", "no checkpoint");
  EXPECT_TRUE(refused(render("builtin:cornell", {"--resume", "d.checkpoint"}), {"d.checkpoint"}));
}

TEST_F(RenderTest, SecondInterruptEndsAtOnceAndLeavesNothing) {
  // The first interrupt waits for the end of the task, which with so many gather rays is far away.
  Running program(folder_,
                  {"render", "builtin:cornell", "--size", "16x16", "--photons", "2k", "--gather", "1M", "-o", "a.exr"});
  ASSERT_TRUE(program.wait_for_text("16x16", 60));
  program.send(SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 128 + SIGINT);
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(RenderTest, InterruptDuringThePhotonPassEndsAtOnce) {
  Running program(folder_, {"render", "builtin:cornell", "--size", "16x16", "--photons", "100M", "--memory", "900G",
                            "-o", "a.exr"});
  ASSERT_TRUE(program.wait_for_text("16x16", 60));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto start = std::chrono::steady_clock::now();
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 128 + SIGINT);
  EXPECT_THAT(outcome.err, HasSubstr("no image was written"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(RenderTest, InterruptWhileASceneIsLoadedEndsAtOnce) {
  // A DAE file whose node holds the one before it twice: Assimp makes 2^40 of them.
  std::string nodes = "<node id=\"n0\"/>";
  for (int i = 1; i < 40; ++i) {
    const std::string before = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
    nodes += "<node id=\"n" + std::to_string(i) + "\">" + before + before + "</node>";
  }
  write("laughs.dae",
        "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\" xmlns=\"http://www.collada.org/2005/11/COLLADASchema\">"
        "<library_nodes>" +
            nodes +
            "</library_nodes><library_visual_scenes><visual_scene id=\"s\"><node><instance_node url=\"#n39\"/></node>"
            "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
  Running program(folder_, {"render", "laughs.dae", "--size", "16x16", "-o", "a.exr"});
  // proc(5): the processes that a thread has started.
  const std::string id = std::to_string(program.id());
  std::string child;
  ASSERT_TRUE(wait_until(
      [&] {
        child = read("/proc/" + id + "/task/" + id + "/children");
        return !child.empty();
      },
      60));
  const auto start = std::chrono::steady_clock::now();
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 128 + SIGINT);
  const auto has_ended = [&] {
    const std::string state = read("/proc/" + std::to_string(std::stoi(child)) + "/stat");
    return state.empty() || state.find(") Z ") != std::string::npos;
  };
  EXPECT_TRUE(wait_until(has_ended, 5));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_THAT(names(), ElementsAre("laughs.dae"));
}

TEST_F(RenderTest, PreviewIsOnDiskWhileTheRenderGoesOn) {
  Running program(folder_, {"render", "builtin:cornell", "--size", "32x32", "--samples", "1M", "--gather", "4",
                            "--photons", "2k", "--preview", "-o", "a.exr", "-o", "a.png", "-q"});
  const auto passes = [&] { return std::stoul(read_image(path("a.exr")).metadata.at("glowworm:passes")); };
  ASSERT_TRUE(wait_for_file("a.png", 60));
  const auto first = passes();
  EXPECT_EQ(read_image(path("a.png")).width(), 32);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (passes() == first && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GT(passes(), first);
  program.send(SIGKILL);
  EXPECT_EQ(program.wait().status, 128 + SIGKILL);
  // What was written last is whole, and but for a file that was being written nothing else is there.
  EXPECT_GE(passes(), first);
  EXPECT_LE(names().size(), 3u);
}

TEST_F(RenderTest, KilledRenderResumesToTheSameBits) {
  const std::vector<std::string> kinds[] = {
      {"--engine", "reverse"}, {"--progressive", "--engine", "blocked"}, {"--integrator", "path"}};
  for (const std::vector<std::string>& kind : kinds) {
    std::vector<std::string> options = {"--size", "48x40", "--aov", "direct,normal,depth"};
    options.insert(options.end(), kind.begin(), kind.end());
    std::vector<std::string> endless = {"render", "builtin:cornell", "-q", "--samples", "1M", "--resume=c.checkpoint"};
    if (kind.front() != "--integrator")
      endless.insert(endless.end(), {"--gather", "4", "--photons", "2k", "--no-guiding"});
    endless.insert(endless.end(), options.begin(), options.end());
    {
      Running program(folder_, endless);
      ASSERT_TRUE(wait_for_file("c.checkpoint", 60)) << kind.front();
      // A machine that is slow at the time writes its first before a pass is whole.
      ASSERT_TRUE(wait_until([&] { return read_checkpoint(path("c.checkpoint"))->passes > 0; }, 60)) << kind.front();
      program.send(SIGKILL);
      ASSERT_EQ(program.wait().status, 128 + SIGKILL) << kind.front();
    }
    const std::uint32_t passes = read_checkpoint(path("c.checkpoint"))->passes;
    // So many that the pass under way is one of theirs: tiles that had all its samples already keep them.
    const std::uint32_t more = 64;
    options.insert(options.end(), {"--samples", std::to_string(passes + more)});
    const Image whole = rendered("builtin:cornell", options);
    options.push_back("--resume=c.checkpoint");
    EXPECT_TRUE(same_pixels(whole, rendered("builtin:cornell", options, "b.exr"))) << kind.front();
    EXPECT_EQ(read_checkpoint(path("c.checkpoint"))->passes, passes + more);
    std::filesystem::remove(folder_ / "c.checkpoint");
  }
}

TEST_F(RenderTest, ResumeWithoutANameUsesThatOfTheImage) {
  const Image whole = rendered("builtin:cornell", {"--samples", "3"});
  EXPECT_EQ(
      render("builtin:cornell", {"--samples", "2", "-o", "b.exr", "-q", "--precision", "float", "--resume"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "b.exr.checkpoint"));
  EXPECT_EQ(
      render("builtin:cornell", {"--samples", "3", "-o", "b.exr", "-q", "--precision", "float", "--resume"}).status, 0);
  EXPECT_TRUE(same_pixels(whole, read_image(path("b.exr"))));
}

TEST_F(RenderTest, IgnoredInterruptsStayIgnored) {
  const Outcome outcome = render("builtin:cornell", {"-o", "a.png", "-q"}, [] {
    signal(SIGINT, SIG_IGN);
    raise(SIGINT);
  });
  EXPECT_EQ(outcome.status, 0);
}

}  // namespace
}  // namespace glowworm
