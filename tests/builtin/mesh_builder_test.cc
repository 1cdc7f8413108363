#include "builtin/mesh_builder.h"

#include <gtest/gtest.h>

#include "mesh_checks.h"

namespace glowworm {
namespace {

TEST(MeshBuilder, BoxIsClosedAndLooksOutwards) {
  Geometry g;
  MeshBuilder(g).box({-1, 0, 2}, {1, 3, 7});
  EXPECT_EQ(g.triangle_count(), 12u);
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_NEAR(signed_volume(g), 2.0 * 3 * 5, 1e-4);
}

TEST(MeshBuilder, RoomLooksInwards) {
  Geometry g;
  MeshBuilder(g).room({-1, 0, 2}, {1, 3, 7});
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_NEAR(signed_volume(g), -2.0 * 3 * 5, 1e-4);
}

TEST(MeshBuilder, SphereIsClosedOnBothSides) {
  for (const bool inside : {false, true}) {
    Geometry g;
    MeshBuilder(g).sphere({1, 2, 3}, 0.5f, 96, 48, inside);
    EXPECT_EQ(g.triangle_count(), 2u * 96 * 47);
    EXPECT_EQ(unmatched_edges(g), 0u);
    EXPECT_EQ(wrong_normals(g), 0u);
    // An inscribed polyhedron's volume falls short by the order of (pi / rings)^2 / 2.
    const double sphere = 4.0 / 3 * 3.14159265358979 * 0.125;
    EXPECT_NEAR(signed_volume(g), inside ? -sphere : sphere, sphere * 0.004);
  }
}

TEST(MeshBuilder, LatheOfAClosedOutlineIsClosedAndLooksOutwards) {
  Geometry g;
  const MeshBuilder::ProfilePoint cylinder[] = {{0, 1}, {2, 1, true}, {2, 4, true}, {0, 4}};
  MeshBuilder(g).lathe(cylinder, 64);
  EXPECT_EQ(unmatched_edges(g), 0u);
  EXPECT_EQ(wrong_normals(g), 0u);
  const double prism = 64 * 0.5 * 4 * std::sin(2 * 3.14159265358979 / 64) * 3;  // area of the 64-gon times height
  EXPECT_NEAR(signed_volume(g), prism, 1e-3);
}

TEST(MeshBuilder, PatchHasItsFrontWhereTheCrossProductPoints) {
  Geometry g;
  MeshBuilder(g).patch([](float u, float v) { return Vec3{u, 0.1f * u * u, -v}; }, 4, 3);
  EXPECT_EQ(g.triangle_count(), 24u);
  EXPECT_EQ(wrong_normals(g), 0u);
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) EXPECT_GT(g.normal(t).y, 0.9f);
}

TEST(MeshBuilder, PlacingTurnsAndMovesWithoutMirroring) {
  Geometry g;
  MeshBuilder builder(g);
  builder.set_transform(place({10, 0, 0}, kPi / 2));
  builder.box({0, 0, 0}, {1, 2, 3});
  EXPECT_NEAR(signed_volume(g), 6.0, 1e-3);
  // +z turns towards +x.
  EXPECT_NEAR(g.bounds().max.x, 13, 1e-5);
  EXPECT_NEAR(g.bounds().min.z, -1, 1e-5);
}

TEST(MeshBuilder, InstanceCopiesEveryTriangleUnderTheTransform) {
  Geometry part, g;
  MeshBuilder(part).sphere({0, 0, 0}, 1, 16, 8);
  MeshBuilder builder(g);
  builder.set_material(7);
  builder.set_transform(place({5, 0, 0}, 1.0f));
  builder.instance(part);
  EXPECT_EQ(g.triangle_count(), part.triangle_count());
  EXPECT_NEAR(signed_volume(g), signed_volume(part), 1e-4);
  EXPECT_EQ(wrong_normals(g), 0u);
  for (const std::uint32_t m : g.material) EXPECT_EQ(m, 7u);
}

}  // namespace
}  // namespace glowworm
