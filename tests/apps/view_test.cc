// `glowworm view` without a window, and in a window under Xvfb with Mesa's software OpenGL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <thread>

#include "apps/program.h"
#include "apps/xvfb.h"
#include "image/image.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

constexpr int kPatchSide = 128;

/// Mean absolute difference of encoded values over the upper left kPatchSide x kPatchSide pixels: what a person sees of
/// it.
double difference(const std::string& a, const std::string& b) {
  const Image first = read_image(a), second = read_image(b);
  const std::vector<RGB> x = first.rgb(), y = second.rgb();
  double sum = 0;
  for (int row = 0; row < kPatchSide; ++row)
    for (int column = 0; column < kPatchSide; ++column) {
      const RGB p = x[static_cast<std::size_t>(row * first.width() + column)];
      const RGB q = y[static_cast<std::size_t>(row * second.width() + column)];
      for (int c = 0; c < 3; ++c) sum += std::abs(srgb_encode(p[c]) - srgb_encode(q[c]));
    }
  return sum / (3.0 * kPatchSide * kPatchSide);
}

/// Root of the mean squared difference of luminance, over the mean.
double relative_difference(const Image& a, const Image& b) {
  double sum = 0, mean = 0;
  for (std::size_t i = 0; i < b.rgb().size(); ++i) {
    const double wanted = luminance(b.rgb()[i]), difference = luminance(a.rgb()[i]) - wanted;
    sum += difference * difference;
    mean += wanted;
  }
  return std::sqrt(sum * static_cast<double>(b.rgb().size())) / mean;
}

