// The command line: the last of repeated options wins, invalid values end with status 2, and ignored options are
// reported.
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

using Words = std::vector<std::string>;

class CommandLineTest : public ProgramTest {
 protected:
  /// A picture of so many grey pixels with one that is `value`.
  void write_picture(const std::string& name, float value, int side = 4) const {
    Image image(side, side);
    std::vector<RGB> pixels(image.pixel_count(), RGB(0.5f));
    pixels[5] = RGB(value);
    image.add_rgb("", pixels);
    image.add_rgb("direct", std::vector<RGB>(image.pixel_count(), RGB(0.25f)));
    write_exr(path(name), image, ExrPrecision::single);
  }
};

TEST_F(CommandLineTest, WithoutACommandPrintsHelp) {
  const Outcome outcome = run({});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("Usage: glowworm [OPTIONS]"));
  EXPECT_THAT(outcome.err, HasSubstr("glowworm render builtin:cornell"));
}

TEST_F(CommandLineTest, WrongCommandLinesAreExplained) {
  const std::vector<std::pair<Words, Words>> cases = {
      {{"rendr"}, {"error: 'rendr' is not a command", "Did you mean 'render'?", "Choose from: render, "}},
      {{"--size", "4x4"}, {"error: '--size' is not a command"}},
      {{"render"}, {"error: scene is required", "'glowworm render --help'"}},
      {{"render", "a.glb", "b.glb"}, {"error: 'b.glb' is one argument too many"}},
      {{"render", "a.glb", "--sise=4x4"}, {"error: '--sise=4x4' is not an option of 'glowworm render'", "'--size'?"}},
      {{"render", "a.glb", "-o"}, {"error: --output needs a value"}},
      {{"measure", "a.glb"}, {"error: no sensors were given"}},
  };
  for (const auto& [words, texts] : cases) EXPECT_TRUE(refused(run(words), texts, 2)) << words[0];
}

TEST_F(CommandLineTest, TheLastOfARepeatedOptionWins) {
  const Outcome outcome =
      render("builtin:cornell", {"--size", "9x9", "--size", "8x4", "--precision", "half", "--precision", "float",
                                 "--seed", "1", "--seed", "2", "-o", "a.exr"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_image(path("a.exr")).width(), 8);
  EXPECT_EQ(read_image(path("a.exr")).metadata["glowworm:seed"], "2");
}

TEST_F(CommandLineTest, InvalidValuesEndWithStatus2) {
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"--engine", "foward"}, "Did you mean 'forward'?"},
      {{"--tone", "filmik"}, "Did you mean 'filmic'?"},
      {{"--aov", "norml"}, "Did you mean 'normal'?"},
      {{"--simd", "avx9"}, "avx9"},
      {{"--exposure", "nan"}, "--exposure 'nan'"},
      {{"--exposure", "inf"}, "--exposure 'inf'"},
      {{"--noise", "nan"}, "--noise 'nan'"},
      {{"--noise", "0"}, "--noise '0'"},
      {{"--noise", "-1"}, "--noise '-1'"},
      {{"--time", "nan"}, "--time 'nan'"},
      {{"--crop", "0,0,2,1"}, "--crop '0,0,2,1'"},
      {{"--crop", "nan,0,1,1"}, "--crop 'nan,0,1,1'"},
      {{"--pixel-bounds", "5,5,5,9"}, "--pixel-bounds"},
      {{"--sise", "4x4"}, "Did you mean '--size'?"},
      {{"-o", "a.jpg"}, "a.jpg"},
      {{"--environment", "nan,1,1"}, "--environment 'nan,1,1'"},
      {{"--precision", "double"}, "Choose from: half, float"},
      {{"--camera", "mian"}, "the camera 'mian' is not known\n  Did you mean 'main'?"},
      {{"--light", "lmap,off"}, "the light 'lmap' is not known\n  Did you mean 'lamp'?"},
      {{"--pixel-bounds", "600,0,700,10"}, "holds no pixel"},
      {{"--tev", "localhost:99999"}, "not HOST:PORT"},
      {{"--part", "3/4", "--samples", "1"}, "Give --samples 4"},
      {{"--stats", ""}, "--stats has an empty value"},
      {{"--environment", ""}, "--environment has an empty value"},
      {{"--resume="}, "--resume= has an empty value"},
  };
  for (const auto& [words, text] : cases) {
    Words all = {"render", "builtin:cornell"};
    all.insert(all.end(), words.begin(), words.end());
    EXPECT_TRUE(refused(run(all), {text}, 2)) << words[1];
  }
  write_picture("a.exr", 1);
  for (const char* option : {"--limit", "--leave-out"})
    EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", option, "nan"}), {option}, 2));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "--layer", "dirct"}), {"Did you mean 'direct'?"}, 2));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "--region", "0,0,5,5"}), {"0,0,5,5"}, 2));
  EXPECT_TRUE(refused(run({"compare", "a.exr", "a.exr", "-o", "a.gif"}), {"a.gif", "Give -o"}, 2));
  EXPECT_TRUE(refused(run({"bake", "builtin:cornell", "-o", "a.glb", "--atlas-picture", "a.gif"}), {"a.gif"}, 2));
  EXPECT_TRUE(refused(run({"view", "builtin:cornell", "--mode", "fotons"}), {"Did you mean 'photons'?"}, 2));
  EXPECT_TRUE(
      refused(run({"view", "builtin:cornell", "--out", "f", "--frames", "0"}), {"'0' is not a whole number"}, 2));
  EXPECT_TRUE(refused(run({"view", "builtin:cornell", "--out", "f", "--camera", "mian"}), {"'main'?"}, 2));
  EXPECT_TRUE(refused(run({"bake", "builtin:cornell", "-o", "a.glb", "--atlas", "64.5"}), {"a whole number"}, 2));
  for (const char* grid : {"y=0.2,0", "y=0.2,nan", "w=0.2,1", "y=nan,1", "y=9,1", "y=0.2,1e-9"})
    EXPECT_TRUE(refused(run({"measure", "builtin:cornell", "-o", "a.csv", "--grid", grid}), {grid}, 2));
  EXPECT_TRUE(refused(run({"measure", "builtin:cornell", "-o", "a.csv", "--surface", "flor,1"}), {"'floor'?"}, 2));
  EXPECT_TRUE(refused(run({"render", "builtin:cornel"}), {"Did you mean 'cornell'?"}, 2));
  EXPECT_THAT(names(), ElementsAre("a.exr"));
}

