// Photon maps whose settings change: they are those of the last settings, whatever came before.
#include "maps/photon_maps.h"

#include <gtest/gtest.h>

#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// Radiance that a map gives points on the floor.
std::vector<RGB> light_of(const PhotonMaps& maps) {
  constexpr int kSide = 24;
  QueryPoints points;
  for (int i = 0; i < kSide * kSide; ++i) {
    const float x = static_cast<float>(i % kSide) / kSide, z = static_cast<float>(i / kSide) / kSide;
    points.push_back({2 * x - 1, 0, 2 * z - 1}, {0, 1, 0}, RGB(1.0f), RGB(1.0f), 0);
  }
  std::vector<RGB> light(points.size());
  Statistics statistics;
  for (const PhotonMaps::Engines* engines : {&maps.engines(), &maps.caustic_engines()})
    for (const auto& engine : *engines) engine->estimate(points, light, statistics);
  return light;
}

TEST(PhotonMaps, AreThoseOfTheLastSettings) {
  const Stage stage(builtin_scene("glass-sphere"));
  PhotonMapSettings first;
  first.photons = 3000;
  first.more_caustic_paths = 20'000;
  std::vector<PhotonMapSettings> changes(7, first);
  changes[1].correction = BoundaryCorrection::photons;
  changes[2].kernel = KernelShape::cone;
  changes[3].fixed_radius = true;
  changes[4].sampled = true;
  changes[5].pass = 1;
  changes[6].nearest = 20;
  for (const bool kept : {true, false}) {
    MemoryBudget budget(std::uint64_t{1} << 30);
    PhotonMaps changed(budget);
    Statistics statistics;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      changes[i].kept = kept;
      changed.update(*stage.tracer, changes[i], statistics);
      PhotonMaps anew(budget);
      anew.update(*stage.tracer, changes[i], statistics);
      EXPECT_EQ(light_of(changed), light_of(anew)) << i << kept;
    }
  }
}

/// On plates smaller than the discs of their photons, the k nearest photons reach other plates. Flux is conserved all
/// the same, as with a radius for each photon.
TEST(PhotonMaps, NearestPhotonsOnSmallPlatesKeepTheirFlux) {
  constexpr int kPlates = 8;
  constexpr float kSide = 0.1f;
  SceneDescription d;
  d.materials.emplace_back();
  QueryPoints points;
  for (int i = 0; i < kPlates * kPlates; ++i) {
    const Vec3 corner{2 * kSide * static_cast<float>(i % kPlates), 0, 2 * kSide * static_cast<float>(i / kPlates)};
    add_quad(d, corner, {0, 0, kSide}, {kSide, 0, 0});
    for (int j = 0; j < 25; ++j) {
      const Vec3 within{static_cast<float>(j % 5) + 0.5f, 0, static_cast<float>(j / 5) + 0.5f};
      points.push_back(corner + within * (kSide / 5), {0, 1, 0}, RGB(1.0f), RGB(1.0f), 0);
    }
  }
  d.lights.emplace_back();
  d.lights[0].kind = LightKind::directional;
  d.lights[0].direction = {0, -1, 0};
  const Stage stage(std::move(d));
  const auto light_by = [&](const char* engine, std::uint32_t seed) {
    PhotonMapSettings settings;
    settings.seed = seed;
    settings.photons = 2000;
    settings.engine = engine;
    settings.correction = BoundaryCorrection::photons;
    MemoryBudget budget(std::uint64_t{1} << 30);
    PhotonMaps maps(budget);
    Statistics statistics;
    maps.update(*stage.tracer, settings, statistics);
    std::vector<RGB> light(points.size());
    for (const auto& found : maps.engines()) found->estimate(points, light, statistics);
    return mean(light).value[1];
  };
  constexpr std::uint32_t kSeeds = 4;
  double ratio = 0;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
    ratio += light_by("knn", seed) / light_by("blocked", seed) / kSeeds;
  EXPECT_NEAR(ratio, 1, 0.03);
}

TEST(PhotonMaps, KeepACorrectionThatAMovingViewLeavesOut) {
  const Stage stage(builtin_scene("cornell"));
  MemoryBudget budget(std::uint64_t{1} << 30);
  PhotonMaps maps(budget);
  Statistics statistics;
  PhotonMapSettings settings;
  settings.photons = 3000;
  maps.update(*stage.tracer, settings, statistics);
  const std::vector<RGB> without = light_of(maps);
  settings.correction = BoundaryCorrection::photons;
  maps.update(*stage.tracer, settings, statistics);
  const std::vector<RGB> corrected = light_of(maps);
  EXPECT_NE(corrected, without);
  settings.correction = BoundaryCorrection::none;
  maps.update(*stage.tracer, settings, statistics);
  EXPECT_EQ(light_of(maps), corrected);
  EXPECT_EQ(statistics.count(Counter::photons_emitted), maps.pass().emitted) << "traced once";
}

}  // namespace
}  // namespace glowworm
