// The surfaces that a bake lays out, and what it says of the others.
#include "bake/layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bake_testing.h"
#include "builtin/builtin.h"
#include "core/error.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

TEST(BakeLayout, BakesTheSidesThatLightCanReach) {
  // The outside of a closed room and the inside of a solid get no texels.
  const Stage rooms(two_rooms());
  const BakeLayout layout = lay_out(rooms.scene, rooms.tracer, {64, 0});
  for (const BakeFace& face : layout.faces) EXPECT_FALSE(face.back);
  // Nor does the inside of a box without a bottom.
  const Stage cornell(builtin_scene("cornell"));
  for (const BakeFace& face : lay_out(cornell.scene, cornell.tracer, {64, 0}).faces) EXPECT_FALSE(face.back);
  // A sheet in the middle of a room has two sides.
  SceneDescription d = two_rooms();
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0});
  const std::size_t triangles = d.geometry.triangle_count();
  const Stage sheet(std::move(d));
  std::size_t backs = 0;
  for (const BakeFace& face : lay_out(sheet.scene, sheet.tracer, {64, 0}).faces) {
    backs += face.back;
    EXPECT_TRUE(!face.back || face.triangle >= triangles - 2);
  }
  EXPECT_EQ(backs, 2u);
}

/// The sides of a mesh that are baked: bit 0 the fronts, bit 1 the backs. The scene's lamp lies below.
int baked_sides(SceneDescription d, bool as_point) {
  if (as_point)
    d.lights.emplace_back().position = {0, -3, 0};
  else
    add_quad(d, {-0.01f, -3, -0.01f}, {0, 0, 0.02f}, {0.02f, 0, 0}, 0, add_emission(d, RGB(5e4f)));
  const Stage stage(std::move(d));
  int sides = 0;
  for (const BakeFace& face : lay_out(stage.scene, stage.tracer, {64, 0}).faces) sides |= face.back ? 2 : 1;
  return sides;
}

TEST(BakeLayout, BakesTheSideOfALoneSurfaceThatASmallLampLights) {
  for (const bool as_point : {true, false}) {
    SceneDescription sheet;
    sheet.materials.resize(1);
    SceneDescription box = sheet, turned = sheet;
    add_quad(sheet, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0});
    add_quad(turned, {-1, 0, -1}, {2, 0, 0}, {0, 0, 2});
    MeshBuilder(box.geometry).box({-1, -1, -1}, {1, 1, 1});
    EXPECT_EQ(baked_sides(sheet, as_point), 2) << "its front is up, and dark";
    EXPECT_EQ(baked_sides(turned, as_point), 1);
    EXPECT_EQ(baked_sides(box, as_point), 1) << "not the inside";
  }
}

TEST(BakeLayout, KeepsTheFrontsOfWhatGlowsInTheDark) {
  SceneDescription d;
  d.materials.resize(1);
  const std::uint32_t glow = add_emission(d, RGB(0.1f));
  d.emissions[glow].radiance.texture = 0;
  d.textures.emplace_back();
  add_quad(d, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, 0, glow);
  EXPECT_EQ(baked_sides(std::move(d), true), 3) << "the light is behind";
}

TEST(BakeLayout, KeepsTheFloorBelowARoofOfOneSheet) {
  for (const bool single_sided : {true, false}) {
    SceneDescription d;
    d.materials.resize(2);
    d.materials[1].single_sided = single_sided;
    d.environment.emplace();
    add_quad(d, {-15, 0, -15}, {0, 0, 30}, {30, 0, 0});
    add_quad(d, {-3, 2.5f, -3}, {0, 0, 6}, {6, 0, 0}, 1);
    const Stage stage(std::move(d));
    const BakeLayout layout = lay_out(stage.scene, stage.tracer, {128, 0});
    const PointGrid grid = texel_points(*stage.scene, *stage.tracer, layout);
    std::size_t texels = 0, points = 0;
    for (std::size_t i = 0; i < layout.texels.face.size(); ++i) {
      const std::uint32_t f = layout.texels.face[i];
      if (f == kNone || layout.faces[f].back || layout.faces[f].triangle > 1) continue;
      ++texels;
      points += grid.has(i);
    }
    EXPECT_GT(texels, 1000u);
    EXPECT_EQ(points, texels);
  }
}

