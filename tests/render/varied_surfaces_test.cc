// Surfaces whose scattering changes from point to point, within the reach of an estimate: photon maps have the light of
// the path tracer.
#include <gtest/gtest.h>

#include <cmath>

#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// A floor that a lamp lights, under a ceiling that sees nothing else. Cameras see the ceiling, and the floor.
SceneDescription lit_from_the_floor() {
  SceneDescription d = floor_description();
  d.materials.emplace_back();
  add_quad(d, {-2, -2, 1}, {0, 4, 0}, {4, 0, 0}, 1);
  add_quad(d, {0.7f, -0.2f, 0.8f}, {0, 0.4f, 0}, {0.4f, 0, 0}, 1, add_emission(d, RGB(10.0f)));
  d.cameras.push_back(square_view({0, 0, 1}, {0, 0, -1}, 0.5f, 1));
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.5f, 1));
  d.cameras.back().name = "floor";
  return d;
}

void expect_light_of_paths(SceneDescription d) {
  const Stage stage(std::move(d));
  for (const Camera& camera : stage.scene->cameras()) {
    RenderSettings paths = by_path(24, 256), gathered = by_photons(24, 16, 64, 50'000, "blocked"), map = gathered;
    map.integrator = Integrator::photons;
    map.photons = 1'000'000;  // pictures of the map of 50,000 photons deviate by 4%
    for (RenderSettings* settings : {&paths, &gathered, &map}) settings->camera = camera.name;
    const double expected = mean(stage.render(paths)).luminance();
    EXPECT_NEAR(mean(stage.render(gathered)).luminance() / expected, 1, 0.03) << camera.name;
    EXPECT_NEAR(mean(stage.render(map)).luminance() / expected, 1, 0.03) << camera.name;
  }
}

TEST(SlowVariedSurfaces, MixesOfBroadAndSharpMaterials) {
  SceneDescription d = lit_from_the_floor();
  Material mirror;
  mirror.kind = MaterialKind::conductor;
  mirror.use_reflectance = true;
  mirror.reflectance.value = RGB(0.0f);
  mirror.roughness_u.value = mirror.roughness_v.value = 0;
  d.materials.push_back(mirror);
  d.materials.push_back(d.materials[1]);
  d.materials[0].kind = MaterialKind::mix;
  d.materials[0].mix_a = 3;
  d.materials[0].mix_b = 2;
  d.materials[0].mix_amount.value = 0.6f;
  expect_light_of_paths(std::move(d));
}

/// A floor with cells of 4 cm, half of them black.
SceneDescription checkered() {
  SceneDescription d = lit_from_the_floor();
  for (const float value : {1.0f, 0.0f}) d.textures.emplace_back().value = RGB(value);
  TextureNode& cells = d.textures.emplace_back();
  cells.kind = TextureKind::checkerboard;
  cells.child_a = 0;
  cells.child_b = 1;
  cells.uv_scale = {100, 100};
  d.materials[0].reflectance = {RGB(0.8f), 2};
  return d;
}

TEST(SlowVariedSurfaces, BlackTexels) { expect_light_of_paths(checkered()); }

TEST(SlowVariedSurfaces, BlackTexelsUnderACoat) {
  SceneDescription d = checkered();
  d.materials[0].kind = MaterialKind::coated_diffuse;
  d.materials[0].roughness_u.value = d.materials[0].roughness_v.value = 0;
  expect_light_of_paths(std::move(d));
}

}  // namespace
}  // namespace glowworm
