#include "bake/texels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "bake/fill.h"
#include "bake_testing.h"
#include "builtin/builtin.h"
#include "core/error.h"
#include "core/random.h"

namespace glowworm {
namespace {

bool overlap(const ChartPlace& a, const ChartPlace& b) {
  return a.atlas == b.atlas && a.x0 < b.x0 + b.width && b.x0 < a.x0 + a.width && a.y0 < b.y0 + b.height &&
         b.y0 < a.y0 + a.height;
}

/// The largest difference between the two sides of a seam, over all places; black where there are none.
RGB largest_step(const Seams& seams, std::span<const RGB> texels) {
  RGB most;
  for (const Seams::Place& place : seams.places) {
    RGB step;
    for (int i = 0; i < 8; ++i) step += texels[place.texel[i]] * place.weight[i];
    for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], std::abs(step[c]));
  }
  return most;
}

TEST(BakeAtlas, KeepsChartsApartAndInside) {
  for (const AtlasRequest request : {AtlasRequest{256, 0}, AtlasRequest{128, 60}, AtlasRequest{0, 0}}) {
    const FlatMesh flat(sphere_mesh(), request);
    for (std::size_t i = 0; i < flat.charts.size(); ++i) {
      const ChartPlace& p = flat.atlas.places[i];
      EXPECT_GE(std::min(p.x0, p.y0), 0);
      EXPECT_LE(std::max(p.x0 + p.width, p.y0 + p.height), flat.atlas.side);
      EXPECT_LT(p.atlas, flat.atlas.count);
      for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(overlap(p, flat.atlas.places[j]));
    }
  }
}

TEST(BakeAtlas, KeepsTheDensityThatIsAskedFor) {
  const FlatMesh flat(box_mesh(), {128, 40});
  EXPECT_EQ(flat.atlas.side, 128);
  EXPECT_GT(flat.atlas.count, 1);
  EXPECT_EQ(flat.atlas.shrunk, 0u);
  for (const ChartPlace& place : flat.atlas.places) EXPECT_NEAR(place.scale.x, 40, 1e-3);
  // 3 m at 60 a metre do not fit into 128.
  EXPECT_EQ(FlatMesh(box_mesh(), {128, 60}).atlas.shrunk, 4u);
}

TEST(BakeAtlas, FillsOneAtlasByItself) {
  const FlatMesh flat(box_mesh());
  EXPECT_EQ(flat.atlas.count, 1);
  EXPECT_GT(flat.texels.covered(), 256u * 256u / 2);
}

TEST(BakeAtlas, RefusesWhatNeverFits) {
  const std::vector<Chart> charts(2000, Chart{{0}, {{{{0, 0}, {1, 0}, {0, 1}}}}, {1, 1}});
  EXPECT_THROW(pack(charts, {16, 1e6}), Error);
}

/// Texels that bilinear filtering reads at a point, with their weights.
template <typename Visit>
void for_each_read(Vec2 p, const Visit& visit) {
  const float x = std::floor(p.x - 0.5f), y = std::floor(p.y - 0.5f);
  for (int i = 0; i < 4; ++i) {
    const float column = x + static_cast<float>(i % 2), row = y + static_cast<float>(i / 2);
    const float weight = (1 - std::abs(p.x - 0.5f - column)) * (1 - std::abs(p.y - 0.5f - row));
    visit(static_cast<int>(column), static_cast<int>(row), weight);
  }
}