class ViewTest : public ProgramTest {
 protected:
  std::vector<std::string> view(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"view", "builtin:cornell", "--photons", "20k"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(ViewTest, WritesFramesWithoutAWindow) {
  write(
      "moves.json",
      R"({"size": [24, 16], "moves": [{"from": 1, "to": 4, "orbit": [20, 0]}, {"at": 3, "screenshot": "shot.exr"}]})");
  unsetenv("DISPLAY");
  const Outcome outcome = run(view({"--script", "moves.json", "--frames", "5", "--out", "frames"}));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(read_image(path("frames/0000" + std::to_string(i) + ".png")).width(), 24);
  EXPECT_TRUE(read_image(path("frames/shot.exr")).has_channel("depth.Z"));
  const std::string table = read(path("frames/frames.csv"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 6);
  EXPECT_THAT(table, HasSubstr("frame,seconds,"));
}

TEST_F(ViewTest, PlaysTheAnimationOfTheScene) {
  write("a.pbrt", R"(LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
ActiveTransform EndTime Translate 1 0 0 ActiveTransform All
AreaLightSource "diffuse" "rgb L" [4 4 4] "bool twosided" true
Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [-1 -.3 0  -.4 -.3 0  -.7 .3 0]
)");
  write("moves.json", R"({"size": [24, 16], "moves": [{"from": 1, "to": 3, "seconds": 1}]})");
  const Outcome outcome = run({"view", "a.pbrt", "--photons", "1k", "--script", "moves.json", "--frames", "3",
                               "--format", "exr", "--no-reuse", "--out", "frames"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  /// Column of the light's middle.
  const auto place = [&](int frame) {
    const Image image = read_image(path("frames/0000" + std::to_string(frame) + ".exr"));
    const std::vector<RGB> light = image.rgb();
    double sum = 0, moment = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      sum += luminance(light[i]);
      moment += luminance(light[i]) * static_cast<double>(i % 24);
    }
    return moment / sum;
  };
  const double all = place(2) - place(0);
  EXPECT_GT(std::abs(all), 3);
  EXPECT_NEAR((place(1) - place(0)) / all, 0.5, 0.15);
}

TEST_F(ViewTest, FiltersAViewAtRestAsARenderDoes) {
  const std::vector<std::string> effort = {"--size", "48x36", "--gather", "4", "--nearest", "50"};
  for (const std::string filter : {"auto", "off"}) {
    std::vector<std::string> shown = {"--filter", filter, "--frames", "4", "--format", "exr", "--out", filter};
    shown.insert(shown.end(), effort.begin(), effort.end());
    if (filter == "off") shown.push_back("--no-reuse");
    ASSERT_EQ(run(view(shown)).status, 0);
    std::vector<std::string> rendered = {"--photons", "20k",  "--samples", "3",
                                         "--filter",  filter, "-o",        filter + ".exr"};
    rendered.insert(rendered.end(), effort.begin(), effort.end());
    ASSERT_EQ(render("builtin:cornell", rendered).status, 0);
    EXPECT_LT(relative_difference(read_image(path(filter + "/00003.exr")), read_image(path(filter + ".exr"))), 1e-3)
        << filter;
  }
  EXPECT_GT(relative_difference(read_image(path("auto/00003.exr")), read_image(path("off.exr"))), 0.01);
}

TEST_F(ViewTest, ReportsErrors) {
  write("bad.json", R"({"moves": [{"dance": 1}]})");
  EXPECT_TRUE(refused(run(view({"--script", "bad.json", "--out", "frames"})), {"bad.json: move 1", "\"dance\""}));
  EXPECT_TRUE(refused(run(view({"--engine", "none", "--out", "frames"})), {"--engine 'none'"}, 2));
  EXPECT_TRUE(refused(run({"view", "none.gltf", "--out", "frames"}), {"none.gltf"}));
  EXPECT_TRUE(refused(run(view({"--out", "/dev/null/frames"})), {"/dev/null/frames"}));
  unsetenv("DISPLAY");
  EXPECT_TRUE(refused(run(view({})), {"no window can be opened", "--out"}));
}

TEST_F(ViewTest, RendersTheViewOfACommand) {
  const Outcome outcome = render("builtin:cornell", {"--view", "2.78,2.73,-6,2.78,2.73,0,0,1,0", "--light",
                                                     "0,scale=2,move=0.2:0:0", "--kernel", "cone", "-o", "a.exr"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(refused(render("builtin:cornell", {"--view", "1,2,3"}), {"--view '1,2,3'", "nine numbers"}, 2));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--light", "moon,off"}), {"'moon'"}, 2));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--tev", "127.0.0.1:1"}), {"--tev", "Start tev"}));
}

/// Tests with a screen. One X server serves them all. Slow, also since Mesa's drivers lose some bytes when they are
/// unloaded, which the leak sanitizer would count and cannot be told to pass over.
class SlowWindowTest : public ViewTest {
 protected:
  static void SetUpTestSuite() {
    try {
      screen_ = std::make_unique<Xvfb>();
    } catch (const std::exception& error) {
      FAIL() << error.what();
    }
  }
  static void TearDownTestSuite() { screen_.reset(); }
  void SetUp() override {
    ViewTest::SetUp();
    ASSERT_TRUE(screen_) << "there is no screen";
    setenv("DISPLAY", screen_->display().c_str(), 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  }

  /// Sends mouse and keys, as a person would, by xdotool; true where that worked.
  bool input(const std::string& commands) const {
    return std::system(("xdotool " + commands + " > /dev/null 2>&1").c_str()) == 0;
  }
  /// Presses F12 and waits for the picture; false where none comes.
  bool take_screenshot(const Running& program, const std::string& name) const {
    const std::string shot = path("screenshot.png");
    std::filesystem::remove(shot);
    for (int i = 0; i < 100 && !std::filesystem::exists(shot); ++i) {
      if (i % 20 == 0 && !input("search --name glowworm windowfocus key F12")) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (!program.errors_so_far().empty() && program.errors_so_far().find("error:") != std::string::npos) return false;
    }
    if (!std::filesystem::exists(shot)) return false;
    std::filesystem::rename(shot, path(name));
    return true;
  }

  static std::unique_ptr<Xvfb> screen_;
};

std::unique_ptr<Xvfb> SlowWindowTest::screen_;

/// The script of one state: where the camera is, what the lamp does, which mode.
struct StateOfView {
  const char* name;
  const char* move;
};
constexpr StateOfView kStates[] = {
    {"start", R"({"at": 0})"},
    {"orbit", R"({"from": 0, "to": 4, "orbit": [25, 8]})"},
    {"lamp", R"({"at": 0, "light": {"name": "0", "move": [-0.12, -0.2, 0.1], "scale": 1.5}})"},
    {"photons", R"({"at": 0, "mode": "photons"})"},
    {"normal", R"({"at": 0, "mode": "normal"})"},
};

/// What the window shows of a state is what a session without a window renders of it, and of no other state.
TEST_F(SlowWindowTest, ShowsWhatASessionRenders) {
  constexpr int kFrames = 12;
  for (const StateOfView& state : kStates) {
    const std::string script = std::string(R"({"size": [128, 128], "moves": [)") + state.move + R"(, {"at": )" +
                               std::to_string(kFrames - 1) + R"(, "screenshot": ")" + state.name + R"(-window.png"}]})";
    write("script.json", script);
    // A window that shows few frames a second has time for whole ones on a busy machine.
    const std::vector<std::string> options = {"--script", "script.json",           "--exposure", "0",
                                              "--frames", std::to_string(kFrames), "--fps",      "1"};
    const Outcome shown = run(view(options));
    ASSERT_EQ(shown.status, 0) << shown.err;
    std::filesystem::rename(path(std::string(state.name) + "-window.png"),
                            path(std::string(state.name) + "-shown.png"));
    std::vector<std::string> headless = options;
    headless.insert(headless.end(), {"--out", std::string("frames-") + state.name});
    const Outcome rendered = run(view(headless));
    ASSERT_EQ(rendered.status, 0) << rendered.err;
  }
  const auto frame = [&](const StateOfView& s) { return path(std::string("frames-") + s.name + "/00011.png"); };
  for (const StateOfView& window : kStates) {
    const std::string shown = path(std::string(window.name) + "-shown.png");
    const double own = difference(shown, frame(window));
    // Noise of different samples; of surfaces alone, there is only that of edges.
    EXPECT_LT(own, 0.03) << window.name;
    for (const StateOfView& other : kStates) {
      if (other.name == window.name) continue;
      EXPECT_GT(difference(shown, frame(other)), 1.5 * own) << window.name << other.name;
    }
  }
}

TEST_F(SlowWindowTest, FollowsMouseAndKeys) {
  Running program(folder_, view({"--size", "128x128", "--mode", "albedo"}));
  ASSERT_TRUE(input("search --sync --onlyvisible --name glowworm windowmove --sync 0 0")) << "is xdotool installed?";
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  ASSERT_TRUE(take_screenshot(program, "before.png")) << program.errors_so_far();
  // The way to the place of a press is not a drag.
  ASSERT_TRUE(input("mousemove 20 64 sleep 0.3 mousemove 100 64 mousedown 1 sleep 0.3 mouseup 1"));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  ASSERT_TRUE(take_screenshot(program, "pressed.png"));
  EXPECT_LT(difference(path("before.png"), path("pressed.png")), 0.01);
  // Drag to orbit.
  ASSERT_TRUE(
      input("mousemove 40 64 mousedown 1 sleep 0.2 mousemove 60 64 sleep 0.2 mousemove 90 64 sleep 0.2 mouseup 1"));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  ASSERT_TRUE(take_screenshot(program, "orbit.png"));
  EXPECT_GT(difference(path("before.png"), path("orbit.png")), 0.02);
  // Fly ahead.
  ASSERT_TRUE(input("keydown w sleep 0.7 keyup w"));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  ASSERT_TRUE(take_screenshot(program, "flight.png"));
  EXPECT_GT(difference(path("orbit.png"), path("flight.png")), 0.02);
  // Nothing moves by itself.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  ASSERT_TRUE(take_screenshot(program, "rest.png"));
  EXPECT_LT(difference(path("flight.png"), path("rest.png")), 0.01);
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 130);
}

/// The panel lies right of the picture: its share of pixels that differ between two screenshots.
double panel_change(const std::string& a, const std::string& b) {
  const Image first = read_image(a), second = read_image(b);
  EXPECT_EQ(first.pixel_count(), second.pixel_count());
  const std::vector<RGB> x = first.rgb(), y = second.rgb();
  std::size_t changed = 0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    changed += static_cast<int>(i) % first.width() >= kPatchSide && x[i] != y[i];
  return static_cast<double>(changed) / static_cast<double>(x.size());
}

TEST_F(SlowWindowTest, ThePanelHasALegendHelpAndTooltips) {
  Running program(folder_, view({"--size", "128x600", "--mode", "density"}));
  ASSERT_TRUE(input("search --sync --onlyvisible --name glowworm windowmove --sync 0 0")) << "is xdotool installed?";
  ASSERT_TRUE(input("mousemove 20 300 sleep 1.5"));
  ASSERT_TRUE(take_screenshot(program, "plain.png")) << program.errors_so_far();
  // The legend below the first line runs from blue to red.
  const Image plain = read_image(path("plain.png"));
  const std::vector<RGB> pixels = plain.rgb();
  int blue = 0, red = 0;
  for (int x = kPatchSide; x < plain.width(); ++x) {
    const RGB p = pixels[static_cast<std::size_t>(31 * plain.width() + x)];
    blue += p.b > p.r + 0.3f;
    red += p.r > p.b + 0.3f;
  }
  EXPECT_GT(blue, 20);
  EXPECT_GT(red, 20);
  // Numbers in the panel change all the time, but few of its pixels.
  ASSERT_TRUE(input("sleep 0.3"));
  ASSERT_TRUE(take_screenshot(program, "later.png"));
  const double change = panel_change(path("plain.png"), path("later.png"));
  // A slow machine may draw the change a frame or two after the screenshot.
  const auto shows = [&](double expected) {
    for (int i = 0; i < 10; ++i)
      if (take_screenshot(program, "now.png") && panel_change(path("plain.png"), path("now.png")) > expected)
        return true;
    return false;
  };
  // The choices of the picture begin here.
  ASSERT_TRUE(input("mousemove 230 150"));
  EXPECT_TRUE(shows(2 * change + 0.01)) << "there is no tooltip";
  ASSERT_TRUE(input("mousemove 20 300 search --name glowworm windowfocus key F1"));
  EXPECT_TRUE(shows(0.2)) << "there is no help";
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 130);
}

TEST_F(SlowWindowTest, SurvivesResizeMinimiseLostContextAndDrops) {
  write("script.json", R"({"size": [128, 128], "moves": [
    {"at": 2, "resize": [100, 90]}, {"at": 3, "orbit": [5, 0]}, {"at": 4, "window": "minimise"}, {"at": 5, "window": "restore"},
    {"at": 6, "resize": [468, 128]}, {"at": 8, "window": "lose-context"}, {"at": 9, "light": {"name": "0", "on": false}},
    {"at": 10, "mode": "density"}, {"at": 11, "mode": "radius"}, {"at": 12, "mode": "cost"}, {"at": 13, "mode": "gather"},
    {"at": 14, "drop": "broken.gltf"}, {"at": 15, "light": {"name": "0", "on": true}},
    {"at": 18, "drop": "builtin:ring"}, {"at": 22, "screenshot": "ring.png"}, {"at": 23, "window": "close"}]})");
  write("broken.gltf", "{");
  // Automatic exposure depends on the first frame, which is small in a window.
  const Outcome outcome = run(view({"--script", "script.json", "--frames", "100", "--exposure", "0"}));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("broken.gltf"));
  write("ring.json", R"({"size": [128, 128]})");
  run({"view", "builtin:ring", "--photons", "20k", "--script", "ring.json", "--frames", "8", "--exposure", "0", "--out",
       "ring"});
  EXPECT_LT(difference(path("ring.png"), path("ring/00007.png")), 0.02);
}

