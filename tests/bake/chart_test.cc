#include "bake/chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "bake/overlap.h"
#include "bake_testing.h"
#include "builtin/builtin.h"

namespace glowworm {
namespace {

/// How often each face is in a chart.
std::vector<int> uses(const std::vector<Chart>& charts, std::size_t faces) {
  std::vector<int> count(faces, 0);
  for (const Chart& chart : charts)
    for (const std::uint32_t face : chart.faces) ++count[face];
  return count;
}

double flat_area(const Chart& chart) {
  double sum = 0;
  for (const auto& c : chart.corners)
    sum += 0.5 * std::abs((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x));
  return sum;
}

struct MeshCase {
  const char* name;
  Geometry geometry;
};

std::vector<MeshCase> meshes() {
  std::vector<MeshCase> out;
  out.push_back({"sphere", sphere_mesh()});
  out.push_back({"box", box_mesh()});
  out.push_back({"ramp", ramp_mesh()});
  out.push_back({"cornell", builtin_scene("cornell").geometry});
  return out;
}

TEST(BakeCharts, HoldEveryFaceOnceWithoutOverlapsOrMuchStretch) {
  for (const MeshCase& mesh : meshes()) {
    const std::vector<BakeFace> faces = fronts(mesh.geometry);
    const std::vector<Chart> charts = make_charts(mesh.geometry, faces);
    const std::vector<int> count = uses(charts, faces.size());
    EXPECT_EQ(std::count(count.begin(), count.end(), 1), static_cast<std::ptrdiff_t>(faces.size())) << mesh.name;
    for (const Chart& chart : charts) {
      EXPECT_LT(overlapping_share(chart, 128), 0.01) << mesh.name;
      double in_space = 0;
      for (const std::uint32_t face : chart.faces) in_space += mesh.geometry.area(faces[face].triangle);
      // Faces are tilted by 45 degrees at most.
      EXPECT_GT(flat_area(chart), 0.7 * in_space) << mesh.name;
      EXPECT_LT(flat_area(chart), 1.001 * in_space) << mesh.name;
      for (const auto& corners : chart.corners)
        for (const Vec2& p : corners) {
          EXPECT_GE(std::min(p.x, p.y), -1e-4f * chart.size.x) << mesh.name;
          EXPECT_LE(p.x, chart.size.x * 1.0001f) << mesh.name;
          EXPECT_LE(p.y, chart.size.y + 1e-4f * chart.size.x) << mesh.name;
        }
    }
  }
}

TEST(BakeCharts, CutABoxIntoItsSixSides) {
  const Geometry box = box_mesh();
  std::vector<Chart> charts = make_charts(box, fronts(box));
  ASSERT_EQ(charts.size(), 6u);
  std::sort(charts.begin(), charts.end(), [](const Chart& a, const Chart& b) { return flat_area(a) < flat_area(b); });
  EXPECT_NEAR(charts[0].size.x, 2, 1e-5);
  EXPECT_NEAR(charts[0].size.y, 1, 1e-5);
  EXPECT_NEAR(charts[5].size.x, 3, 1e-5);
  EXPECT_NEAR(charts[5].size.y, 2, 1e-5);
}

TEST(BakeCharts, KeepTheTwoSidesOfASheetApart) {
  Geometry sheet;
  MeshBuilder(sheet).quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  const std::vector<BakeFace> faces{{0, false}, {1, false}, {0, true}, {1, true}};
  const std::vector<Chart> charts = make_charts(sheet, faces);
  ASSERT_EQ(charts.size(), 2u);
  EXPECT_EQ(charts[0].faces, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(charts[1].faces, (std::vector<std::uint32_t>{2, 3}));
}

TEST(BakeCharts, TakeSurfacesThatAreNoManifold) {
  Geometry fan;
  // Three sheets meet at one edge, one of them twice.
  fan.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0.2f}, {-1, 0, -0.2f}};
  fan.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 1, 4}, {0, 1, 4}};
  fan.normals.resize(5);
  fan.uvs.resize(5);
  fan.material.assign(4, 0);
  fan.emission.assign(4, kNone);
  EXPECT_TRUE(shared_edges(fan, fronts(fan)).size() <= 2);
  const std::vector<int> count = uses(make_charts(fan, fronts(fan)), 4);
  EXPECT_EQ(count, (std::vector<int>{1, 1, 1, 1}));
}

