// Photons do not leak through thin walls or around corners.
#include <gtest/gtest.h>

#include "density/engine.h"
#include "gather/final_gather.h"
#include "photon/photon_tracer.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// A floor and a wall that stands on it, under a sun along the wall, so that only the floor is lit.
SceneDescription floor_and_wall() {
  SceneDescription d = floor_description();
  add_quad(d, {0, -2, 0}, {0, 4, 0}, {0, 0, 2});
  Light sun;
  sun.kind = LightKind::directional;
  sun.direction = {0, 0, -1};
  d.lights.push_back(sun);
  return d;
}

PhotonPass first_photons(const Scene& scene) {
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  settings.photons = 20'000;
  settings.max_bounces = 1;
  Statistics statistics;
  return trace_photons(tracer, settings, statistics);
}

class Leaks : public testing::TestWithParam<std::string> {
 protected:
  std::vector<RGB> look_up(const PhotonBatch& photons, const QueryPoints& queries) {
    const std::unique_ptr<DensityEngine> engine = make_engine(GetParam());
    RadiusPolicy policy;
    policy.kind = GetParam() == "knn" ? RadiusKind::nearest : RadiusKind::per_photon;
    policy.max_radius = 0.2f;
    policy.radii.assign(photons.size(), 0.1f);
    Statistics statistics;
    engine->build(photons, photons.flux, policy, statistics);
    std::vector<RGB> found(queries.size());
    engine->estimate(queries, found, statistics);
    return found;
  }
};

TEST_P(Leaks, TheBackOfAThinSheetStaysBlack) {
  const Scene scene(floor_and_wall());
  const PhotonPass pass = first_photons(scene);
  QueryPoints queries;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p{-1.5f + 0.015f * static_cast<float>(i), 0.3f, 0};
    queries.push_back(p, {0, 0, 1}, RGB(0.5f), RGB(1.0f), 0);
    queries.push_back(p, {0, 0, -1}, RGB(0.5f), RGB(1.0f), 0);
  }
  const std::vector<RGB> found = look_up(pass.global, queries);
  for (std::size_t i = 0; i < found.size(); i += 2) {
    EXPECT_GT(found[i].g, 0);
    EXPECT_EQ(found[i + 1].g, 0);
  }
}

TEST_P(Leaks, TheUnlitWallOfACornerStaysBlack) {
  const Scene scene(floor_and_wall());
  const PhotonPass pass = first_photons(scene);
  QueryPoints queries;
  for (int i = 0; i < 100; ++i) {
    const float height = 0.001f * static_cast<float>(i);
    queries.push_back({0, 0.3f, height}, {1, 0, 0}, RGB(0.5f), RGB(1.0f), 0);
    queries.push_back({0, 0.3f, height}, {-1, 0, 0}, RGB(0.5f), RGB(1.0f), 0);
  }
  for (const RGB& radiance : look_up(pass.global, queries)) EXPECT_EQ(radiance.g, 0);
}

INSTANTIATE_TEST_SUITE_P(Engines, Leaks, testing::ValuesIn(engine_names()),
                         [](const auto& info) { return info.param; });

TEST(RadiusGrid, GivesTheMeanRadiusOfItsCells) {
  const std::vector<Vec3> positions = {{0, 0, 0}, {0.001f, 0, 0}, {1, 0, 0}};
  const std::vector<float> radii = {0.1f, 0.3f, 0.5f};
  const RadiusGrid grid(positions, radii);
  EXPECT_FLOAT_EQ(grid.radius({0, 0, 0}), 0.2f);
  EXPECT_FLOAT_EQ(grid.radius({1, 0, 0}), 0.5f);
  EXPECT_EQ(grid.radius({0.5f, 0, 0}), 0);
  EXPECT_FLOAT_EQ(grid.max_radius(), 0.5f);
  EXPECT_EQ(RadiusGrid().radius({0, 0, 0}), 0);
}

}  // namespace
}  // namespace glowworm