TEST(BakeLayout, LeavesOutThePlacesBelowABoxWithoutABottom) {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].single_sided = true;
  d.environment.emplace();
  add_quad(d, {-4, 0, -4}, {0, 0, 8}, {8, 0, 0});
  Geometry box;
  MeshBuilder(box).box({-2, 0, -2}, {2, 2, 2});
  for (const auto& corners : box.triangles) {
    const Vec3 center = (box.positions[corners[0]] + box.positions[corners[1]] + box.positions[corners[2]]) / 3;
    if (center.y < 0.01f) continue;
    Geometry side;
    for (const std::uint32_t v : corners) side.positions.push_back(box.positions[v]);
    side.uvs.resize(3);
    side.triangles = {{0, 1, 2}};
    append_mesh(d.geometry, side, "box", 0, kNone);
  }
  const Stage stage(std::move(d));
  const BakeLayout layout = lay_out(stage.scene, stage.tracer, {128, 0});
  const PointGrid grid = texel_points(*stage.scene, *stage.tracer, layout);
  std::size_t within = 0;
  for (std::size_t i = 0; i < layout.texels.face.size(); ++i) {
    const std::uint32_t f = layout.texels.face[i];
    if (f == kNone || layout.faces[f].triangle > 1) continue;
    const Vec3 p = surface_point(*stage.scene, layout.faces[f].triangle, layout.texels.barycentric[i]).position;
    if (std::max(std::abs(p.x), std::abs(p.z)) > 1.9f) continue;
    ++within;
    EXPECT_FALSE(grid.has(i)) << p.x << " " << p.z;
  }
  EXPECT_GT(within, 100u);
}

TEST(BakeLayout, LeavesGlassMirrorsAndLampsAlone) {
  SceneDescription d = two_rooms();
  d.materials.resize(3);
  d.materials[1].name = "pane";
  d.materials[1].kind = MaterialKind::dielectric;
  d.materials[2].name = "mirror";
  d.materials[2].kind = MaterialKind::conductor;
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0}, 1);
  add_quad(d, {1, 0.5f, 0.5f}, {0, 1, 0}, {0.5f, 0, 0}, 2);
  const Stage stage(std::move(d));
  const BakeLayout layout = lay_out(stage.scene, stage.tracer, {64, 0});
  for (const BakeFace& face : layout.faces) {
    EXPECT_EQ(stage.scene->geometry().material[face.triangle], 0u);
    EXPECT_EQ(stage.scene->geometry().emission[face.triangle], kNone);
  }
  ASSERT_EQ(layout.notes.size(), 2u);
  EXPECT_NE(layout.notes[0].find("'pane' (2 triangles) is not baked: its appearance"), std::string::npos)
      << layout.notes[0];
  EXPECT_NE(layout.notes[1].find("'mirror'"), std::string::npos);
}

TEST(BakeLayout, SharesLightThatComesThroughSurfaces) {
  SceneDescription d = two_rooms();
  d.materials.resize(3);
  d.materials[1].name = "paper";
  d.materials[1].transmittance.value = RGB(0.25f);
  d.materials[2].name = "leaf";
  d.materials[2].kind = MaterialKind::metallic_roughness;
  d.materials[2].roughness_u.value = d.materials[2].roughness_v.value = 1;
  d.materials[2].reflectance.value = RGB(1.0f);
  d.materials[2].diffuse_transmission.value = 0.5f;
  d.materials[2].transmittance.value = RGB(1.0f);
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0}, 1);
  add_quad(d, {1, 0.5f, 0.5f}, {0, 1, 0}, {0.5f, 0, 0}, 2);
  const Stage stage(std::move(d));
  const BakeLayout layout = lay_out(stage.scene, stage.tracer, {128, 0});
  EXPECT_THAT(layout.notes, testing::IsEmpty());
  const PointGrid grid = texel_points(*stage.scene, *stage.tracer, layout);
  constexpr float kShares[] = {0, 1 / 3.0f, 0.48f}, kTolerances[] = {0, 1e-5f, 0.02f};
  std::size_t texels[3] = {};
  for (std::size_t i = 0; i < grid.normal.size(); ++i) {
    if (layout.texels.face[i] == kNone) continue;
    const std::uint32_t m = stage.scene->geometry().material[layout.faces[layout.texels.face[i]].triangle];
    ++texels[m];
    EXPECT_NEAR(grid.from_behind[i].g, kShares[m], kTolerances[m]);
  }
  for (const std::size_t count : texels) EXPECT_GT(count, 0u);
}

TEST(BakeLayout, RefusesMoreTexelsThanMemoryHolds) {
  const Stage rooms(two_rooms());
  const auto memory_for = [&](std::uint64_t memory) {
    return lay_out(rooms.scene, rooms.tracer, {128, 0, memory}).texels.face.size();
  };
  const std::uint64_t needed = 128 * 128 * kTexelTableBytes;
  EXPECT_EQ(memory_for(needed + 1), 128u * 128u);
  try {
    memory_for(needed);
    ADD_FAILURE() << "laid out";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("for the places of texels exceed the memory budget"));
  }
}

TEST(BakeLayout, BakesWhatGlowsInPlacesOrLittle) {
  const auto bakes_panel = [](RGB emission, bool textured) {
    const Stage stage(room_with_panel(emission, textured));
    const BakeLayout layout = lay_out(stage.scene, stage.tracer, {64, 0});
    return std::any_of(layout.faces.begin(), layout.faces.end(),
                       [&](const BakeFace& face) { return stage.scene->geometry().material[face.triangle] == 1; });
  };
  EXPECT_TRUE(bakes_panel(RGB(0.1f), false));
  EXPECT_FALSE(bakes_panel(RGB(20.0f), false)) << "a lamp";
  EXPECT_TRUE(bakes_panel(RGB(20.0f), true)) << "its texture may be black in most places";
}

}  // namespace
}  // namespace glowworm