TEST(BakeCharts, TakeTrianglesWithoutArea) {
  Geometry geometry = box_mesh();
  const auto at = static_cast<std::uint32_t>(geometry.positions.size());
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{2, 0, 0}}) geometry.positions.push_back(p);
  geometry.normals.resize(at + 3);
  geometry.uvs.resize(at + 3);
  geometry.triangles.push_back({at, at + 1, at + 2});
  geometry.triangles.push_back({at, at, at});
  geometry.material.resize(geometry.triangles.size(), 0);
  geometry.emission.resize(geometry.triangles.size(), kNone);
  const FlatMesh flat(geometry);
  EXPECT_EQ(uses(flat.charts, flat.faces.size()), std::vector<int>(flat.faces.size(), 1));
  for (std::size_t i = 0; i < flat.texels.face.size(); ++i)
    if (flat.texels.face[i] != kNone) {
      EXPECT_TRUE(is_finite(flat.point(i)));
    }
}

/// Two quads in one object with these second texture coordinates.
OwnCharts with_uvs(std::array<Vec2, 8> uvs, bool both_sides = false) {
  Geometry g;
  MeshBuilder builder(g);
  builder.quad({0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0});
  builder.quad({0, 0, 1}, {2, 0, 1}, {2, 1, 1}, {0, 1, 1});
  g.objects = {{0, "quads"}};
  g.second_uvs.assign(uvs.begin(), uvs.end());
  std::vector<BakeFace> faces = fronts(g);
  if (both_sides) faces.push_back({0, true});
  return own_charts(g, faces);
}

constexpr std::array<Vec2, 8> kGoodUvs{
    {{0.1f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.45f}, {0.1f, 0.45f}, {0.1f, 0.5f}, {0.9f, 0.5f}, {0.9f, 0.9f}, {0.1f, 0.9f}}};

TEST(BakeOwnCharts, UseCoordinatesThatAreGood) {
  const OwnCharts own = with_uvs(kGoodUvs);
  ASSERT_EQ(own.charts.size(), 1u);
  EXPECT_TRUE(own.rest.empty());
  EXPECT_EQ(own.charts[0].faces.size(), 4u);
  // 4 m^2 of surface; the rectangle has 0.8 * 0.8 of the texture, and the quads 0.8 * 0.75 of it.
  EXPECT_NEAR(own.charts[0].size.x, 0.8 * std::sqrt(4 / 0.6), 1e-4);
}

TEST(BakeOwnCharts, SayWhyCoordinatesAreOfNoUse) {
  auto uvs = kGoodUvs;
  uvs[2].x = 1.2f;
  EXPECT_NE(with_uvs(uvs).reasons.at(0).find("'quads'"), std::string::npos);
  EXPECT_NE(with_uvs(uvs).reasons.at(0).find("outside of [0, 1]"), std::string::npos);
  uvs = kGoodUvs;
  uvs[4] = uvs[0];
  uvs[5] = uvs[1];
  EXPECT_NE(with_uvs(uvs).reasons.at(0).find("overlap"), std::string::npos);
  uvs = kGoodUvs;
  uvs[5] = uvs[6] = uvs[4];
  EXPECT_NE(with_uvs(uvs).reasons.at(0).find("no area"), std::string::npos);
  EXPECT_EQ(with_uvs(uvs).rest.size(), 4u);
  uvs.fill({0.5f, 0.5f});
  EXPECT_NE(with_uvs(uvs).reasons.at(0).find("no area"), std::string::npos);
  EXPECT_NE(with_uvs(kGoodUvs, true).reasons.at(0).find("both sides"), std::string::npos);
  // An object without coordinates needs no excuse.
  EXPECT_TRUE(with_uvs({}).reasons.empty());
  EXPECT_TRUE(with_uvs({}, true).reasons.empty());
  EXPECT_EQ(with_uvs({}).rest.size(), 4u);
}

}  // namespace
}  // namespace glowworm