TEST_F(CommandLineTest, NoiseIsAShareOrAPercentage) {
  for (const char* text : {"0.5", "50%"}) {
    ASSERT_EQ(render("builtin:cornell", {"--noise", text, "--stats", "s.json", "-q"}).status, 0);
    EXPECT_DOUBLE_EQ(read_json("s.json").at("settings").at("noise_target"), 0.5);
  }
}

TEST_F(CommandLineTest, OptionsWithoutEffectAreNamed) {
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"--aov", "depth", "-o", "a.png"}, "--aov has no effect"},
      {{"--light-groups", "-o", "a.png"}, "--light-groups has no effect"},
      {{"--precision", "float", "-o", "a.png"}, "--precision has no effect"},
      {{"--exposure", "1", "-o", "a.exr"}, "--exposure has no effect"},
      {{"--tone", "srgb", "-o", "a.exr"}, "--tone has no effect"},
      {{"--reorder", "8", "-o", "a.exr"}, "--reorder has no effect"},
      {{"--thinned", "1k", "-o", "a.exr"}, "--thinned has no effect"},
      {{"--crop", "0,0,1,0.5", "--pixel-bounds", "0,0,4,4", "-o", "a.exr"}, "--crop has no effect"},
      {{"--environment", "1", "--sky", "cie:16", "-o", "a.exr"}, "--environment has no effect"},
      {{"--pixel-bounds", "0,0,4,9999", "-o", "a.exr"}, "--pixel-bounds reaches beyond the picture"},
  };
  for (const auto& [words, text] : cases) EXPECT_THAT(render("builtin:cornell", words).err, HasSubstr(text));
  const Outcome all = render("builtin:cornell", {"--aov", "depth", "--light-groups", "--precision", "float",
                                                 "--exposure", "1", "--tone", "srgb", "-o", "a.exr", "-o", "b.png"});
  EXPECT_THAT(all.err, Not(HasSubstr("no effect")));
}

