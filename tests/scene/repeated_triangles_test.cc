// Triangles that lie exactly upon others.
#include "scene/repeated_triangles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// Adds a triangle with vertices of its own.
void add_triangle(Geometry& g, Vec3 a, Vec3 b, Vec3 c, std::uint32_t material = 0, std::uint32_t emission = kNone) {
  Geometry triangle;
  triangle.positions = {a, b, c};
  triangle.triangles = {{0, 1, 2}};
  append_mesh(g, triangle, "triangle", material, emission);
}

TEST(RepeatedTriangles, HaveTheSameCornersWindingMaterialAndEmission) {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  Geometry g;
  add_triangle(g, a, b, c);
  add_triangle(g, b, {1, 1, 0}, c);
  add_triangle(g, b, c, a);
  add_triangle(g, a, c, b);
  add_triangle(g, a, b, c, 1);
  add_triangle(g, a, b, c, 0, 0);
  add_triangle(g, a, b, {0, 1, 1e-6f});
  add_triangle(g, c, {-0.0f, 0, -0.0f}, b);
  add_triangle(g, a, b, c, 1);
  EXPECT_THAT(repeated_triangles(g, {false, false}),
              testing::ElementsAre(false, false, true, false, false, false, false, true, true));
  EXPECT_THAT(repeated_triangles(g, {false, true}),
              testing::ElementsAre(false, false, true, false, false, false, false, true, false));
}

TEST(RepeatedTriangles, AreFoundAmongMany) {
  Geometry g;
  constexpr std::uint32_t kMany = 100'000;
  for (std::uint32_t i = 0; i < kMany; ++i) add_triangle(g, {static_cast<float>(i), 0, 0}, {0, 1, 0}, {0, 0, 1});
  EXPECT_TRUE(repeated_triangles(g, {false}).empty());
  for (std::uint32_t i = 0; i < kMany; ++i) g.triangles.push_back(g.triangles[i]);
  g.material.resize(2 * kMany, 0);
  g.emission.resize(2 * kMany, kNone);
  const std::vector<bool> repeated = repeated_triangles(g, {false});
  EXPECT_EQ(std::count(repeated.begin(), repeated.begin() + kMany, true), 0);
  EXPECT_EQ(std::count(repeated.begin() + kMany, repeated.end(), true), kMany);
}

TEST(RepeatedInstances, HaveTheSameMeshInTheSamePlace) {
  Geometry g, mesh;
  add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  g.meshes = {std::make_shared<const Geometry>(mesh), std::make_shared<const Geometry>(mesh)};
  const auto place = [&](std::uint32_t of, Vec3 at, float scale = 1) {
    g.instances.push_back({{{scale, 0, 0}, {0, 1, 0}, {0, 0, 1}, at}, of});
  };
  place(0, {1, 0, 0});
  place(0, {2, 0, 0});
  EXPECT_TRUE(repeated_instances(g, {false}).empty());
  place(0, {1, -0.0f, 0});
  place(1, {1, 0, 0});
  place(0, {1, 0, 0}, 2);
  place(0, {2, 0, 0});
  EXPECT_THAT(repeated_instances(g, {false}), testing::ElementsAre(false, false, true, false, false, true));
  EXPECT_TRUE(repeated_instances(g, {true}).empty());
}

TEST(RepeatedTriangles, DoNotEmit) {
  SceneDescription d = floor_description();
  const std::uint32_t emission = add_emission(d, RGB(5.0f));
  add_panel(d, 2, emission);
  const Scene once(d);
  for (int i = 0; i < 3; ++i) add_panel(d, 2, emission);
  const Scene scene(d);
  EXPECT_EQ(scene.emissive_triangles(), once.emissive_triangles());
  EXPECT_EQ(scene.light_power().total(), once.light_power().total());
  EXPECT_THAT(scene.notes(), testing::Contains(testing::HasSubstr("6 triangles repeat others")));
}

}  // namespace
}  // namespace glowworm
