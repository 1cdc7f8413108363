// Views as Radiance writes them.
#include "scene/radiance_view.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "scene_parts.h"

namespace glowworm {
namespace {

TEST(RadianceView, ReadsOptionsAndSkipsOthers) {
  const RadianceView view = parse_radiance_view("rvu -vta -vp 1 2.5 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 160 -vo 0");
  EXPECT_EQ(view.kind, CameraKind::fisheye);
  EXPECT_EQ(view.position.y, 2.5);
  EXPECT_EQ(view.direction.y, -1);
  EXPECT_EQ(view.vertical, 160);
  EXPECT_EQ(radiance_view_text(view), "-vta -vp 1 2.5 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 160");
  for (const char* wrong : {"-vtc -vp 0 0 0", "-vp 1 2", "-vd 0 0 1 -vu 0 0 1", "-vh x", "-vd 0 0 0", "-vh 0",
                            "-vtv -vv 180", "-vth -vh 181", "-vta -vv -1"})
    EXPECT_THROW(parse_radiance_view(wrong), Error) << wrong;
}

TEST(RadianceView, PlacesKeepTheirMillimetres) {
  const std::string far = "-vtv -vp 691234.567 5334567.891 -512.25 -vd 0 1 0 -vu 0 0 1 -vh 60 -vv 40";
  EXPECT_EQ(radiance_view_text(parse_radiance_view(far)), far);
}

TEST(RadianceView, CamerasHaveTheShapeOfTheView) {
  const auto aspect = [](const std::string& view) { return camera_of(parse_radiance_view(view), true, {}).aspect; };
  EXPECT_FLOAT_EQ(aspect("-vtv -vh 90 -vv 53.130102"), 2);
  EXPECT_FLOAT_EQ(aspect("-vtl -vh 3 -vv 4"), 0.75f);
  EXPECT_FLOAT_EQ(aspect("-vta -vh 180 -vv 90"), 2);
  EXPECT_FLOAT_EQ(aspect("-vth -vh 60 -vv 180"), 0.5f);
}

TEST(RadianceView, CamerasComeBackFromTheirText) {
  SceneDescription description = floor_description();
  description.z_up = true;
  const Scene scene(std::move(description));
  const std::string text = "-vth -vp 1 2 3 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180";
  const Camera camera = camera_of(parse_radiance_view(text), scene);
  EXPECT_EQ(radiance_view_text(camera, scene, 64, 64), text);
  // y of the file is -z of the scene, and right of it is x.
  const CameraRay right = generate_ray(camera, {63.9f, 32}, 64, 64, {});
  EXPECT_GT(right.direction.x, 0.9f);
  Camera panorama = camera;
  panorama.kind = CameraKind::panorama;
  EXPECT_EQ(radiance_view_text(panorama, scene, 64, 32), "");
}

}  // namespace
}  // namespace glowworm