TEST_F(CommandLineTest, NotesNameTheFileOnce) {
  const std::string scene =
      write("a.pbrt", "Sampler \"halton\" \"integer pixelsamples\" 4 WorldBegin Shape \"sphere\"");
  const std::string told = render(scene, {"-o", "b.exr"}).err;
  const std::size_t note = told.find("pixelsamples 4");
  ASSERT_NE(note, std::string::npos) << told;
  const std::size_t begin = told.rfind('\n', note) + 1;
  const std::string line = told.substr(begin, told.find('\n', note) - begin);
  EXPECT_EQ(line.find("a.pbrt"), line.rfind("a.pbrt")) << line;
}

TEST_F(CommandLineTest, EndingsMayBeCapitalAndStandardOutputTakesAnImageOrStatistics) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.EXR", "-o", "b.PNG", "-q"}).status, 0);
  EXPECT_EQ(read(path("b.PNG")).substr(1, 3), "PNG");
  EXPECT_EQ(render("builtin:cornell", {"-o", "-", "-q"}).out.substr(0, 4), "\x76\x2f\x31\x01");
  EXPECT_EQ(render("builtin:cornell", {"-o", "png:-", "-q"}).out.substr(1, 3), "PNG");
  const Outcome statistics = render("builtin:cornell", {"-o", "c.exr", "--stats", "-"});
  EXPECT_EQ(nlohmann::json::parse(statistics.out).at("passes"), 1);
  EXPECT_TRUE(refused(render("builtin:cornell", {"-o", "-", "--stats", "-"}), {"same file"}, 2));
  EXPECT_THAT(names(), UnorderedElementsAre("a.EXR", "b.PNG", "c.exr"));
}

TEST_F(CommandLineTest, ASceneNamesItsPictureAndItsCrop) {
  const std::string scene =
      write("a.pbrt",
            "Film \"rgb\" \"string filename\" \"up/there.exr\" \"integer xresolution\" 32 \"integer yresolution\" 16 "
            "\"float cropwindow\" [0.5 1 0 0.5] Camera \"perspective\" WorldBegin LightSource \"point\" "
            "Shape \"sphere\"");
  Words words = {"render", scene, "--samples", "1", "--gather", "1", "--photons", "1k"};
  const Outcome outcome = run(words);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("only 16x8 at 16,0"));
  EXPECT_EQ(read_image(path("there.exr")).place, (PicturePlace{16, 0, 32, 16}));
  words.insert(words.end(), {"--crop", "0,0,1,1"});
  ASSERT_EQ(run(words).status, 0);
  EXPECT_EQ(read_image(path("there.exr")).width(), 32);
}

TEST_F(CommandLineTest, BlackLightsStayBlack) {
  const std::string scene = write("a.pbrt",
                                  "LookAt 0 0 4 0 0 0 0 1 0 Camera \"perspective\" WorldBegin LightSource \"point\" "
                                  "\"rgb I\" [0 0 0] Shape \"sphere\"");
  for (const char* integrator : {"gather", "path", "photons"}) {
    const Outcome outcome = render(scene, {"-o", "a.exr", "--integrator", integrator});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("all lights of the scene are black"));
    for (const RGB& pixel : read_image(path("a.exr")).rgb()) EXPECT_EQ(pixel, RGB());
  }
}

