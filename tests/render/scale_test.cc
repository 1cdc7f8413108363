// Pictures do not depend on the unit of length or the position of the origin.
#include <gtest/gtest.h>

#include <cmath>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene_checks.h"
#include "scene/scene_parts.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

constexpr const char* kScenes[] = {"cornell", "ajar", "glass-sphere", "window-room", "atrium", "ring"};

/// The scene `scale` times as large and moved by `shift` times its own size along a slanted line. Lamps without extent
/// are made so strong that they light it alike.
/// @param back moves it back again, with vertices that have been rounded far away
SceneDescription placed(const char* name, float scale, float shift, bool back = false) {
  SceneDescription d = builtin_scene(name);
  const float size = length(d.geometry.bounds().diagonal());
  const Vec3 by = Vec3{0.48f, -0.6f, 0.64f} * (shift * size * scale);
  const auto move = [&](Vec3& p) {
    p = p * scale + by;
    if (back) p -= by;
  };
  for (Vec3& p : d.geometry.positions) move(p);
  for (Light& light : d.lights) {
    move(light.position);
    if (light.kind != LightKind::directional) light.intensity *= scale * scale;
  }
  for (Camera& camera : d.cameras) {
    move(camera.to_world.translation);
    camera.lens_radius *= scale;
    camera.focal_distance *= scale;
    if (camera.kind == CameraKind::orthographic) camera.half_extent *= scale;
  }
  return d;
}

RenderSettings settings_of(Integrator integrator, int side, std::uint32_t samples) {
  return integrator == Integrator::path ? by_path(side, samples) : by_photons(side, samples, 16, 5000, "blocked");
}

constexpr Integrator kIntegrators[] = {Integrator::path, Integrator::gather, Integrator::photons};

class ScaledScenes : public testing::TestWithParam<const char*> {};

/// Numbers times a power of two are rounded alike, so that any length in the program that is not the scene's shows.
TEST_P(ScaledScenes, LookTheSameToTheBitAtPowersOfTwo) {
  const float size = length(builtin_scene(GetParam()).geometry.bounds().diagonal());
  // Cameras may stand as far outside.
  const float largest = std::ldexp(1.0f, std::ilogb(kMaxCoordinate / size) - 1);
  for (const Integrator integrator : kIntegrators) {
    RenderSettings settings = settings_of(integrator, 16, 1);
    settings.integrator = integrator;
    const std::vector<RGB> original = pixels(Stage(placed(GetParam(), 1, 0)).render(settings));
    EXPECT_GT(mean(original).luminance(), 0);
    for (const float scale : {0x1p-20f, 0x1p+20f, largest})
      EXPECT_EQ(pixels(Stage(placed(GetParam(), scale, 0)).render(settings)), original)
          << "scale " << scale << ", integrator " << static_cast<int>(integrator);
  }
}

class DistantScenes : public testing::TestWithParam<const char*> {};

/// The vertices are rounded there, but nothing else is.
TEST_P(DistantScenes, LookAsIfMovedBackToTheBit) {
  const SceneDescription distant = placed(GetParam(), 1, 1e4f);
  const Stage stage(distant);
  EXPECT_GT(length(stage.scene->origin()), 9e3f * length(distant.geometry.bounds().diagonal()));
  SceneDescription back = distant;
  translate(back, -stage.scene->origin());
  const Stage original(back);
  EXPECT_EQ(original.scene->origin(), (Vec3{0, 0, 0}));
  for (const Integrator integrator : {Integrator::path, Integrator::gather}) {
    const RenderSettings settings = settings_of(integrator, 16, 2);
    const std::vector<RGB> picture = pixels(stage.render(settings));
    EXPECT_GT(mean(picture).luminance(), 0);
    EXPECT_EQ(picture, pixels(original.render(settings)));
  }
}

INSTANTIATE_TEST_SUITE_P(Builtin, DistantScenes, testing::ValuesIn(kScenes), scene_test_name);
INSTANTIATE_TEST_SUITE_P(Builtin, ScaledScenes, testing::Values(kScenes[0]), scene_test_name);
INSTANTIATE_TEST_SUITE_P(Slow, ScaledScenes, testing::ValuesIn(std::begin(kScenes) + 1, std::end(kScenes)),
                         scene_test_name);

}  // namespace
}  // namespace glowworm