TEST(BakeTexels, CoverAllThatFilteringReads) {
  for (const Geometry& mesh : {sphere_mesh(), ramp_mesh(), builtin_scene("cornell").geometry}) {
    const FlatMesh flat(mesh, {128, 0});
    std::uint32_t n = 0;
    for (std::size_t c = 0; c < flat.charts.size(); ++c)
      for (std::size_t f = 0; f < flat.charts[c].faces.size(); ++f)
        for (int i = 0; i < 50; ++i) {
          float u = to_unit_float(hash_combine(1, ++n)), v = to_unit_float(hash_combine(2, n));
          if (u + v > 1) u = 1 - u, v = 1 - v;
          const auto& corners = flat.charts[c].corners[f];
          const ChartPlace& place = flat.atlas.places[c];
          const Vec2 p = place.texel(corners[0] * (1 - u - v) + corners[1] * u + corners[2] * v);
          for_each_read(p, [&](int x, int y, float weight) {
            if (weight < 0.01f) return;
            const std::size_t at = flat.texels.index(x, y + place.atlas * flat.atlas.side);
            ASSERT_NE(flat.texels.face[at], kNone);
            ASSERT_EQ(flat.texels.chart[at], c);
          });
        }
  }
}

TEST(BakeTexels, LieAtTheirPlacesInSpace) {
  const FlatMesh flat(sphere_mesh(), {128, 0});
  std::vector<std::size_t> chart_of(flat.faces.size());
  for (std::size_t c = 0; c < flat.charts.size(); ++c)
    for (const std::uint32_t f : flat.charts[c].faces) chart_of[f] = c;
  std::size_t exact = 0;
  for (std::size_t i = 0; i < flat.texels.face.size(); ++i) {
    const std::uint32_t face = flat.texels.face[i];
    if (face == kNone) continue;
    const std::size_t c = chart_of[face];
    ASSERT_EQ(flat.texels.chart[i], c);
    const auto& members = flat.charts[c].faces;
    const auto f = static_cast<std::size_t>(std::find(members.begin(), members.end(), face) - members.begin());
    const auto& corners = flat.charts[c].corners[f];
    const Vec2 w = flat.texels.barycentric[i];
    const Vec2 p = flat.atlas.places[c].texel(corners[0] * (1 - w.x - w.y) + corners[1] * w.x + corners[2] * w.y);
    const float dx = p.x - (static_cast<float>(i % 128) + 0.5f), dy = p.y - (static_cast<float>(i / 128) + 0.5f);
    // A texel that a chart touches, and the way that its point lies inside.
    ASSERT_LT(std::max(std::abs(dx), std::abs(dy)), 1.5f);
    exact += std::hypot(dx, dy) < 0.051f;
  }
  // All but those that only touch the rim of a chart.
  EXPECT_GT(exact, flat.texels.covered() * 7 / 10);
}

TEST(BakeTexels, KeepAwayFromCorners) {
  const FlatMesh flat(box_mesh(), {128, 0});
  for (std::size_t i = 0; i < flat.texels.face.size(); ++i) {
    if (flat.texels.face[i] == kNone) continue;
    const Vec3 p = flat.point(i);
    const float to_side[3] = {std::min(p.x, 3 - p.x), std::min(p.y, 2 - p.y), std::min(p.z, 1 - p.z)};
    // On one side of the box, and on no other.
    EXPECT_EQ(std::count_if(to_side, to_side + 3, [](float d) { return d < 1e-5f; }), 1);
  }
}

TEST(BakeFill, SpreadsWithinChartsAndThenBetween) {
  const FlatMesh flat(box_mesh(), {128, 0});
  std::vector<RGB> texels(flat.texels.face.size());
  std::vector<std::uint8_t> known(texels.size(), 0);
  // One texel in five, with the colour of its chart.
  std::size_t n = 0;
  for (std::size_t i = 0; i < texels.size(); ++i)
    if (flat.texels.face[i] != kNone && ++n % 5 == 0) {
      known[i] = 1;
      texels[i] = RGB(1.0f + static_cast<float>(flat.texels.chart[i]));
    }
  fill_gaps(flat.texels, known, texels);
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (flat.texels.chart[i] != kNone) {
      EXPECT_FLOAT_EQ(texels[i].g, 1.0f + static_cast<float>(flat.texels.chart[i]));
    }
    EXPECT_GE(texels[i].r, 0.999f);
  }
}

