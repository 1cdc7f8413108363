// Direct light through panes: shadow rays, gather rays, photons and paths agree on what a pane passes straight on.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/statistics.h"
#include "photon/photon_tracer.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"

namespace glowworm {
namespace {

struct PaneCase {
  const char* name;
  Material material;
};

std::vector<PaneCase> pane_cases() {
  Material glass;
  glass.kind = MaterialKind::thin_dielectric;
  glass.reflectance.value = RGB(1.0f);
  glass.transmittance.value = RGB(0.9f, 0.8f, 0.5f);
  Material gltf;
  gltf.kind = MaterialKind::metallic_roughness;
  gltf.reflectance.value = RGB(0.9f, 0.7f, 0.6f);
  gltf.transmission.value = 1;
  gltf.thin = true;
  Material mixed;
  mixed.kind = MaterialKind::mix;
  mixed.mix_a = mixed.mix_b = 1;  // materials of the scene: the pane itself
  return {{"glass", glass}, {"gltf", gltf}, {"mixed", mixed}};
}

/// A floor, seen from above, under two sheets of a material. @param reach half of their width, metres
SceneDescription glazed_floor(const PaneCase& pane, float reach = 4) {
  SceneDescription d = floor_description();
  d.materials.push_back(pane_cases()[0].material);
  d.materials.push_back(pane.material);
  for (const float height : {2.0f, 3.0f})
    add_quad(d, {-reach, -reach, height}, {2 * reach, 0, 0}, {0, 2 * reach, 0}, 2);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 1, 2));
  return d;
}

/// What both sheets pass from a direction.
RGB passed(const Scene& scene, Vec3 to_light) {
  const RGB once = straight_transmittance(scene, 2, {0.3f, 0.3f}, to_light);
  return once * once;
}

RGB mean_of(const Film& film, Film::Layer layer) {
  RGB sum;
  for (std::size_t i = 0; i < film.pixel_count(); ++i) sum += film.mean(layer, i);
  return sum / static_cast<float>(film.pixel_count());
}

void expect_near_in_all_channels(RGB a, RGB b, float relative) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], relative * b[c]) << c;
}

class Panes : public testing::TestWithParam<PaneCase> {};

TEST_P(Panes, PassTheSunToTheFloor) {
  SceneDescription d = glazed_floor(GetParam());
  d.lights.push_back(sun_light());
  const Stage stage(std::move(d));
  const Vec3 to_sun = -sun_light().direction;
  const RGB expected = sun_light().intensity * passed(*stage.scene, to_sun) * (to_sun.z * 0.5f * kInversePi);
  ASSERT_GT(expected.b, 0.05f);
  for (const RenderSettings& settings : {by_path(4, 1), by_photons(4, 1, 4, 10'000)}) {
    const Film film = stage.render(settings);
    expect_near_in_all_channels(mean_of(film, Film::Layer::direct), expected, 1e-4f);
    // Light that both sheets reflect is a caustic.
    EXPECT_LT(mean_of(film, Film::Layer::caustic).g, 0.03f * expected.g);
  }
}

TEST_P(Panes, PassTheSkyToTheFloor) {
  SceneDescription d = glazed_floor(GetParam(), 100);
  d.environment = Environment{};
  const Stage stage(std::move(d));
  // Integral of the cosine over the hemisphere, by midpoints: 1/2 d(cos^2) dphi.
  RGB expected;
  constexpr int kParts = 4000;
  for (int i = 0; i < kParts; ++i) {
    const float squared = (static_cast<float>(i) + 0.5f) / kParts;
    expected += passed(*stage.scene, {std::sqrt(1 - squared), 0, std::sqrt(squared)}) * (0.5f / kParts);
  }
  for (const RenderSettings& settings : {by_path(8, 4096), by_photons(8, 64, 16, 500)})
    expect_near_in_all_channels(mean_of(stage.render(settings), Film::Layer::direct), expected, 0.005f);
}

TEST_P(Panes, MakeNoCausticPhotonsButByTheirReflections) {
  SceneDescription d = glazed_floor(GetParam());
  d.lights.push_back(sun_light());
  const Stage stage(std::move(d));
  PhotonPassSettings settings;
  settings.photons = 20'000;
  Statistics statistics;
  const PhotonPass pass = trace_photons(*stage.tracer, settings, statistics);
  EXPECT_GE(pass.global.size(), 1000u);
  // Light that both sheets reflect is a caustic: less than a hundredth.
  EXPECT_LT(pass.caustic.size(), pass.global.size() / 100);
}

INSTANTIATE_TEST_SUITE_P(Slow, Panes, testing::ValuesIn(pane_cases()),
                         [](const auto& info) { return info.param.name; });

/// A leaf of glTF between a lamp and a floor: all light of the floor comes through the leaf.
TEST(SlowTransmittingSheet, PassesPhotonsToBothIntegrators) {
  SceneDescription d = floor_description();
  Material leaf;
  leaf.kind = MaterialKind::metallic_roughness;
  leaf.reflectance.value = RGB(0.2f);
  leaf.roughness_u.value = leaf.roughness_v.value = 1;
  leaf.diffuse_transmission.value = 0.8f;
  leaf.transmittance.value = RGB(0.9f, 0.8f, 0.5f);
  d.materials.push_back(leaf);
  add_quad(d, {-4, -4, 1}, {8, 0, 0}, {0, 8, 0}, 1);
  Light lamp;
  lamp.position = {0, 0, 2};
  lamp.intensity = RGB(10.0f);
  d.lights.push_back(lamp);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.5f, 2));
  d.cameras.push_back(square_view({0, 0, 1}, {0, 0, -1}, 0.5f, 2));
  d.cameras.back().name = "from below";
  const Stage stage(std::move(d));
  for (const Camera& camera : stage.scene->cameras()) {
    RenderSettings paths = by_path(16, 256), gathered = by_photons(16, 4, 64, 100'000, "blocked"), map = gathered;
    map.integrator = Integrator::photons;
    for (RenderSettings* settings : {&paths, &gathered, &map}) settings->camera = camera.name;
    const Mean expected = mean(stage.render(paths));
    for (const RenderSettings& settings : {gathered, map}) {
      const Mean found = mean(stage.render(settings));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.value[c] / expected.value[c], 1, 0.02) << camera.name << " " << c;
    }
  }
}

}  // namespace
}  // namespace glowworm
