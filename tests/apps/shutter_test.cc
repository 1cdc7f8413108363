// Motion blur: `render --shutter`, and shutters of pbrt files.
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "apps/program.h"
#include "image/image.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

/// A floor, above it a glowing square that crosses the picture from left to right and a bar that turns, between 0
/// and 1 s. @param camera directives before the camera's
std::string moving_scene(const std::string& camera = "") {
  return R"(LookAt 0 2 6  0 0.5 0  0 1 0
)" + camera +
         R"(
Camera "perspective" "float fov" 40 "float shutterclose" 1
Film "rgb" "integer xresolution" 16 "integer yresolution" 16
WorldBegin
Material "diffuse" "rgb reflectance" [.6 .6 .6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
AttributeBegin
  Translate 1 1.2 -1
  ActiveTransform EndTime
  Rotate 60 0 0 1
  ActiveTransform All
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -.2 0  1 -.2 0  1 .2 0  -1 .2 0]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [4 4 4] "bool twosided" true
  ActiveTransform StartTime
  Translate -0.5 1 0
  ActiveTransform EndTime
  Translate 0.5 1 0
  ActiveTransform All
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
    "point3 P" [-.3 -.3 0  .3 -.3 0  .3 .3 0  -.3 .3 0]
AttributeEnd
)";
}

/// A floor that glows, a sphere, and a camera that moves between 0 and 1 s.
constexpr const char* kMovingCamera = R"(ActiveTransform EndTime Translate 0.3 0 0 ActiveTransform All
LookAt 0 1 4  0 0.5 0  0 1 0
Camera "perspective" "float fov" 40 "float shutterclose" 1
WorldBegin
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
AreaLightSource "diffuse" "rgb L" [4 4 4]
Translate 0 1 0 Shape "sphere" "float radius" .3
)";

class ShutterTest : public ProgramTest {
 protected:
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::vector<RGB> pixels(const std::string& name) const { return read_image(path(name)).rgb(); }
  /// Renders into NAME in float, and expects no failure.
  void make(const std::string& scene, const std::string& name, std::vector<std::string> more) const {
    more.insert(more.end(), {"--precision", "float", "-o", name});
    const Outcome made = render(scene, more);
    ASSERT_EQ(made.status, 0) << made.err;
  }
  /// The mean of stills at the middles of `count` equal parts of a second.
  std::vector<RGB> mean_of_stills(const std::string& scene, int count, const std::vector<std::string>& options) const {
    std::vector<RGB> sum;
    for (int i = 0; i < count; ++i) {
      std::vector<std::string> more = options;
      more.insert(more.end(), {"--shutter", "0", "--at", fmt::format("{}", (i + 0.5) / count)});
      make(scene, "still.exr", more);
      const std::vector<RGB> still = pixels("still.exr");
      sum.resize(still.size(), RGB(0.0f));
      for (std::size_t p = 0; p < still.size(); ++p) sum[p] += still[p] / static_cast<float>(count);
    }
    return sum;
  }
};

constexpr std::size_t kBlurredSide = 16, kPatch = 4;

/// Largest difference between means of patches of 4 x 4 pixels, in pictures of 16 x 16, over that mean and the mean of
/// all.
double largest_difference(const std::vector<RGB>& a, const std::vector<RGB>& b) {
  double largest = 0, mean = 0;
  for (const RGB& pixel : b) mean += luminance(pixel) / static_cast<double>(b.size());
  for (std::size_t y = 0; y < kBlurredSide; y += kPatch)
    for (std::size_t x = 0; x < kBlurredSide; x += kPatch) {
      double one = 0, other = 0;
      for (std::size_t i = 0; i < kPatch * kPatch; ++i) {
        const std::size_t p = (y + i / kPatch) * kBlurredSide + x + i % kPatch;
        one += luminance(a[p]) / (kPatch * kPatch);
        other += luminance(b[p]) / (kPatch * kPatch);
      }
      largest = std::max(largest, std::abs(one - other) / (other + mean));
    }
  return largest;
}

TEST_F(ShutterTest, ThingsThatMoveAreTheMeanOfStills) {
  write("a.pbrt", moving_scene());
  for (const std::vector<std::string>& method :
       {std::vector<std::string>{"--integrator", "path"}, {"--gather", "8", "--filter", "off"}}) {
    std::vector<std::string> still = {"--samples", "8"}, blurred = {"--samples", "32"};
    still.insert(still.end(), method.begin(), method.end());
    blurred.insert(blurred.end(), method.begin(), method.end());
    make("a.pbrt", "blurred.exr", blurred);
    EXPECT_LT(largest_difference(pixels("blurred.exr"), mean_of_stills("a.pbrt", 6, still)), 0.15) << method[1];
  }
  make("a.pbrt", "first.exr", {"--integrator", "path", "--samples", "32", "--shutter", "0"});
  EXPECT_GT(largest_difference(pixels("blurred.exr"), pixels("first.exr")), 0.5);
}

TEST_F(ShutterTest, ACameraThatMovesTracesPhotonsOnce) {
  write("a.pbrt", kMovingCamera);
  // Without a filter, all pixels have as many rays.
  make("a.pbrt", "still.exr", {"--samples", "8", "--filter", "off", "--shutter", "0", "--stats", "still.json"});
  make("a.pbrt", "blurred.exr", {"--samples", "8", "--filter", "off", "--stats", "blurred.json"});
  EXPECT_FALSE(pixels("still.exr") == pixels("blurred.exr"));
  const nlohmann::json still = read_json("still.json"), blurred = read_json("blurred.json");
  EXPECT_EQ(blurred["passes"], 8);
  EXPECT_EQ(blurred["count"]["photons_emitted"], still["count"]["photons_emitted"]);
  EXPECT_EQ(blurred["count"]["camera_rays"], still["count"]["camera_rays"]);
}

