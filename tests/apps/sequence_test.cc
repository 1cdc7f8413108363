// Sequences of frames: `render` with --turntable and --script.
#include <fstream>

#include "apps/program.h"
#include "image/image.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

class SequenceTest : public ProgramTest {
 protected:
  void write_script(const std::string& moves) const {
    std::ofstream(path("moves.json")) << R"({"frames": 3, "moves": [)" << moves << "]}";
  }
  /// Renders the frames of moves.json or of `more`, into PREFIX0.exr, ...
  Outcome frames(const std::string& prefix, std::vector<std::string> more) const {
    more.insert(more.end(), {"--precision", "float", "-o", prefix + "#.exr"});
    return render("builtin:cornell", more);
  }
  void expect_same_pixels(const std::string& a, const std::string& b) const {
    const Image one = read_image(path(a)), other = read_image(path(b));
    EXPECT_TRUE(one.rgb() == other.rgb()) << a << ", " << b;
  }
  /// The error that --noise means, of the luminance of a picture.
  double relative_error(const std::string& picture, const std::string& reference) const {
    const std::vector<RGB> seen = read_image(path(picture)).rgb(), right = read_image(path(reference)).rgb();
    double mean = 0, sum = 0;
    for (const RGB& pixel : right) mean += luminance(pixel) / static_cast<double>(right.size());
    for (std::size_t i = 0; i < right.size(); ++i) {
      const double level = luminance(right[i]), off = luminance(seen[i]) - level;
      sum += off * off / (level * level + 0.01 * mean * mean);
    }
    return std::sqrt(sum / static_cast<double>(right.size()));
  }
  /// A room of 2 m with a lamp, and a board in it that moves 1 m in a second and turns, or else a lamp that does.
  void write_moving_room(const std::string& name, bool lamp_moves) const {
    std::vector<float> numbers = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};  // a square
    numbers.insert(numbers.end(),
                   {0, 1, 0, 0, 0, 0.5f, 0, -0.5f, 0, 0, 0, 1, 0, 0.6f, 0, 0.8f});  // times, places, turns
    std::string bytes(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float));
    for (const char index : {0, 1, 2, 0, 2, 3}) bytes += {index, 0};
    write("room.bin", bytes);
    const auto node = [](int mesh, std::vector<double> place, std::vector<double> turn, double size) {
      return nlohmann::json{{"mesh", mesh}, {"translation", place}, {"rotation", turn}, {"scale", {size, size, size}}};
    };
    const double h = std::sqrt(0.5);
    nlohmann::json moving = {{"children", {8}}},
                   nodes = {node(0, {0, -1, 0}, {-h, 0, 0, h}, 1), node(0, {0, 1, 0}, {h, 0, 0, h}, 1),
                            node(0, {-1, 0, 0}, {0, h, 0, h}, 1), node(0, {1, 0, 0}, {0, -h, 0, h}, 1),
                            node(0, {0, 0, -1}, {0, 0, 0, 1}, 1)};
    const int board = lamp_moves ? 1 : 0, other = lamp_moves ? 0 : 1;
    nodes.push_back(node(1, {-0.5, 0.99, 0}, {h, 0, 0, h}, 0.2));
    nodes.push_back(node(other, {0.5, lamp_moves ? -0.5 : 0.99, 0}, {h, 0, 0, h}, 0.2));
    nodes.push_back(moving);
    nodes.push_back(node(board, {0.2, 0.3, 0}, {h, 0, 0, h}, 0.1));
    const auto view = [](int offset, int length) {
      return nlohmann::json{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}};
    };
    const auto accessor = [](int at, int type, int count, const char* kind) {
      return nlohmann::json{{"bufferView", at}, {"componentType", type}, {"count", count}, {"type", kind}};
    };
    nlohmann::json corners = accessor(0, 5126, 4, "VEC3");
    corners["min"] = {-1, -1, 0};
    corners["max"] = {1, 1, 0};
    const auto mesh = [](int material) {
      return nlohmann::json{
          {"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 4}, {"material", material}}}}};
    };
    // In a white room paths hardly end.
    const nlohmann::json grey = {
        {"doubleSided", true},
        {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"metallicFactor", 0}}}};
    nlohmann::json lamp = grey;
    lamp["emissiveFactor"] = {1, 1, 1};
    const nlohmann::json gltf = {{"asset", {{"version", "2.0"}}},
                                 {"scenes", {{{"nodes", {0, 1, 2, 3, 4, 5, 6, 7}}}}},
                                 {"nodes", nodes},
                                 {"buffers", {{{"uri", "room.bin"}, {"byteLength", bytes.size()}}}},
                                 {"bufferViews", {view(0, 48), view(48, 8), view(56, 24), view(80, 32), view(112, 12)}},
                                 {"accessors",
                                  {corners, accessor(1, 5126, 2, "SCALAR"), accessor(2, 5126, 2, "VEC3"),
                                   accessor(3, 5126, 2, "VEC4"), accessor(4, 5123, 6, "SCALAR")}},
                                 {"materials", {grey, lamp}},
                                 {"meshes", {mesh(0), mesh(1)}},
                                 {"animations",
                                  {{{"samplers", {{{"input", 1}, {"output", 2}}, {{"input", 1}, {"output", 3}}}},
                                    {"channels",
                                     {{{"sampler", 0}, {"target", {{"node", 7}, {"path", "translation"}}}},
                                      {{"sampler", 1}, {"target", {{"node", 7}, {"path", "rotation"}}}}}}}}}};
    std::ofstream(path(name)) << gltf;
  }
  /// A program `ffmpeg` that first runs a line of the shell, then copies its input to its output, `$last`; and PATH
  /// with it in front.
  std::function<void()> with_ffmpeg(const std::string& first = ":") const {
    fs::create_directory(path("bin"));
    std::ofstream(path("bin/ffmpeg")) << "#!/bin/sh\nfor last; do :; done\n" << first << "\nexec cat > \"$last\"\n";
    fs::permissions(path("bin/ffmpeg"), fs::perms::owner_all);
    const std::string folders = path("bin") + ":/usr/bin:/bin";
    return [folders] { setenv("PATH", folders.c_str(), 1); };
  }
};
using SlowSequenceTest = SequenceTest;

