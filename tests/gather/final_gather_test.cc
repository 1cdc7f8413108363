// Gather rays through glass, and the secondary gather.
#include "gather/final_gather.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "builtin/builtin.h"
#include "core/random.h"
#include "gather/camera_pass.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

TEST(FinalGather, RaysThroughGlassBringNoMoreLight) {
  const Scene scene(builtin_scene("glass-sphere"));
  const Tracer tracer(scene);
  CameraPassSettings camera_settings;
  camera_settings.width = 64;
  camera_settings.height = 48;
  const CameraTask task{0, 0, 64, 48, 0, 4};
  Statistics statistics;
  SlotRadiance radiance;
  FirstHit first_hit;
  const GatherPoints points =
      camera_pass(tracer, scene.camera(""), task, camera_settings, radiance, first_hit, statistics);
  FinalGatherSettings settings;
  QueryPoints queries;
  final_gather(tracer, points, 0, points.size(), settings, radiance, {queries}, statistics);
  float most = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    most = std::max(most, max_component(points.throughput[i] * points.bsdf[i].diffuse));
  ASSERT_GT(queries.size(), 1000u);
  for (const RGB& weight : queries.weight)
    ASSERT_LE(max_component(weight) * static_cast<float>(settings.rays), 1.0001f * most);
}

/// A floor with a wall on it under the surface of glass and, above that, a lamp: no light but through the glass, which
/// bends it.
SceneDescription corner_under_glass() {
  SceneDescription d = floor_description();
  Material glass;
  glass.kind = MaterialKind::dielectric;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  d.materials.push_back(glass);
  add_quad(d, {0, -2, 0}, {0, 4, 0}, {0, 0, 2});
  add_quad(d, {-9, -9, 3}, {18, 0, 0}, {0, 18, 0}, 1);
  add_quad(d, {-9, -9, 4}, {0, 18, 0}, {18, 0, 0}, 0, add_emission(d, RGB(100.0f)));
  return d;
}

GatherPoints points_beside_the_wall() {
  GatherPoints points;
  for (std::uint32_t i = 0; i < 100; ++i) {
    points.slot.push_back(i);
    points.sequence.push_back(i);
    points.sample.push_back(0);
    points.position.push_back({0.1f, 0.01f * static_cast<float>(i) - 0.5f, 0});
    points.normal.push_back({0, 0, 1});
    points.offset.push_back(1e-6f);
    points.frame.push_back(Frame::from_normal({0, 0, 1}));
    points.wo.push_back({0, 0, 1});
    Bsdf bsdf;
    bsdf.diffuse = RGB(0.5f);
    points.bsdf.push_back(bsdf);
    points.throughput.push_back(RGB(1.0f));
  }
  return points;
}

TEST(FinalGather, LightThroughGlassBelongsToTheCausticMapInCornersToo) {
  const Scene scene(corner_under_glass());
  const Tracer tracer(scene);
  const GatherPoints points = points_beside_the_wall();
  std::vector<Vec3> wall;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    Sampler s(SamplerKind::independent, 1, 1, i);
    const Vec2 u = s.next2();
    wall.push_back({0, 4 * u.x - 2, 2 * u.y});
  }
  const RadiusGrid radii(wall, std::vector<float>(wall.size(), 0.5f));
  FinalGatherSettings settings;
  settings.radii = &radii;
  Statistics statistics;
  QueryPoints queries, caustic_queries;
  SlotRadiance by_chance, by_map;
  by_chance.resize(points.size());
  by_map.resize(points.size());
  final_gather(tracer, points, 0, points.size(), settings, by_chance, {queries}, statistics);
  final_gather(tracer, points, 0, points.size(), settings, by_map, {queries, &caustic_queries}, statistics);
  float found = 0;
  for (const RGB& value : by_chance.indirect) found += value.g;
  EXPECT_GT(found, 0);
  for (const RGB& value : by_map.indirect) EXPECT_EQ(value.g, 0);
  ASSERT_GT(caustic_queries.size(), 1000u);
  for (std::size_t i = 0; i < caustic_queries.size(); ++i) {
    EXPECT_NEAR(caustic_queries.position[i].x, 0, 1e-5f);
    EXPECT_LT(length(caustic_queries.position[i] - points.position[caustic_queries.gather_point[i]]), 0.5f);
  }
}

}  // namespace
}  // namespace glowworm