TEST_F(ShutterTest, WhereNothingMovesThePictureIsThatWithoutIt) {
  make("builtin:cornell", "still.exr", {"--samples", "4"});
  make("builtin:cornell", "open.exr", {"--samples", "4", "--shutter", "1/48"});
  EXPECT_TRUE(pixels("still.exr") == pixels("open.exr"));
  // A shutter that opens after the motion.
  write("a.pbrt", moving_scene());
  make("a.pbrt", "end.exr", {"--samples", "4", "--shutter", "0", "--at", "1"});
  make("a.pbrt", "after.exr", {"--samples", "4", "--shutter", "0.1:0.5", "--at", "1"});
  EXPECT_TRUE(pixels("end.exr") == pixels("after.exr"));
}

TEST_F(ShutterTest, PartsMergeToTheSameBits) {
  write("a.pbrt", moving_scene("ActiveTransform EndTime Translate 0.3 0 0 ActiveTransform All"));
  make("a.pbrt", "whole.exr", {"--samples", "6"});
  for (const char* part : {"1/2", "2/2"}) {
    const Outcome made = render("a.pbrt", {"--samples", "6", "--part", part, "-o", fmt::format("{}.part", part[0])});
    ASSERT_EQ(made.status, 0) << made.err;
  }
  const Outcome merged = run({"merge", "1.part", "2.part", "--precision", "float", "-o", "merged.exr"});
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_TRUE(pixels("whole.exr") == pixels("merged.exr"));
  make("a.pbrt", "one-thread.exr", {"--samples", "6", "--threads", "1"});
  EXPECT_TRUE(pixels("whole.exr") == pixels("one-thread.exr"));
}

TEST_F(ShutterTest, AnInterruptedPictureContinuesToTheSameBits) {
  write("a.pbrt", moving_scene("ActiveTransform EndTime Translate 0.3 0 0 ActiveTransform All"));
  const std::vector<std::string> options = {"--samples", "6", "--gather", "4", "--photons", "2k"};
  make("a.pbrt", "whole.exr", options);
  std::vector<std::string> words = {"render", "a.pbrt", "--precision", "float", "-o", "a.exr", "--resume=c"};
  words.insert(words.end(), options.begin(), options.end());
  int interrupted = 0;
  for (const double seconds : {0.0, 0.1, 0.2, 0.15}) {
    Running running(folder_, words);
    running.wait_for_text("pixels", 60);
    wait_until([] { return false; }, seconds);
    running.send(SIGINT);
    const Outcome ended = running.wait();
    EXPECT_TRUE(ended.status == 130 || ended.status == 0) << ended.err;
    interrupted += ended.status == 130;
  }
  EXPECT_GT(interrupted, 0);
  const Outcome made = run(words);
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.err, testing::HasSubstr("going on from c"));
  EXPECT_TRUE(pixels("whole.exr") == pixels("a.exr"));
}

TEST_F(ShutterTest, FramesOfAScriptBlurBetweenThem) {
  write("moves.json", R"({"frames": 2, "moves": [{"from": 0, "to": 2, "orbit": [40, 0]},
                                                 {"from": 1, "to": 2, "light": {"name": "0", "move": [0.2, 0, 0]}}]})");
  const std::vector<std::string> script = {"--script", "moves.json", "--fps", "10", "--samples", "4"};
  const auto frames = [&](const std::string& name, const std::string& shutter) {
    std::vector<std::string> more = script;
    more.insert(more.end(), {"--shutter", shutter});
    make("builtin:cornell", name, more);
  };
  frames("sharp#.exr", "0");
  frames("blurred#.exr", "0.05");
  EXPECT_FALSE(pixels("sharp0.exr") == pixels("blurred0.exr"));
  // Nothing moves after the last frame.
  EXPECT_TRUE(pixels("sharp1.exr") == pixels("blurred1.exr"));
}

TEST_F(ShutterTest, RefusesWhatItCannotBlur) {
  const auto run_with = [&](const std::vector<std::string>& more) { return render("builtin:cornell", more); };
  for (const char* text : {"x", "1/0", "2:1", "0.1:", "1/2/3"})
    EXPECT_TRUE(refused(run_with({"--shutter", text, "-o", "a.exr"}), {"1/48"}, 2)) << text;
  EXPECT_TRUE(
      refused(run_with({"--shutter", "1/48", "--noise", "1%", "-o", "a.exr", "--resume"}), {"--noise", "--resume"}, 2));
}

TEST_F(ShutterTest, NoiseAndTimeFindTheSamples) {
  write("a.pbrt", kMovingCamera);
  struct Made {
    int samples;
    double error;
  };
  const auto made = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--samples", "4096", "--gather", "2", "--stats", "s.json"});
    make("a.pbrt", "a.exr", more);
    return Made{read_json("s.json")["passes"].get<int>(),
                std::stod(read_image(path("a.exr")).metadata.at("glowworm:relative_error"))};
  };
  const Made few = made({"--noise", "99%"});
  EXPECT_EQ(few.samples, 32);
  const Made more = made({"--noise", fmt::format("{}", 0.7 * few.error)});
  EXPECT_GT(more.samples, few.samples);
  EXPECT_LT(more.error, 0.75 * few.error);
  EXPECT_GE(made({"--time", "0.1"}).samples, few.samples);
}

}  // namespace
}  // namespace glowworm
