// --ocio of the commands.
#include <gmock/gmock.h>

#include <cmath>

#include "apps/program.h"
#include "image/image.h"
#include "image/tone_map.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

class ColorViewOptionsTest : public ProgramTest {
 protected:
  ColorViewOptionsTest() {
    write("c.ocio", R"(ocio_profile_version: 2
roles: {scene_linear: reference, default: reference}
displays:
  screen:
    - !<View> {name: Plain, colorspace: reference}
    - !<View> {name: Root, colorspace: root}
colorspaces:
  - !<ColorSpace>
    name: reference
  - !<ColorSpace>
    name: root
    from_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1], direction: inverse}
)");
  }

  /// Largest difference in codes between a PNG file and the roots of the light of an EXR file, four times as bright.
  double difference(const std::string& png, const std::string& exr) const {
    const std::vector<RGB> shown = read_image(path(png)).rgb(), light = read_image(path(exr)).rgb();
    double largest = shown.size() == light.size() ? 0 : 256;
    for (std::size_t i = 0; i < light.size() && largest < 256; ++i)
      for (int c = 0; c < 3; ++c) {
        const int code = to_byte(srgb_encode(shown[i][c])), expected = to_byte(std::sqrt(4 * light[i][c]));
        largest = std::max(largest, std::abs(double{1} * (code - expected)));
      }
    return largest;
  }
};

TEST_F(ColorViewOptionsTest, ShowTheLightOfRendersMergesAndSessions) {
  const std::vector<std::string> view = {"--ocio", "c.ocio", "--view-transform", "Root", "--exposure", "2"};
  std::vector<std::string> more = {"--precision", "float", "-o", "a.exr", "-o", "a.png", "-o", "a.part"};
  more.insert(more.end(), view.begin(), view.end());
  const Outcome rendered = render("builtin:cornell", more);
  EXPECT_EQ(rendered.status, 0) << rendered.err;
  EXPECT_THAT(rendered.err, HasSubstr("a.png, Root on screen"));
  EXPECT_LE(difference("a.png", "a.exr"), 1);
  ASSERT_EQ(render("builtin:cornell", {"--precision", "float", "-o", "plain.exr"}).status, 0);
  EXPECT_EQ(read_image(path("plain.exr")).rgb().front().r, read_image(path("a.exr")).rgb().front().r);

  std::vector<std::string> merge = {"merge", "a.part", "-o", "merged.png"};
  merge.insert(merge.end(), view.begin(), view.end());
  EXPECT_EQ(run(merge).status, 0);
  EXPECT_LE(difference("merged.png", "a.exr"), 1);

  for (const std::string format : {"png", "exr"}) {
    std::vector<std::string> play = {"view", "builtin:cornell", "--size", "16x16",    "--photons", "2k", "--frames",
                                     "1",    "--out",           format,   "--format", format};
    play.insert(play.end(), view.begin(), view.end());
    const Outcome played = run(play);
    EXPECT_EQ(played.status, 0) << played.err;
  }
  EXPECT_LE(difference("png/00000.png", "exr/00000.exr"), 1);
}

TEST_F(ColorViewOptionsTest, AreRefusedBeforeTheRender) {
  EXPECT_TRUE(refused(render("builtin:cornell", {"--ocio", "c.ocio", "--view-transform", "AgX", "-o", "a.png"}),
                      {"c.ocio", "AgX", "Its views: Plain, Root."}));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--ocio", "none.ocio", "-o", "a.png"}), {"none.ocio"}));
  EXPECT_EQ(render("builtin:cornell", {"--view-transform", "Root", "-o", "a.png"}).status, 2);
  EXPECT_EQ(render("builtin:cornell", {"--ocio", "c.ocio", "--tone", "srgb", "-o", "a.png"}).status, 2);
  EXPECT_TRUE(refused(render("builtin:cornell", {"--ocio", "c.ocio", "-o", "./c.ocio"}), {}, 2));
}

}  // namespace
}  // namespace glowworm