TEST_F(SequenceTest, AFrameHasTheSameBitsAloneAsAmongOthers) {
  write_script(R"({"from": 0, "to": 3, "orbit": [40, 0]})");
  ASSERT_EQ(frames("all", {"--script", "moves.json"}).status, 0);
  ASSERT_EQ(frames("own", {"--script", "moves.json", "--frames", "2"}).status, 0);
  EXPECT_FALSE(fs::exists(path("own0.exr")));
  expect_same_pixels("all2.exr", "own2.exr");
  EXPECT_FALSE(read_image(path("all1.exr")).rgb() == read_image(path("all2.exr")).rgb());
}

TEST_F(SequenceTest, AFrameHasTheSameBitsInMovedLight) {
  write_script(R"({"from": 0, "to": 3, "light": {"name": "0", "move": [0.1, 0, 0.1]}})");
  ASSERT_EQ(frames("all", {"--script", "moves.json"}).status, 0);
  ASSERT_EQ(frames("own", {"--script", "moves.json", "--frames", "2"}).status, 0);
  expect_same_pixels("all2.exr", "own2.exr");
}

TEST_F(SequenceTest, FramesOfAnAnimationShowItsMoments) {
  write_scenes();
  nlohmann::json gltf = read_json("a.gltf");
  // The first node rises by 1 m in a second: times 0 and 1, places (0,0,0) and (0,1,0).
  const float numbers[] = {0, 1, 0, 0, 0, 0, 1, 0};
  std::ofstream(path("move.bin")).write(reinterpret_cast<const char*>(numbers), sizeof numbers);
  const auto add = [&](const char* list, const nlohmann::json& object) {
    gltf[list].push_back(object);
    return gltf[list].size() - 1;
  };
  const auto buffer = add("buffers", {{"uri", "move.bin"}, {"byteLength", sizeof numbers}});
  const auto view = add("bufferViews", {{"buffer", buffer}, {"byteLength", sizeof numbers}});
  const auto times =
      add("accessors", {{"bufferView", view}, {"componentType", 5126}, {"type", "SCALAR"}, {"count", 2}});
  const auto places = add(
      "accessors", {{"bufferView", view}, {"byteOffset", 8}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 2}});
  gltf["animations"] = {{{"samplers", {{{"input", times}, {"output", places}}}},
                         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  std::ofstream(path("a.gltf")) << gltf;
  ASSERT_EQ(render("a.gltf", {"--frames", "0-2", "--fps", "2", "--precision", "float", "-o", "f#.exr"}).status, 0);
  ASSERT_EQ(render("a.gltf", {"--frames", "2", "--fps", "2", "--precision", "float", "-o", "own#.exr"}).status, 0);
  expect_same_pixels("f2.exr", "own2.exr");
  EXPECT_FALSE(read_image(path("f0.exr")).rgb() == read_image(path("f2.exr")).rgb());
}

TEST_F(SlowSequenceTest, FramesKeepPhotonsOfPathsThatMeetNothingThatMoves) {
  for (const std::string name : {"board", "lamp", "board in haze"}) {
    SCOPED_TRACE(name);
    write_moving_room("room.gltf", name == "lamp");
    const auto made = [&](const std::string& prefix, std::vector<std::string> more) {
      more.insert(more.end(),
                  {"--fps", "2", "--precision", "float", "-o", prefix + "#.exr", "--stats", prefix + "#.json"});
      if (name == "board in haze") more.insert(more.end(), {"--haze", "10m"});
      const Outcome outcome = render("room.gltf", more);
      ASSERT_EQ(outcome.status, 0) << outcome.err;
    };
    made(name, {"--frames", "0-2"});
    made(name + "own", {"--frames", "2"});
    // Processes that share photons keep none.
    made(name + "fresh", {"--frames", "2", "--threads", "1", "--share", path(name + "-shared")});
    EXPECT_EQ(read_json(name + "fresh2.json")["count"]["photons_kept"], 0);
    made(name + "small", {"--frames", "0-2", "--memory", "40M", "--threads", "3"});
    for (const char* other : {"own", "fresh", "small"}) expect_same_pixels(name + "2.exr", name + other + "2.exr");
    EXPECT_FALSE(read_image(path(name + "0.exr")).rgb() == read_image(path(name + "2.exr")).rgb());
    EXPECT_GT(read_json(name + "0.json")["count"]["photons_emitted"], 0)
        << "of the photons that guides are learned with";
    for (const char* frame : {"1.json", "2.json"}) {
      const nlohmann::json count = read_json(name + frame)["count"];
      EXPECT_GT(count["photons_kept"], count["photons_stored"].get<double>() / 4);
      EXPECT_LT(count["photons_kept"], count["photons_stored"]);
    }
  }
}

/// The same moment after another first one has other guides, and so other photons.
TEST_F(SlowSequenceTest, ProcessesShareNoPhotonsOfAnotherFirstMoment) {
  write_moving_room("room.gltf", true);
  const auto keys_after = [&](const std::string& name) {
    const Outcome outcome =
        render("room.gltf", {"--frames", "2", "--fps", "2", "--share", path("shared"), "-o", name + "#.exr"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return std::distance(fs::directory_iterator(path("shared")), fs::directory_iterator());
  };
  // One of the first moment, and one of the frame.
  EXPECT_EQ(keys_after("a"), 2);
  EXPECT_EQ(keys_after("again"), 2);
  // The translations are the keys of the lamp; frame 2 shows the second.
  std::fstream keys(path("room.bin"), std::ios::in | std::ios::out | std::ios::binary);
  const float other[3] = {0.3f, 0.2f, -0.3f};
  keys.seekp(56);
  keys.write(reinterpret_cast<const char*>(other), sizeof other);
  keys.close();
  EXPECT_EQ(keys_after("b"), 4);
}

TEST_F(SequenceTest, FramesOfAWalkTracePhotonsOnce) {
  ASSERT_EQ(frames("a", {"--turntable", "2", "--stats", "s#.json"}).status, 0);
  EXPECT_GT(read_json("s0.json")["count"]["photons_emitted"], 0);
  EXPECT_EQ(read_json("s1.json")["count"]["photons_emitted"], 0);
}

TEST_F(SequenceTest, PartsRenderEveryNthFrameToTheSameBits) {
  ASSERT_EQ(frames("all", {"--turntable", "3"}).status, 0);
  ASSERT_EQ(frames("part", {"--turntable", "3", "--part", "2/2"}).status, 0);
  EXPECT_FALSE(fs::exists(path("part0.exr")));
  EXPECT_FALSE(fs::exists(path("part2.exr")));
  expect_same_pixels("all1.exr", "part1.exr");
}

TEST_F(SequenceTest, AFrameThatUsesEarlierLightHasTheSameBitsAlone) {
  const auto made = [&](const std::string& prefix, std::vector<std::string> more) {
    more.insert(more.end(), {"--turntable", "100", "--samples", "4"});
    ASSERT_EQ(frames(prefix, more).status, 0);
  };
  made("all", {"--frames", "0-3", "--reuse", "2"});
  made("own", {"--frames", "3", "--reuse", "2"});
  made("part", {"--frames", "0-3", "--reuse", "2", "--part", "2/2"});
  made("plain", {"--frames", "0-3"});
  EXPECT_FALSE(fs::exists(path("own2.exr")));
  EXPECT_FALSE(fs::exists(path("part1.exr")));
  expect_same_pixels("all3.exr", "own3.exr");
  expect_same_pixels("all3.exr", "part3.exr");
  expect_same_pixels("all0.exr", "plain0.exr");
  EXPECT_FALSE(read_image(path("all3.exr")).rgb() == read_image(path("plain3.exr")).rgb());
}

/// Frame 2 begins a run that is tested alone, so frame 3 alone needs frames 0 to 2: 1 is shown, and tested with 0.
TEST_F(SequenceTest, NoiseTestedWithEarlierLightIsTheSameAlone) {
  const auto made = [&](const std::string& prefix, const std::string& range, std::vector<std::string> more = {}) {
    more.insert(more.end(),
                {"--turntable", "400", "--frames", range, "--noise", "8%", "--reuse", "2", "--samples", "1000"});
    const Outcome outcome = frames(prefix, more);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  };
  made("all", "0-5");
  made("own", "4");
  made("part", "0-5", {"--part", "2/2"});
  EXPECT_FALSE(fs::exists(path("part2.exr")));
  expect_same_pixels("all4.exr", "own4.exr");
  expect_same_pixels("all4.exr", "part4.exr");
}

TEST_F(SequenceTest, ASecondFrameOfAStillViewTakesAThirdAtMostForTheSameNoise) {
  write_script(R"({"at": 0, "look": [0, 0]})");
  const auto made = [&](const std::string& prefix, std::vector<std::string> more) {
    more.insert(more.end(), {"--script", "moves.json", "--stats", prefix + "#.json"});
    const Outcome outcome = frames(prefix, more);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  };
  made("a", {"--frames", "0-1", "--noise", "2%", "--reuse", "2", "--samples", "10000"});
  made("true", {"--frames", "2", "--samples", "1000"});
  const auto samples = [&](const std::string& file) { return read_json(file)["mean_samples"].get<double>(); };
  EXPECT_LT(samples("a1.json"), samples("a0.json") / 3);
  EXPECT_LT(relative_error("a0.exr", "true2.exr"), 0.02);
  EXPECT_LT(relative_error("a1.exr", "true2.exr"), 0.02);
}

TEST_F(SequenceTest, LightIsNotUsedAgainWhereALampMoves) {
  write_script(R"({"from": 0, "to": 3, "light": {"name": "0", "move": [0.1, 0, 0.1]}})");
  ASSERT_EQ(frames("all", {"--script", "moves.json", "--samples", "2", "--reuse", "2"}).status, 0);
  ASSERT_EQ(frames("plain", {"--script", "moves.json", "--samples", "2"}).status, 0);
  expect_same_pixels("all2.exr", "plain2.exr");
}

TEST_F(SequenceTest, SkipsFramesThatAreThere) {
  ASSERT_EQ(frames("a", {"--turntable", "3"}).status, 0);
  const fs::file_time_type first = fs::last_write_time(path("a0.exr"));
  fs::rename(path("a2.exr"), path("before.exr"));
  const Outcome again = frames("a", {"--turntable", "3"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.err, testing::HasSubstr("frame 1 exists"));
  EXPECT_EQ(fs::last_write_time(path("a0.exr")), first);
  expect_same_pixels("a2.exr", "before.exr");
}

TEST_F(SequenceTest, AnInterruptedFrameLeavesNoFile) {
  Running running(folder_, {"render", "builtin:cornell", "--size", "64x64", "--samples", "100000", "--filter", "off",
                            "--turntable", "2", "-o", "a#.exr"});
  ASSERT_TRUE(running.wait_for_text("frame 0", 60));
  running.send(SIGINT);
  EXPECT_EQ(running.wait().status, 130);
  EXPECT_FALSE(fs::exists(path("a0.exr")));
}

/// Of a room whose light is mostly indirect.
TEST_F(SequenceTest, FramesAreExposedLikeAPicture) {
  write_script(R"({"at": 0, "look": [0, 0]})");
  const auto mean_luminance = [&](std::vector<std::string> more, const std::string& picture) {
    more.insert(more.end(), {"--size", "48x36", "--samples", "4", "--gather", "12", "--photons", "50k"});
    const Outcome made = render("builtin:ajar", more);
    EXPECT_EQ(made.status, 0) << made.err;
    double sum = 0;
    for (const RGB& pixel : read_image(path(picture)).rgb()) sum += luminance(pixel);
    return sum;
  };
  const double alone = mean_luminance({"-o", "alone.png"}, "alone.png"),
               frame = mean_luminance({"--script", "moves.json", "--frames", "0-0", "-o", "f#.png"}, "f0.png");
  EXPECT_NEAR(frame, alone, 0.1 * alone);
}

TEST_F(SequenceTest, PipesPicturesToFfmpeg) {
  const Outcome made = render("builtin:cornell", {"--turntable", "2", "-o", "a#.png", "-o", "a.mp4"}, with_ffmpeg());
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(read(path("a.mp4")), read(path("a0.png")) + read(path("a1.png")));
  EXPECT_FALSE(fs::exists(path("a.mp4.unfinished.mp4")));
}

/// Frames are larger than a pipe, so ffmpeg has begun before the second is read.
TEST_F(SequenceTest, LeavesNoUnfinishedFilm) {
  const auto film_with = [&](const std::string& line) {
    const Outcome made = render(
        "builtin:cornell",
        {"--turntable", "2", "--size", "320x320", "--samples", "1", "--filter", "off", "-o", "a#.png", "-o", "a.mp4"},
        with_ffmpeg(line));
    EXPECT_GT(fs::file_size(path("a0.png")), 1u << 16);
    EXPECT_FALSE(fs::exists(path("a.mp4")));
    EXPECT_FALSE(fs::exists(path("a.mp4.unfinished.mp4")));
    return made;
  };
  EXPECT_TRUE(refused(film_with("rm a1.png"), {"a1.png"}));
  EXPECT_TRUE(refused(film_with("echo begun > \"$last\"; exit 0"), {"a.mp4", "all frames"}));
  EXPECT_TRUE(refused(film_with("echo begun > \"$last\"; exit 1"), {"a.mp4", "has not written"}));
}

TEST_F(SequenceTest, RefusesWhatMakesNoSequence) {
  const auto run_with = [&](std::vector<std::string> more) { return render("builtin:cornell", more); };
  EXPECT_TRUE(refused(run_with({"--frames", "0-3", "-o", "a#.exr"}), {"no animation"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "-o", "a.exr"}), {"a.exr", "'#'"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "--frames", "2-1", "-o", "a#.exr"}), {"2-1", "no frame"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "--frames", "1-9", "-o", "a#.exr"}), {"beyond --turntable"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "--frames", "x", "-o", "a#.exr"}), {"'x'", "1-240:2"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "-o", "a#.exr", "-o", "a.mp4"}), {"a.mp4", ".png"}, 2));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--turntable", "3", "-o", "a#.png", "-o", "a.mp4"},
                             [] { setenv("PATH", "/nowhere", 1); }),
                      {"ffmpeg"}, 2));
  EXPECT_TRUE(refused(run_with({"--turntable", "3", "-o", "a#.exr", "--resume=a.checkpoint"}), {"--resume"}, 2));
  EXPECT_TRUE(refused(run_with({"--reuse", "3", "-o", "a.exr"}), {"--reuse"}, 2));
  EXPECT_TRUE(
      refused(run_with({"--turntable", "3", "--reuse", "3", "--filter", "off", "-o", "a#.exr"}), {"filter"}, 2));
  write_script(R"({"at": 1, "focus": [0.5, 0.5]})");
  EXPECT_TRUE(refused(run_with({"--script", "moves.json", "-o", "a#.exr"}), {"focus"}, 2));
  EXPECT_TRUE(names().empty() || names() == std::vector<std::string>{"moves.json"});
}

}  // namespace
}  // namespace glowworm