TEST(BakeFill, LeavesAnAtlasWithoutLightBlack) {
  const FlatMesh flat(box_mesh(), {64, 0});
  std::vector<RGB> texels(flat.texels.face.size());
  fill_gaps(flat.texels, std::vector<std::uint8_t>(texels.size(), 0), texels);
  for (const RGB& t : texels) EXPECT_TRUE(is_black(t));
}

TEST(BakeSeams, CloseWithoutChangingTheRest) {
  const FlatMesh flat(sphere_mesh(48, 24), {256, 0});
  ASSERT_GT(flat.charts.size(), 4u);
  const Seams seams = find_seams(flat.geometry, flat.faces, flat.charts, flat.atlas);
  ASSERT_FALSE(seams.places.empty());
  std::vector<RGB> texels(flat.texels.face.size());
  std::vector<std::uint8_t> known(texels.size(), 0);
  for (std::size_t i = 0; i < texels.size(); ++i)
    if (flat.texels.face[i] != kNone) {
      known[i] = 1;
      // A smooth light on the sphere, with an error that differs from chart to chart.
      texels[i] = RGB(0.5f + 0.3f * flat.point(i).y + 0.02f * static_cast<float>(flat.texels.chart[i] % 3));
    }
  fill_gaps(flat.texels, known, texels);
  const std::vector<RGB> before = texels;
  EXPECT_GT(largest_step(seams, texels).r, 0.035f);
  close_seams(seams, texels);
  EXPECT_LT(largest_step(seams, texels).r, 1 / 255.0f);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    changed += !(texels[i] == before[i]);
    EXPECT_NEAR(texels[i].r, before[i].r, 0.06f);
  }
  EXPECT_LT(changed, texels.size() / 4);
}

TEST(BakeSeams, CloseBesideTexelsThatCannotBecomeDarker) {
  // A bright and a dark texel on one side, a black one on the other: the least changes would make the dark one
  // negative.
  const Seams seams{{{{0, 1, 1, 1, 2, 2, 2, 2}, {0.5f, 0.5f, 0, 0, -1, 0, 0, 0}}}};
  std::vector<RGB> texels{RGB(1.0f), RGB(0.1f), RGB(0.0f)};
  close_seams(seams, texels);
  EXPECT_LT(largest_step(seams, texels).r, 0.005f);
  EXPECT_EQ(texels[1], RGB());
  EXPECT_GT(texels[0].r, 0.7f);
}

TEST(BakeSeams, CloseEachGroupAsIfItWereAlone) {
  const Seams::Place dark{{0, 1, 1, 1, 2, 2, 2, 2}, {0.5f, 0.5f, 0, 0, -1, 0, 0, 0}};
  const Seams::Place light{{4, 5, 6, 6, 7, 7, 7, 8}, {0.25f, 0.5f, 0.25f, 0, -0.3f, 0, -0.3f, -0.4f}};
  const Seams::Place linked{{8, 3, 3, 3, 9, 9, 9, 9}, {1, 0, 0, 0, -1, 0, 0, 0}};
  const std::vector<RGB> before{RGB(0.9f), RGB(0), RGB(0),    RGB(0.2f), RGB(0.5f),
                                RGB(0.7f), RGB(1), RGB(0.3f), RGB(0.4f), RGB(0.1f)};
  std::vector<RGB> alone = before, together = before;
  close_seams({{dark}}, alone);
  close_seams({{light, linked}}, alone);
  close_seams({{light, dark, linked}}, together);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(together[i], alone[i]) << i;
  EXPECT_LT(largest_step({{light, dark, linked}}, together).r, 0.02f);
}

TEST(BakeSeams, LeaveCreasesAlone) {
  const FlatMesh flat(box_mesh(), {64, 0});
  EXPECT_TRUE(find_seams(flat.geometry, flat.faces, flat.charts, flat.atlas).places.empty());
}

}  // namespace
}  // namespace glowworm