TEST_F(SlowWindowTest, WritesScreenshotsByTheirEndings) {
  const auto shown = [&](const std::string& name) {
    write("script.json", R"({"size": [64, 64], "moves": [{"at": 1, "screenshot": ")" + name + R"("}]})");
    return run(view({"--script", "script.json", "--frames", "3"}));
  };
  const Outcome written = shown("a.exr");
  EXPECT_EQ(written.status, 0) << written.err;
  EXPECT_TRUE(read(path("a.exr")).starts_with("\x76\x2f\x31\x01"));
  const Outcome failed = shown("none/a.png");
  EXPECT_EQ(failed.status, 1);
  EXPECT_THAT(failed.err, HasSubstr("none/a.png"));
}

TEST_F(SlowWindowTest, EndsWithoutASceneAndWithoutAServer) {
  const Outcome outcome = run({"view", "none.gltf", "--frames", "3"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("none.gltf"));
  Xvfb other;
  setenv("DISPLAY", other.display().c_str(), 1);
  Running program(folder_, view({"--size", "128x128"}));
  ASSERT_TRUE(input("search --sync --onlyvisible --name glowworm"));
  other.kill();
  EXPECT_EQ(program.wait().status, 1);
}

/// A long session in short: every mode, engine and light edit over and over holds no more memory at its end than soon
/// after its beginning.
TEST_F(SlowWindowTest, MemoryDoesNotGrow) {
  std::string moves;
  constexpr int kRounds = 7, kRound = 12;
  for (int round = 0; round < kRounds; ++round) {
    const int at = round * kRound;
    const auto add = [&](int offset, const std::string& what) {
      moves += (moves.empty() ? "" : ",") + std::string("{\"at\": ") + std::to_string(at + offset) + ", " + what + "}";
    };
    add(0, R"("mode": "gather", "engine": "blocked", "orbit": [10, 0])");
    add(1, R"("light": {"name": "0", "move": [0.01, 0, 0]})");
    add(2, R"("mode": "photons", "engine": "forward", "filter": true)");
    add(3, R"("mode": "density")");
    add(4, R"("mode": "cost", "filter": false)");
    add(5, R"("resize": [)" + std::to_string(500 + 10 * (round % 3)) + ", 160]");
    add(7, R"("drop": "builtin:cornell")");
    if (round == 2) add(10, R"("screenshot": "early.png")");
    if (round == kRounds - 1) add(10, R"("screenshot": "late.png")");
  }
  write("script.json", R"({"size": [128, 128], "moves": [)" + moves + "]}");
  Running program(folder_, view({"--script", "script.json"}));
  const auto resident = [&](const char* marker) -> double {
    if (!program.wait_for_text(std::string("wrote ") + marker, 240)) return -1;
    std::ifstream file("/proc/" + std::to_string(program.id()) + "/statm");
    double size = 0, pages = -1;
    file >> size >> pages;
    return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
  };
  const double early = resident("early.png"), late = resident("late.png");
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_GT(early, 0);
  EXPECT_LT(late, 1.15 * early);
}

}  // namespace
}  // namespace glowworm
