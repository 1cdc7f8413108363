#include "builtin/builtin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "mesh_checks.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

class EveryBuiltinScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryBuiltinScene, HasSoundTables) {
  const SceneDescription scene = builtin_scene(GetParam());
  const Geometry& g = scene.geometry;
  EXPECT_EQ(scene.name, GetParam());
  ASSERT_GT(g.triangle_count(), 0u);
  ASSERT_EQ(g.material.size(), g.triangle_count());
  ASSERT_EQ(g.emission.size(), g.triangle_count());
  ASSERT_EQ(g.normals.size(), g.positions.size());
  ASSERT_EQ(g.uvs.size(), g.positions.size());
  bool emits = false;
  for (std::size_t t = 0; t < g.triangle_count(); ++t) {
    for (const std::uint32_t v : g.triangles[t]) ASSERT_LT(v, g.positions.size());
    ASSERT_LT(g.material[t], scene.materials.size());
    ASSERT_TRUE(g.emission[t] == kNone || g.emission[t] < scene.emissions.size());
    emits = emits || g.emission[t] != kNone;
  }
  EXPECT_TRUE(emits || !scene.lights.empty() || scene.environment);
  EXPECT_FALSE(scene.cameras.empty());
  EXPECT_GT(scene.film.width, 0);
  EXPECT_GT(scene.film.height, 0);
}

TEST_P(EveryBuiltinScene, HasNoDegenerateTrianglesAndNoWrongNormals) {
  const Geometry g = builtin_scene(GetParam()).geometry;
  for (const Vec3& p : g.positions) ASSERT_TRUE(is_finite(p));
  EXPECT_EQ(slivers(g, 1e-5f), 0u);
  EXPECT_EQ(wrong_normals(g), 0u);
}

TEST_P(EveryBuiltinScene, HasPlausibleAlbedos) {
  for (const Material& material : builtin_scene(GetParam()).materials) {
    if (material.kind != MaterialKind::diffuse) continue;
    EXPECT_LE(max_component(material.reflectance.value), 0.9f) << material.name;
    for (int c = 0; c < 3; ++c) EXPECT_GE(material.reflectance.value[c], 0) << material.name;
  }
}

TEST_P(EveryBuiltinScene, IsTheSameEachTime) {
  const Geometry a = builtin_scene(GetParam()).geometry, b = builtin_scene(GetParam()).geometry;
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.material, b.material);
}

INSTANTIATE_TEST_SUITE_P(Builtin, EveryBuiltinScene, testing::ValuesIn(builtin_scene_names()), scene_test_name);

TEST(Builtin, UnknownNameListsTheScenes) {
  try {
    builtin_scene("cornel");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'cornel'"));
    for (const std::string& name : builtin_scene_names()) EXPECT_THAT(error.what(), testing::HasSubstr(name));
  }
}

TEST(FurnaceBox, IsAClosedUnitBoxSeenFromInsideThatEmitsEverywhere) {
  const SceneDescription scene = builtin_scene("furnace-box");
  const Geometry& g = scene.geometry;
  EXPECT_EQ(g.triangle_count(), 12u);
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_NEAR(signed_volume(g), -1, 1e-6);
  EXPECT_NEAR(total_area(g), 6, 1e-6);
  for (std::size_t t = 0; t < g.triangle_count(); ++t) {
    EXPECT_NE(g.emission[t], kNone);
    EXPECT_TRUE(scene.materials[g.material[t]].reflectance.value == RGB(0.5f));
  }
}

}  // namespace
}  // namespace glowworm
