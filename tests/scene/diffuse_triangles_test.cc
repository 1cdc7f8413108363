// The compact table of diffuse triangles: the same bits as the scene's tables.
#include "scene/diffuse_triangles.h"

#include <gtest/gtest.h>

#include <memory>

#include "builtin/builtin.h"
#include "core/offset_origin.h"
#include "scene/scene.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

bool has(const DiffuseTriangle& triangle, std::uint32_t bit) { return (triangle.kind & bit) != 0; }

class DiffuseTrianglesOf : public testing::TestWithParam<const char*> {};

TEST_P(DiffuseTrianglesOf, MatchTheSurfaces) {
  const Scene scene(builtin_scene(GetParam()));
  const Geometry& g = scene.geometry();
  std::size_t diffuse = 0;
  for (std::uint32_t t = 0; t < g.triangle_count(); t += 7) {
    const Vec2 barycentric{0.25f, 0.125f};
    const DiffuseTriangle& placed = scene.diffuse_triangle(t);
    const double offset = rounding_offset(placed.corner, placed.edge[0], placed.edge[1]);
    EXPECT_GE(placed.offset(), static_cast<float>(offset));
    EXPECT_LE(placed.offset(), offset * 1.008);
    SurfacePoint surface = surface_point(scene, t, barycentric);
    DiffusePoint point;
    const bool found = diffuse_point(scene, t, barycentric, point);
    ASSERT_EQ(found, has(scene.diffuse_triangle(t), DiffuseTriangle::kDiffuse));
    if (!found) continue;
    ++diffuse;
    EXPECT_EQ(has(scene.diffuse_triangle(t), DiffuseTriangle::kEmits), g.emission[t] != kNone);
    EXPECT_EQ(point.position, surface.position);
    EXPECT_EQ(point.geometric_normal, surface.geometric_normal);
    const Bsdf bsdf = resolve_bsdf(scene, surface);
    ASSERT_EQ(bsdf.kind, BsdfKind::lambertian);
    EXPECT_EQ(point.reflectance, bsdf.diffuse);
  }
  EXPECT_GT(diffuse, 0u);
}

INSTANTIATE_TEST_SUITE_P(Builtin, DiffuseTrianglesOf,
                         testing::Values("cornell", "atrium", "glass-sphere", "furnace-sphere", "window-room"),
                         scene_test_name);

/// One quad, whose material `change` alters.
template <typename Change>
DiffuseTriangle triangle_of(Change&& change) {
  SceneDescription d = floor_description();
  change(d);
  return Scene(std::move(d)).diffuse_triangle(0);
}

TEST(DiffuseTriangles, DistinguishKinds) {
  const auto plain = triangle_of([](SceneDescription& d) { d.materials[0].reflectance.value = {2, 0.5f, -1}; });
  EXPECT_EQ(plain.kind, DiffuseTriangle::kDiffuse);
  EXPECT_EQ(plain.reflectance, RGB(1, 0.5f, 0));
  EXPECT_EQ(triangle_of([](SceneDescription& d) { d.materials[0].kind = MaterialKind::conductor; }).kind, 0u);
  EXPECT_EQ(triangle_of([](SceneDescription& d) { d.materials[0].transmittance.value = RGB(0.1f); }).kind, 0u);
  const auto smooth = triangle_of([](SceneDescription& d) { d.geometry.normals[0] = {0, 0, 1}; });
  EXPECT_EQ(smooth.kind, DiffuseTriangle::kDiffuse | DiffuseTriangle::kSmooth);
  const auto textured = triangle_of([](SceneDescription& d) {
    d.textures.emplace_back();
    d.materials[0].reflectance.texture = 0;
    d.materials[0].bump.texture = 0;
  });
  EXPECT_EQ(textured.kind, DiffuseTriangle::kDiffuse | DiffuseTriangle::kTextured | DiffuseTriangle::kMapped);
  EXPECT_EQ(textured.reflectance, RGB(0.0f));
}

TEST(DiffuseTriangles, FollowAnEditThatMovesThem) {
  const Scene scene(floor_description());
  SceneEdit edit{scene.emissions(), scene.lights(), scene.environment(), nullptr, {}, ""};
  const Scene same(scene, edit);
  DiffuseTriangleRoom unused;
  EXPECT_EQ(&same.diffuse_triangle(0, unused), &scene.diffuse_triangle(0, unused));
  auto moved = std::make_shared<Geometry>(scene.geometry());
  const Vec3 shift{1, 2, 3};
  for (Vec3& position : moved->positions) position += shift;
  edit.geometry = moved;
  const Scene elsewhere(scene, edit);
  EXPECT_EQ(elsewhere.diffuse_triangle(0).corner, scene.diffuse_triangle(0).corner + shift);
}

}  // namespace
}  // namespace glowworm
