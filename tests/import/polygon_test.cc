#include "import/polygon.h"

#include <gtest/gtest.h>

#include <cmath>

namespace glowworm {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Vec3 doubled_area(const std::vector<Vec3>& corners, const std::array<std::uint32_t, 3>& t) {
  return cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]);
}

/// The sum of the areas of the triangles; -1 where one is wound against the z axis.
double area_of(const std::vector<Vec3>& corners, const Triangles& triangles) {
  double sum = 0;
  for (const auto& t : triangles) {
    const Vec3 area = doubled_area(corners, t);
    if (area.z < -1e-6f) return -1;
    sum += 0.5 * area.z;
  }
  return sum;
}

TEST(Polygon, ConvexOnesBecomeFans) {
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  Triangles triangles;
  EXPECT_TRUE(cut_polygon(square, triangles));
  EXPECT_EQ(triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Polygon, ConcaveOnesAreCoveredOnce) {
  const std::vector<Vec3> dart = {{0, 0, 0}, {2, 0, 0}, {0.5f, 0.5f, 0}, {0, 2, 0}};
  Triangles triangles;
  EXPECT_TRUE(cut_polygon(dart, triangles));
  EXPECT_NEAR(area_of(dart, triangles), 1.0, 1e-6);
  // A U, with a corner amid a straight edge.
  const std::vector<Vec3> u = {{0, 0, 0}, {1.5f, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0},
                               {2, 1, 0}, {1, 1, 0},    {1, 3, 0}, {0, 3, 0}};
  triangles.clear();
  EXPECT_TRUE(cut_polygon(u, triangles));
  EXPECT_EQ(triangles.size(), u.size() - 2);
  EXPECT_NEAR(area_of(u, triangles), 7.0, 1e-6);
  // A square with a square hole, to which a bridge leads twice.
  const std::vector<Vec3> ring = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                  {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  triangles.clear();
  EXPECT_TRUE(cut_polygon(ring, triangles));
  EXPECT_NEAR(area_of(ring, triangles), 12.0, 1e-6);
}

/// A star of so many points, every other corner of which bends inwards.
std::vector<Vec3> star(int corners) {
  std::vector<Vec3> out;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * M_PI * i / corners, radius = i % 2 ? 0.5 : 1.0;
    out.push_back({static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)), 0});
  }
  return out;
}

TEST(Polygon, StarsAreCoveredOnce) {
  const std::vector<Vec3> corners = star(200);
  Triangles triangles;
  EXPECT_TRUE(cut_polygon(corners, triangles));
  EXPECT_NEAR(area_of(corners, triangles), 100 * 0.5 * std::sin(2 * M_PI / 200), 1e-4);
}

TEST(Polygon, SelfIntersectingOnesHaveTheSameNumberOfTriangles) {
  std::vector<Vec3> tangled = star(50'000);  // takes seconds where work is not bounded
  for (std::size_t i = 0; i < tangled.size(); i += 3) tangled[i] = tangled[i] * -1;
  Triangles triangles;
  EXPECT_FALSE(cut_polygon(tangled, triangles));
  EXPECT_EQ(triangles.size(), tangled.size() - 2);
  for (const Vec3 place : {Vec3{1, 2, 3}, Vec3{NAN, 0, 0}}) {
    const std::vector<Vec3> same(1000, place);
    triangles.clear();
    cut_polygon(same, triangles);
    EXPECT_EQ(triangles.size(), same.size() - 2);
  }
}

}  // namespace
}  // namespace glowworm
