// Built-in scenes: closed surfaces have no gaps, and light reaches the intended places.
#include <gtest/gtest.h>

#include <optional>

#include "builtin/builtin.h"
#include "core/random.h"
#include "core/warp.h"
#include "mesh_checks.h"

namespace glowworm {
namespace {

struct BruteHit {
  double distance;
  std::uint32_t triangle;
};

// The closest hit, over all triangles, in double precision (Moeller and Trumbore, 1997).
std::optional<BruteHit> brute_force(const Geometry& g, Vec3 origin, Vec3 direction) {
  struct D {
    double x, y, z;
  };
  const auto sub = [](Vec3 a, Vec3 b) { return D{double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z}; };
  const auto cr = [](D a, D b) { return D{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; };
  const auto dt = [](D a, D b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  std::optional<BruteHit> best;
  const D d{direction.x, direction.y, direction.z};
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const auto& [a, b, c] = g.triangles[t];
    const D e1 = sub(g.positions[b], g.positions[a]), e2 = sub(g.positions[c], g.positions[a]);
    const D p = cr(d, e2);
    const double det = dt(e1, p);
    if (det == 0) continue;
    const D s = sub(origin, g.positions[a]);
    const double u = dt(s, p) / det;
    const D q = cr(s, e1);
    const double v = dt(d, q) / det, distance = dt(e2, q) / det;
    if (u < 0 || v < 0 || u + v > 1 || distance <= 1e-6) continue;
    if (!best || distance < best->distance) best = BruteHit{distance, t};
  }
  return best;
}

Vec3 random_direction(std::uint32_t i) {
  return square_to_sphere({to_unit_float(hash32(2 * i)), to_unit_float(hash32(2 * i + 1))});
}

// How many of `count` rays from a point leave the scene, and how many meet the back of a surface first.
struct Escapes {
  int gone = 0, back = 0;
};
Escapes shoot(const Geometry& g, Vec3 from, int count) {
  Escapes out;
  for (int i = 0; i < count; ++i) {
    const Vec3 d = random_direction(static_cast<std::uint32_t>(i));
    const auto hit = brute_force(g, from, d);
    if (!hit)
      ++out.gone;
    else if (dot(g.normal(hit->triangle), d) > 0)
      ++out.back;
  }
  return out;
}

Geometry only(const SceneDescription& scene, std::initializer_list<const char*> names) {
  Geometry out = scene.geometry;
  out.triangles.clear();
  for (std::uint32_t t = 0; t < scene.geometry.triangle_count(); ++t)
    for (const char* name : names)
      if (scene.materials[scene.geometry.material[t]].name == name)
        out.triangles.push_back(scene.geometry.triangles[t]);
  return out;
}

TEST(FurnaceSphere, IsAClosedFlatShadedSphereThatEmitsEverywhere) {
  const SceneDescription scene = builtin_scene("furnace-sphere");
  const Geometry& g = scene.geometry;
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_LT(signed_volume(g), 0);
  EXPECT_NEAR(signed_volume(g), -4.0 / 3 * kPi * 0.125, 0.01 * 4.0 / 3 * kPi * 0.125);
  for (const Vec3& n : g.normals) EXPECT_EQ(n, (Vec3{0, 0, 0}));
  for (std::size_t t = 0; t < g.triangle_count(); ++t) {
    EXPECT_NE(g.emission[t], kNone);
    EXPECT_EQ(scene.materials[g.material[t]].reflectance.value, RGB(0.5f));
  }
  const Escapes escapes = shoot(g, {0.1f, -0.2f, 0.05f}, 500);
  EXPECT_EQ(escapes.gone + escapes.back, 0);
}

TEST(SlowAjar, BothRoomsAndTheDoorwayAreOneClosedShell) {
  const SceneDescription scene = builtin_scene("ajar");
  // The doorway's faces share the door's paint with the leaf and the trim, so the rays below ask the whole scene.
  for (const Vec3 from :
       {Vec3{-1, 2.2f, 1.5f}, Vec3{0.9f, 1, -1.2f}, Vec3{2.5f, 1.5f, -3.3f}, Vec3{1.0f, 1.9f, -2.3f}}) {
    const Escapes escapes = shoot(scene.geometry, from, 150);
    EXPECT_EQ(escapes.gone, 0);
    EXPECT_EQ(escapes.back, 0);
  }
}

TEST(SlowAjar, TheLampLightsLittleOfTheRoomDirectly) {
  const SceneDescription scene = builtin_scene("ajar");
  const Vec3 lamp{0, 2.65f, -3.5f};
  int lit = 0;
  const int count = 400;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t k = static_cast<std::uint32_t>(i);
    const Vec3 point{-2.55f + 5.1f * to_unit_float(hash32(3 * k)), 0.05f + 2.6f * to_unit_float(hash32(3 * k + 1)),
                     -2.1f + 4.2f * to_unit_float(hash32(3 * k + 2))};
    const auto hit = brute_force(scene.geometry, point, lamp - point);
    if (!hit || hit->distance > 0.999) ++lit;
  }
  EXPECT_LT(lit, count / 20);
}

TEST(SlowAjar, ACameraPathThroughTheGapExists) {
  // From the corridor, just behind the gap, the room's far wall is seen: the door is open.
  const SceneDescription scene = builtin_scene("ajar");
  const Vec3 from{1.15f, 1.2f, -2.9f};
  int through = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 d = random_direction(static_cast<std::uint32_t>(i));
    const auto hit = brute_force(scene.geometry, from, d);
    ASSERT_TRUE(hit);
    if (from.z + hit->distance * d.z > -1.0) ++through;
  }
  EXPECT_GT(through, 0);
}

TEST(WindowRoom, WallsWithTheWindowAreAClosedSolid) {
  const SceneDescription scene = builtin_scene("window-room");
  const Geometry shell = only(scene, {"wall", "floor"});
  EXPECT_EQ(unmatched_edges(shell), 0u);
  EXPECT_NEAR(signed_volume(shell), 5.6 * 3.6 * 4.6 - 5 * 3 * 4 - 0.3 * 0.94, 1e-3);
}

TEST(WindowRoom, TheWindowIsAHundredthOfTheRoomsSurface) {
  const SceneDescription scene = builtin_scene("window-room");
  Box3 inner;
  for (std::uint32_t t = 0; t < scene.geometry.triangle_count(); ++t)
    if (scene.materials[scene.geometry.material[t]].name == "floor")
      for (const std::uint32_t v : scene.geometry.triangles[t]) inner.grow(scene.geometry.positions[v]);
  const double width = inner.max.x - inner.min.x, depth = inner.max.z - inner.min.z, height = 3;
  const double surface = 2 * (width * depth + width * height + depth * height);
  // Wall faces in the plane of the window: what is missing of that wall is the window.
  double wall = 0;
  for (std::uint32_t t = 0; t < scene.geometry.triangle_count(); ++t) {
    const auto& [a, b, c] = scene.geometry.triangles[t];
    if (scene.geometry.positions[a].x == 2.5f && scene.geometry.positions[b].x == 2.5f &&
        scene.geometry.positions[c].x == 2.5f)
      wall += scene.geometry.area(t);
  }
  EXPECT_NEAR((depth * height - wall) / surface, 0.01, 1e-5);
}

TEST(WindowRoom, TheSunComesIn) {
  const SceneDescription scene = builtin_scene("window-room");
  const Vec3 middle{2.5f, 1.67f, 0};
  EXPECT_FALSE(brute_force(scene.geometry, middle, -scene.lights[0].direction));
  const auto hit = brute_force(scene.geometry, middle, scene.lights[0].direction);
  ASSERT_TRUE(hit);
  EXPECT_EQ(scene.materials[scene.geometry.material[hit->triangle]].name, "floor");
}

TEST(GlassSphere, BallIsClosedAndLooksOutwardsAndTheLampShinesOnIt) {
  const SceneDescription scene = builtin_scene("glass-sphere");
  const Geometry ball = only(scene, {"glass"});
  EXPECT_EQ(unmatched_edges(ball), 0u);
  EXPECT_NEAR(signed_volume(ball), 4.0 / 3 * kPi * 0.027, 0.003 * 4.0 / 3 * kPi * 0.027);
  const Geometry lamp = only(scene, {"lamp"});
  const Vec3 to_ball = Vec3{0, 0.45f, 0} - lamp.positions[lamp.triangles[0][0]];
  for (std::uint32_t t = 0; t < lamp.triangle_count(); ++t) EXPECT_GT(dot(lamp.normal(t), to_ball), 0);
}

TEST(Ring, IsClosedAndLooksOutwards) {
  const Geometry ring = only(builtin_scene("ring"), {"gold"});
  EXPECT_EQ(unmatched_edges(ring), 0u);
  const double expected = kPi * (0.52 * 0.52 - 0.5 * 0.5) * 0.219;
  EXPECT_NEAR(signed_volume(ring), expected, 0.003 * expected);
}

TEST(SlowAtrium, GalleriesAreRoofedAndWalledAndShowNoBacks) {
  const Geometry g = builtin_scene("atrium").geometry;
  // In the corners of both galleries no ray may meet the back of a face, and none may leave upwards but to the court.
  for (const Vec3 from :
       {Vec3{-13.3f, 1.5f, -5.8f}, Vec3{13.1f, 6.5f, 5.6f}, Vec3{4.1f, 1.4f, 5.9f}, Vec3{-8, 7, -5.5f}}) {
    const Escapes escapes = shoot(g, from, 100);
    EXPECT_EQ(escapes.back, 0);
    EXPECT_LT(escapes.gone, 15);
  }
  // Straight up and away from the court all is closed.
  for (int i = 0; i < 60; ++i) {
    const float x = -14.5f + 0.48f * static_cast<float>(i);
    for (const float y : {1.0f, 6.3f}) EXPECT_TRUE(brute_force(g, {x, y, 5.83f}, {0.01f, 1, 0.3f}));
  }
}

TEST(SlowAtrium, SunReachesTheCourtAndOneColonnade) {
  const SceneDescription scene = builtin_scene("atrium");
  const Vec3 to_sun = -scene.lights[0].direction;
  int floor = 0, colonnade = 0, shaded = 0;
  for (int i = 0; i < 60; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / 60;
    if (!brute_force(scene.geometry, {-5 + 14 * t, -0.29f, 2.7f}, to_sun)) ++floor;
    if (!brute_force(scene.geometry, {-5 + 14 * t, 4.55f, 3.5f}, to_sun)) ++colonnade;
    if (!brute_force(scene.geometry, {-5 + 14 * t, 4.55f, -3.5f}, to_sun)) ++shaded;
  }
  EXPECT_GT(floor, 40);
  EXPECT_GT(colonnade, 40);
  EXPECT_EQ(shaded, 0);
}

}  // namespace
}  // namespace glowworm
