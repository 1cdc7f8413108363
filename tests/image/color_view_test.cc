// Views of OpenColorIO configs against the formulas of their transforms.
#include "image/color_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "core/error.h"
#include "image/tone_map.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ColorViewTest : public FolderTest {
 protected:
  /// Writes a config whose reference space is the role named, with two displays.
  std::string write_config(const std::string& role) const {
    std::string file = path("config.ocio");
    std::ofstream(file) << "ocio_profile_version: 2\n"
                           "roles: {"
                        << role << R"(: reference, default: reference}
displays:
  screen:
    - !<View> {name: Root, colorspace: root}
    - !<View> {name: Mixed, colorspace: mixed}
    - !<View> {name: Raw, colorspace: reference}
    - !<View> {name: Torn, colorspace: torn}
  wall:
    - !<View> {name: Plain, colorspace: reference}
colorspaces:
  - !<ColorSpace>
    name: reference
  - !<ColorSpace>
    name: root
    from_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1], direction: inverse}
  - !<ColorSpace>
    name: mixed
    from_scene_reference: !<MatrixTransform> {matrix: [0, 0.5, 0, 0, 0.25, 0, 0.25, 0, 1, 0, 0, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: torn
    from_scene_reference: !<FileTransform> {src: missing.cube}
)";
    return file;
  }

  /// What an Error of the request says.
  static std::string failure(const ColorViewRequest& request) {
    try {
      load_color_view(request);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  /// The codes of one pixel.
  static std::vector<int> codes(const ColorViewRequest& request, RGB pixel, float exposure = 0) {
    const std::vector<std::uint8_t> bytes = shown_by(*load_color_view(request), std::vector<RGB>{pixel}, exposure);
    return {bytes.begin(), bytes.end()};
  }
};

TEST_F(ColorViewTest, AppliesTheTransformsOfTheConfig) {
  const std::string config = write_config("scene_linear");
  EXPECT_THAT(codes({config, "screen", "Root"}, {0.25f, 0.64f, 0.01f}), ElementsAre(128, 204, 26));
  EXPECT_THAT(codes({config, "screen", "Mixed"}, {0.4f, 0.8f, 0.2f}), ElementsAre(102, 38, 102));
  EXPECT_THAT(codes({config, "wall", ""}, {0.2f, 0.4f, 2}), ElementsAre(51, 102, 255));
  // The default view; exposure comes first.
  EXPECT_THAT(codes({config, "", ""}, {0.04f, 0.01f, 0}, 2), ElementsAre(102, 51, 0));
  EXPECT_EQ(load_color_view({config, "", ""})->name(), "Root on screen");
}

TEST_F(ColorViewTest, EntersAnAcesConfigInItsPrimaries) {
  const std::string config = write_config("aces_interchange");
  EXPECT_THAT(codes({config, "", "Raw"}, {1, 1, 1}), ElementsAre(255, 255, 255));
  // A column of the matrix from Rec. 709 to AP0 each.
  EXPECT_THAT(codes({config, "", "Raw"}, {1, 0, 0}), ElementsAre(112, 23, 4));
  EXPECT_THAT(codes({config, "", "Raw"}, {0, 1, 0}), ElementsAre(98, 207, 28));
  EXPECT_THAT(codes({config, "", "Raw"}, {0, 0, 1}), ElementsAre(45, 25, 222));
}

TEST_F(ColorViewTest, ShowsEveryNumber) {
  const std::string config = write_config("scene_linear");
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_THAT(codes({config, "", "Mixed"}, {kInfinity, kInfinity, -kInfinity}), ElementsAre(255, 0, 255));
  EXPECT_THAT(codes({config, "", "Mixed"}, {std::nanf(""), 0.4f, 0.8f}), ElementsAre(51, 51, 0));
}

TEST_F(ColorViewTest, ErrorsNameTheConfigAndWhatItHas) {
  const std::string config = write_config("scene_linear");
  EXPECT_THAT(failure({config, "", "AgX"}), AllOf(HasSubstr("config.ocio"), HasSubstr("no view 'AgX'"),
                                                  HasSubstr("Its views: Root, Mixed, Raw, Torn.")));
  EXPECT_THAT(failure({config, "moon", ""}),
              AllOf(HasSubstr("no display 'moon'"), HasSubstr("Its displays: screen, wall.")));
  EXPECT_THAT(failure({config, "", "Torn"}), AllOf(HasSubstr("config.ocio"), HasSubstr("missing.cube")));
  EXPECT_THAT(failure({write_config("matte_paint"), "", ""}), HasSubstr("neither the role aces_interchange"));
  EXPECT_THAT(failure({path("none.ocio"), "", ""}), HasSubstr("none.ocio"));
  std::ofstream(path("bad.ocio")) << "ocio_profile_version: 2\nroles:\n  scene_linear: [\n";
  EXPECT_THAT(failure({path("bad.ocio"), "", ""}), AllOf(HasSubstr("bad.ocio"), HasSubstr("line 4")));
  std::ofstream(path("empty.ocio")) << "";
  EXPECT_THAT(failure({path("empty.ocio"), "", ""}), HasSubstr("empty.ocio"));
}

TEST(ColorView, ShowsBlendersStandardViewAsSrgb) {
  const std::string config = "/usr/share/blender/datafiles/colormanagement/config.ocio";
  if (!std::filesystem::exists(config)) GTEST_SKIP() << "Blender is not installed";
  const auto view = load_color_view({config, "sRGB", "Standard"});
  std::vector<RGB> pixels;
  for (int i = 0; i <= 50; ++i) {
    const float t = static_cast<float>(i) / 50;
    pixels.push_back({t, t * t, 1 - t});
  }
  const std::vector<std::uint8_t> bytes = shown_by(*view, pixels, 0);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(bytes[3 * i + static_cast<std::size_t>(c)], to_byte(srgb_encode(pixels[i][c])), 1) << i;
}

}  // namespace
}  // namespace glowworm
