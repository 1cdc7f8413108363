// Reports for a browser, by clicks in headless Chromium where it is installed.
#include <algorithm>
#include <cstdlib>
#include <regex>
#include <sstream>

#include "apps/program.h"
#include "image/false_color.h"
#include "image/image.h"

namespace glowworm {
namespace {

using testing::HasSubstr;
using testing::Not;

class ReportTest : public ProgramTest {
 protected:
  /// Runs JavaScript in a page after it has drawn itself, and returns the title of the page then; "" without Chromium.
  std::string title_after(const std::string& page, const std::string& script) const {
    write("clicked.html", read(path(page)) + "<script>(async () => {\n" + script + "})();</script>\n");
    const std::string command =
        "chromium --headless=new --no-sandbox --disable-gpu --virtual-time-budget=20000 "
        "--user-data-dir=" +
        path("browser") + " --dump-dom file://" + path("clicked.html") + " > " + path("dom.html") + " 2> /dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::smatch title;
    const std::string dom = read(path("dom.html"));
    std::regex_search(dom, title, std::regex("<title>([^<]*)</title>"));
    return title[1];
  }

  /// Writes a picture of 40x30 pixels whose values grow to the right; a bright square in it is `extra` brighter.
  void write_ramp(const std::string& name, float extra) const {
    Image image(40, 30);
    std::vector<RGB> pixels;
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x)
        pixels.emplace_back(static_cast<float>(x + 1) / 40 + (x >= 10 && x < 20 && y >= 10 && y < 20 ? extra : 0.0f));
    image.add_rgb("", pixels);
    write_exr(path(name), image, ExrPrecision::single);
  }
};
using SlowReportTest = ReportTest;

bool has_chromium() { return std::system("command -v chromium > /dev/null") == 0; }

TEST_F(ReportTest, AComparisonFollowsClicks) {
  write_ramp("a.exr", 0.5f);
  write_ramp("b.exr", 0);
  const Outcome outcome = run({"compare", "a.exr", "b.exr", "--html", "a.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(read(path("a.html")), Not(HasSubstr("http")));
  if (!has_chromium()) GTEST_SKIP() << "needs chromium";
  const std::string title = title_after("a.html", R"(
while (document.body.dataset.ready !== "yes") await new Promise(done => setTimeout(done, 20));
const box = $("main").getBoundingClientRect();
const send = (type, x, y) => $("main").dispatchEvent(new PointerEvent(type, {
  clientX: box.left + x / width * box.width, clientY: box.top + y / height * box.height}));
const color = (canvas, x, y) => $(canvas).getContext("2d").getImageData(x, y, 1, 1).data.slice(0, 3).join();
const out = [];
send("pointermove", 12.5, 12.5);
out.push($("pixel").textContent);
send("pointerdown", 10.5, 10.5);
send("pointerup", 19.5, 19.5);
out.push($("region").rows[1].cells[1].textContent, $("zoom-image").width);
$("view").value = "difference";
$("view").dispatchEvent(new Event("input"));
out.push(color("main", 5, 5), color("main", 15, 15));
$("view").value = "slider";
$("split").value = 0;
$("split").dispatchEvent(new Event("input"));
const before = color("main", 5, 5);
$("exposure").value = 5;
$("exposure").dispatchEvent(new Event("input"));
out.push(before !== color("main", 5, 5) && color("main", 15, 15) === color("zoom-reference", 5, 5));
send("pointerdown", 3.5, 3.5);
send("pointerup", 3.5, 3.5);
out.push($("zoom-image").width);
document.title = out.join("; ");
)");
  EXPECT_EQ(title,
            "12, 12: picture 0.8252 0.8252 0.8252, reference 0.3250 0.3250 0.3250; 0.25; 10; 124,124,124; 255,0,0; "
            "true; 40");
}

TEST_F(ReportTest, AMeasurementHasAPlanAndKeyFigures) {
  const Outcome outcome = run({"measure", "builtin:cornell", "--grid", "y=0.5,0.1", "--samples", "2", "--photons", "2k",
                               "-o", "a.csv", "-o", "a.html", "-o", "a.png", "--false-color", "100,1000"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Image plan = read_image(path("a.png"));
  EXPECT_GT(plan.width(), plan.height());
  const std::string page = read(path("a.html")), table = read(path("a.csv"));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  double sum = 0, least = 1e30;
  int count = 0;
  std::stringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#') || line.starts_with('x')) continue;
    for (int comma = 0; comma < 10; ++comma) line = line.substr(line.find(',') + 1);
    const double level = std::stod(line);
    sum += level;
    least = std::min(least, level);
    ++count;
  }
  std::smatch mean, uniformity;
  ASSERT_TRUE(std::regex_search(page, mean, std::regex("mean illuminance</td><td>([0-9.]+) lx")));
  EXPECT_NEAR(std::stod(mean[1]), sum / count, 1e-4 * sum / count);
  ASSERT_TRUE(std::regex_search(page, uniformity, std::regex("minimum / mean</td><td>([0-9.]+)<")));
  EXPECT_NEAR(std::stod(uniformity[1]), least * count / sum, 1e-3);
  if (!has_chromium()) GTEST_SKIP() << "needs chromium";
  const std::string title = title_after("a.html", R"(
const box = plan.getBoundingClientRect(), first = sensors[0];
plan.dispatchEvent(new PointerEvent("pointermove", {clientX: box.left + first[0], clientY: box.top + first[1]}));
document.title = shown.textContent.startsWith(first[5] + " lx") && plan.naturalWidth > 600;
)");
  EXPECT_EQ(title, "true");
}

TEST_F(ReportTest, PicturesShowLuminance) {
  ASSERT_EQ(render("builtin:cornell", {"--false-color", "auto", "-o", "a.png"}).status, 0);
  EXPECT_GT(read_image(path("a.png")).width(), 16);
  EXPECT_THAT(render("builtin:cornell", {"--false-color", "auto", "-o", "a.exr"}).err, HasSubstr("no effect"));
  for (const char* scale : {"5,1", "0,1", "1", "1,nan", "1,2,3", ""})
    EXPECT_TRUE(refused(render("builtin:cornell", {"--false-color", scale, "-o", "b.png"}), {"--false-color"}, 2));
  EXPECT_TRUE(refused(run({"compare", "a.png", "a.png", "--html", "a.txt"}), {"a.txt", ".html"}, 2));
}

/// A floor of reflectance 0.5 under a point light of 10 W/sr, 2 m above: the illuminance of its middle is known.
TEST_F(SlowReportTest, PicturesShowIlluminance) {
  write("floor.pbrt", R"(LookAt 0 1 0  0 0 0  0 0 1
Camera "perspective" "float fov" [1]
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
WorldBegin
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 2 0]
Material "diffuse" "rgb reflectance" [0.5 0.25 0.5]
Shape "trianglemesh" "point3 P" [-1 0 -1  1 0 -1  1 0 1  -1 0 1] "integer indices" [0 1 2  0 2 3]
)");
  const Outcome result = run({"render", "floor.pbrt", "--samples", "2", "--false-color", "lux:100,1000", "-o",
                              "lux.png", "-o", "lux.exr", "--precision", "float"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err.find("no effect"), std::string::npos) << result.err;
  EXPECT_GT(read_image(path("lux.png")).width(), 16);
  const double expected = kLuminousEfficacy * 10.0 / 4;
  for (const float lux : illuminance_of(read_image(path("lux.exr")))) EXPECT_NEAR(lux, expected, 1e-3 * expected);
  EXPECT_TRUE(refused(run({"render", "floor.pbrt", "--false-color", "lux:5", "-o", "b.png"}), {"'lux:LOW,HIGH'"}, 2));
  ASSERT_EQ(run({"render", "floor.pbrt", "--samples", "1", "-o", "a.part"}).status, 0);
  EXPECT_TRUE(refused(run({"merge", "a.part", "--false-color", "lux", "-o", "b.png"}), {"--aov emitted,albedo"}, 1));
}

}  // namespace
}  // namespace glowworm