TEST_F(CommandLineTest, AMissingSkyIsAnErrorAndAMissingTextureOneWarning) {
  const std::string sky =
      write("a.pbrt", "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\" Shape \"sphere\"");
  EXPECT_TRUE(refused(render(sky, {"-o", "a.exr"}), {"sky.exr", "infinite light"}));
  const std::string texture = write("b.pbrt",
                                    "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\" "
                                    "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"");
  const Outcome outcome = render(texture, {"-o", "b.exr"});
  EXPECT_EQ(outcome.status, 0);
  const std::size_t first = outcome.err.find("magenta");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(outcome.err.find("magenta", first + 1), std::string::npos) << outcome.err;
}

TEST_F(CommandLineTest, AReaderOfHelpMayCloseEarly) {
  const std::string program = GLOWWORM_PROGRAM, folder = folder_.string();
  for (const char* words : {"render --help", "bake --help", "info builtin:atrium"}) {
    EXPECT_EQ(std::system(("cd '" + folder + "' && '" + program + "' " + words + " 2> err | head -c 1 > out").c_str()),
              0);
    EXPECT_EQ(read(path("err")), "") << words;
    EXPECT_EQ(read(path("out")).size(), 1u);
  }
  EXPECT_NE(std::system(("cd '" + folder + "' && '" + program + "' render --help 2> err > /dev/full").c_str()), 0);
  EXPECT_THAT(read(path("err")), HasSubstr("standard output cannot be written"));
}

TEST_F(CommandLineTest, SensorsHaveNoParts) {
  EXPECT_TRUE(refused(run({"measure", "builtin:cornell", "--grid", "y=0.3,0.1", "--part", "1/2", "-o", "a.csv"}),
                      {"'--part' is not an option of 'glowworm measure'"}, 2));
}

TEST_F(CommandLineTest, CompareCountsNonFinitePixelsAndPrintsJson) {
  write_picture("a.exr", 0.5f);
  write_picture("nan.exr", std::numeric_limits<float>::quiet_NaN());
  write_picture("b.exr", 1.5f);
  EXPECT_EQ(run({"compare", "a.exr", "a.exr", "--limit", "0"}).status, 0);
  EXPECT_EQ(run({"compare", "a.exr", "b.exr", "--limit", "0"}).status, 1);
  const Outcome not_finite = run({"compare", "nan.exr", "a.exr", "--limit", "0.1"});
  EXPECT_EQ(not_finite.status, 1);
  EXPECT_THAT(not_finite.err, HasSubstr("1 pixels are not finite"));
  const Outcome exceeded = run({"compare", "b.exr", "a.exr", "--limit", "0.1"});
  EXPECT_EQ(exceeded.status, 1);
  EXPECT_THAT(exceeded.err, HasSubstr("exceeds --limit 0.1"));
  const auto json = [&](const Words& more) {
    Words words = {"compare", "b.exr", "a.exr", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return nlohmann::json::parse(run(words).out);
  };
  EXPECT_NEAR(json({}).at("mse"), 1.0 / 16, 1e-6);
  EXPECT_NEAR(json({}).at("psnr_db"), 10 * std::log10(0.25 * 16), 1e-6);
  EXPECT_NEAR(json({"--region", "1,1,2,3"}).at("mse"), 0.5, 1e-6);
  EXPECT_EQ(json({"--region", "2,0,4,4"}).at("mse"), 0);
  EXPECT_TRUE(json({"--region", "2,0,4,4"}).at("psnr_db").is_null());
  EXPECT_EQ(json({"--layer", "direct"}).at("mse"), 0);
  EXPECT_TRUE(refused(run({"compare", "a.exr", "b.exr", "--layer", "depth"}), {"depth", "direct"}, 2));
}

TEST_F(CommandLineTest, ComparingLinearAndExposedPicturesWarns) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.exr", "-o", "a.png"}).status, 0);
  EXPECT_THAT(run({"compare", "a.png", "a.exr"}).err, HasSubstr("exposed for display"));
  EXPECT_THAT(run({"compare", "a.png", "a.png"}).err, IsEmpty());
  EXPECT_THAT(run({"compare", "a.exr", "a.exr"}).err, IsEmpty());
}

TEST_F(CommandLineTest, MergeListsItsPictureOptions) {
  const std::string help = run({"merge", "--help"}).out;
  for (const char* option : {"--precision", "--tone", "--exposure", "--false-color"})
    EXPECT_THAT(help, HasSubstr(option));
}

TEST_F(CommandLineTest, ALimitOfTimeThatEndsBeforeTheNoiseIsTold) {
  const Words words = {"render", "builtin:cornell", "--size", "4x4", "-v", "-o", "a.exr", "--noise"};
  const auto told = [&](const char* noise, const char* seconds) {
    Words all = words;
    all.insert(all.end(), {noise, "--time", seconds});
    return run(all).err;
  };
  EXPECT_THAT(told("0.000001", "0.5s"), HasSubstr("before the error of --noise was reached"));
  const std::string reached = told("0.9", "100s");
  EXPECT_THAT(reached, Not(HasSubstr("before the error")));
  EXPECT_THAT(
      reached,
      HasSubstr("250000 photons: so many that their bias falls with the noise of the gather rays, at least 250000 "
                "and at most 4000000"));
}

TEST_F(CommandLineTest, ALimitOfTimeLeavesSamplesUnlimited) {
  Words words = {"render", "builtin:cornell", "--size", "4x4", "--gather", "1", "--photons", "1k", "-o", "a.exr"};
  words.insert(words.end(), {"--noise", "0.9"});
  EXPECT_THAT(run(words).err, HasSubstr("4x4 pixels, unlimited samples x 1 gather rays"));
  words.insert(words.end(), {"--samples", "2"});
  EXPECT_THAT(run(words).err, HasSubstr("4x4 pixels, 2 samples x 1 gather rays"));
}

TEST_F(CommandLineTest, APartIsComparedWithTheWhole) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.exr", "--precision", "float", "--filter", "off"}).status, 0);
  ASSERT_EQ(
      render("builtin:cornell", {"-o", "b.exr", "--precision", "float", "--filter", "off", "--crop", "0.3,0.3,0.7,0.9"})
          .status,
      0);
  const Outcome outcome = run({"compare", "b.exr", "a.exr", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("mse"), 0);
}

TEST_F(CommandLineTest, InfoPrintsJson) {
  const auto json = nlohmann::json::parse(run({"info", "builtin:cornell", "--json"}).out);
  EXPECT_EQ(json.at("name"), "cornell");
  EXPECT_EQ(json.at("objects").size(), 8u);
  EXPECT_EQ(json.at("cameras")[0].at("name"), "main");
  EXPECT_GT(json.at("power_w"), 0.0);
  EXPECT_EQ(json.at("lights")[0].at("name"), "lamp");
}

TEST_F(CommandLineTest, InfoListsLightsByTheNamesThatLightTakes) {
  const std::string scene = write("a.pbrt",
                                  "LookAt 0 0 4 0 0 0 0 1 0 Camera \"perspective\" WorldBegin LightSource \"point\" "
                                  "LightSource \"infinite\" AreaLightSource \"diffuse\" Shape \"disk\"");
  const std::string told = run({"info", scene}).out;
  const auto json = nlohmann::json::parse(run({"info", scene, "--json"}).out);
  EXPECT_THAT(told, HasSubstr("lights     3, with "));
  EXPECT_THAT(told, HasSubstr("at (0, 0, 4)"));
  double sum = 0;
  for (const auto& light : json.at("lights")) {
    const std::string name = light.at("name");
    EXPECT_THAT(told, HasSubstr("\n  " + name + "  "));
    EXPECT_EQ(render(scene, {"--light", name + ",scale=2", "-o", "a.exr", "-q"}).status, 0) << name;
    const auto rgb = light.at("power_rgb_w");
    sum += 0.2126 * rgb[0].get<double>() + 0.7152 * rgb[1].get<double>() + 0.0722 * rgb[2].get<double>();
  }
  const double total = json.at("power_w");
  EXPECT_NEAR(sum, total, 1e-4 * total);
}

/// A scene far from the origin, which the program moves inside.
constexpr const char* kFarScene =
    "LookAt 300000 -200000 4 300000 -200000 0 0 1 0 Camera \"perspective\" WorldBegin LightSource \"infinite\" Shape "
    "\"trianglemesh\" \"point3 P\" [299999 -200001 0  300001 -200001 0  300001 -199999 0  299999 -199999 0] \"integer "
    "indices\" [0 1 2 0 2 3]";

TEST_F(CommandLineTest, PlacesAreThoseOfTheFile) {
  const std::string scene = write("far.pbrt", kFarScene);
  const std::string told = run({"info", scene}).out;
  EXPECT_THAT(told, HasSubstr("bounds     (299999, -200001, 0) to (300001, -199999, 0) m"));
  EXPECT_THAT(told, HasSubstr("at (300000, -200000, 4)"));
  EXPECT_THAT(told, HasSubstr("(300000, -200000, 0) m is subtracted"));
  EXPECT_THAT(told, Not(HasSubstr("rounded")));
  const auto json = nlohmann::json::parse(run({"info", scene, "--json"}).out);
  EXPECT_EQ(json.at("bounds_m")[1][0], 300'001);
  EXPECT_EQ(json.at("cameras")[0].at("position_m")[1], -200'000);
  write("a.pts", "300000.5 -200000.5 1 0 0 1\n");
  const Outcome measured = run({"measure", scene, "--points", "a.pts", "--samples", "2", "-o", "-"});
  EXPECT_THAT(measured.out, HasSubstr("\n300000.5,-200000.5,1,0,0,1,")) << measured.err;
  const Outcome missed = run({"measure", scene, "--grid", "x=1,1", "-o", "a.csv"});
  EXPECT_THAT(missed.err, HasSubstr("reaches from 299999 to 300001 m"));
  const std::string view = "300000,-200000,2,300000,-200000,0,0,1,0";
  ASSERT_EQ(render(scene, {"--view", view, "--aov", "depth,position", "-o", "a.exr", "-q"}).status, 0);
  const Image picture = read_image(path("a.exr"));
  const auto middle = static_cast<std::size_t>((picture.height() / 2) * picture.width() + picture.width() / 2);
  EXPECT_NEAR(picture.channel("depth.Z")[middle], 2, 0.1);
}

/// Pixels 20 mm apart; floats at 300 km have steps of 31 mm.
TEST_F(CommandLineTest, PicturesHoldPlacesFarAwayRelativeToTheirOrigin) {
  ASSERT_EQ(render(write("far.pbrt", kFarScene), {"--size", "400x400", "--samples", "1", "--photons", "1k", "--gather",
                                                  "1", "--aov", "position", "-o", "a.exr", "-q"})
                .status,
            0);
  const Image picture = read_image(path("a.exr"));
  EXPECT_EQ(picture.metadata.at("glowworm:origin"), "300000 -200000 0");
  std::size_t tested = 0;
  for (std::size_t i = 0; i < 160'000; ++i) {
    const float x = picture.channel("position.X")[i], y = picture.channel("position.Y")[i];
    if (x == 0 && y == 0) continue;
    EXPECT_NEAR(200 - 50 * x, static_cast<float>(i % 400) + 0.5f, 0.51f);
    EXPECT_NEAR(200 - 50 * y, static_cast<float>(i / 400) + 0.5f, 0.51f);
    ++tested;
  }
  EXPECT_GT(tested, 9'000u);
}

/// What the program writes to a terminal of so many columns.
TEST_F(CommandLineTest, ProgressNamesThePhotonMapAndFitsTheTerminal) {
  for (const unsigned short columns : {30, 50, 200}) {
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_GE(terminal, 0);
    ASSERT_EQ(grantpt(terminal), 0);
    ASSERT_EQ(unlockpt(terminal), 0);
    const winsize size{24, columns, 0, 0};
    ASSERT_EQ(ioctl(terminal, TIOCSWINSZ, &size), 0);
    const std::string name = ptsname(terminal);
    const int other = open(name.c_str(), O_RDWR | O_NOCTTY);
    Running running(folder_, {"render", "builtin:cornell", "--size", "16x16", "--photons", "200k", "-o", "a.exr"},
                    [&] { dup2(other, STDERR_FILENO); });
    close(other);
    std::string shown;
    char bytes[4096];
    // Reading ends with an error where the program has closed the terminal.
    for (ssize_t n = 0; (n = ::read(terminal, bytes, sizeof bytes)) > 0;)
      shown.append(bytes, static_cast<std::size_t>(n));
    close(terminal);
    EXPECT_EQ(running.wait().status, 0);
    std::size_t bars = 0;
    for (std::size_t at = shown.find("\033[K"); at != std::string::npos; at = shown.find("\033[K", at + 1)) {
      const std::string line = shown.substr(at + 3, shown.find_first_of("\r\n", at) - at - 3);
      if (line.find('%') == std::string::npos) continue;
      EXPECT_LT(line.size(), columns) << line;
      ++bars;
    }
    EXPECT_GT(bars, 0u);
    EXPECT_THAT(shown, HasSubstr("tracing photons"));
    EXPECT_THAT(shown, HasSubstr("building photon map"));
  }
}

/// Decodes a matte as compositing programs do: by the name's number in the manifest.
TEST_F(CommandLineTest, ACryptomatteIsDecoded) {
  ASSERT_EQ(render("builtin:cornell",
                   {"--size", "32x32", "--samples", "4", "--aov", "cryptomatte,object-id,alpha", "-o", "a.exr"})
                .status,
            0);
  Image image = read_image(path("a.exr"));
  std::string prefix;
  for (const auto& [key, value] : image.metadata)
    if (value == "CryptoObject") prefix = key.substr(0, key.size() - 4);
  ASSERT_THAT(prefix, testing::StartsWith("cryptomatte/"));
  EXPECT_EQ(image.metadata[prefix + "hash"], "MurmurHash3_32");
  EXPECT_EQ(image.metadata[prefix + "conversion"], "uint32_to_float32");
  const auto manifest = nlohmann::json::parse(image.metadata[prefix + "manifest"]);
  const auto id = static_cast<std::uint32_t>(std::stoul(manifest.at("tall block").get<std::string>(), nullptr, 16));
  const auto names = nlohmann::json::parse(image.metadata["glowworm:objects"]);
  std::size_t whole = 0, partial = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    float matte = 0, all = 0, last = 1;
    for (int rank = 0; rank < 6; ++rank) {
      const std::string layer = "CryptoObject0" + std::to_string(rank / 2) + ".";
      const float number = image.channel(layer + (rank % 2 ? "B" : "R"))[i];
      const float coverage = image.channel(layer + (rank % 2 ? "A" : "G"))[i];
      EXPECT_LE(coverage, last);
      last = coverage;
      all += coverage;
      std::uint32_t bits;
      std::memcpy(&bits, &number, sizeof bits);
      if (bits == id) matte += coverage;
    }
    EXPECT_FLOAT_EQ(all, image.channel("A")[i]);
    if (matte == 1) {
      EXPECT_EQ(names[static_cast<std::size_t>(image.channel("object-id.I")[i])], "tall block");
    }
    whole += matte == 1;
    partial += matte > 0 && matte < 1;
  }
  EXPECT_GT(whole, 50u);
  EXPECT_GT(partial, 5u);
}

TEST_F(CommandLineTest, OiiotoolReadsLayersAndMetadata) {
  ASSERT_EQ(render("builtin:cornell", {"--size", "16x8", "--crop", "0,0,0.5,1", "--light-groups", "--aov",
                                       "depth,normal,position,cryptomatte,object-id", "-o", "a.exr", "-q"})
                .status,
            0);
  const auto told = [&](const std::string& words) {
    EXPECT_EQ(std::system(("oiiotool " + words + " > " + path("told.txt")).c_str()), 0)
        << "is openimageio-tools there?";
    return read(path("told.txt"));
  };
  const std::string info = told("--info -v " + path("a.exr"));
  for (const char* text :
       {"8 x    8", "full/display size: 16 x 8", "depth.Z (float)", "normal.X (half)", "position.Z (float)",
        "CryptoObject00.R (float)", "object-id.I (float)", "light.lamp.R (half)",
        "chromaticities: 0.64, 0.33, 0.3, 0.6, 0.15, 0.06", "worldToCamera: ", "worldToNDC: ", "name: \"CryptoObject\"",
        "Software: \"Glowworm", "glowworm render builtin:cornell"})
    EXPECT_THAT(info, HasSubstr(text));
  EXPECT_THAT(info, testing::ContainsRegex("DateTime: \"20[0-9][0-9]:"));
  // The back wall is 1.36 m in front of the camera, and a little farther along slanted rays.
  EXPECT_THAT(told(path("a.exr") + " --ch depth.Z --printstats"), HasSubstr("Stats Max: 1.3"));
}

TEST_F(CommandLineTest, PicturesRecordTheirCommandLine) {
  ASSERT_EQ(render("builtin:cornell", {"-o", "a.exr", "-q"}).status, 0);
  const Image image = read_image(path("a.exr"));
  std::string all;
  for (const auto& [key, value] : image.metadata) all += key + "=" + value + "\n";
  EXPECT_THAT(all, HasSubstr("glowworm render builtin:cornell"));
  EXPECT_THAT(all, testing::ContainsRegex("=20[0-9][0-9]:[01][0-9]:[0-3][0-9] "));
}

}  // namespace
}  // namespace glowworm
