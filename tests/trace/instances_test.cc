// Rays among instances: as among copies of their meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "builtin/mesh_builder.h"
#include "core/offset_origin.h"
#include "scene/instance_parts.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"
#include "trace/tracer.h"

namespace glowworm {
namespace {

constexpr float kForever = std::numeric_limits<float>::infinity();

Vec3 point_in_cube(Sampler& sampler) {
  const Vec2 u = sampler.next2();
  return {2 * u.x - 1, 2 * u.y - 1, 2 * sampler.next1() - 1};
}

/// Small triangles with smooth normals and texture coordinates, of three materials in turn.
Geometry soup(std::uint32_t count) {
  Geometry out;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 3, 0, i);
    const Vec3 corner = point_in_cube(sampler) * 0.4f;
    Geometry t;
    t.positions = {corner, corner + point_in_cube(sampler) * 0.2f, corner + point_in_cube(sampler) * 0.2f};
    t.uvs = {{0, 0}, {1, 0}, {0.2f, 1}};
    const Vec3 n = cross(t.positions[1] - corner, t.positions[2] - corner);
    for (int k = 0; k < 3; ++k) t.normals.push_back(normalize(n) + point_in_cube(sampler) * 0.2f);
    t.triangles = {{0, 1, 2}};
    append_mesh(out, t, "soup", i % 3, kNone);
  }
  return out;
}

/// A floor, and a soup placed twenty times, turned, sheared and mirrored. Materials: diffuse with a texture, a pane,
/// and a single-sided one with holes.
SceneDescription many_soups() {
  SceneDescription d = floor_description();
  d.materials.resize(3);
  d.textures.push_back(
      image_node([](Vec2 uv) { return RGB(uv.x, uv.y, 0.5f); }, [](Vec2 uv) { return uv.x > 0.3f ? 1.0f : 0.0f; }));
  d.materials[0].reflectance = {RGB(1.0f), 0};
  d.materials[1].kind = MaterialKind::thin_dielectric;
  d.materials[1].transmittance.value = RGB(0.9f, 0.5f, 0.2f);
  d.materials[2].single_sided = true;
  d.materials[2].alpha.texture = 0;
  d.materials[2].alpha.channel = Channel::alpha;
  d.materials[2].alpha_cutoff = 0.5f;
  const std::uint32_t mesh = add_shared_mesh(d, soup(150)), back = add_shared_mesh(d, wound_back(soup(150)));
  for (std::uint32_t i = 0; i < 20; ++i) add_places(d, i % 2 ? back : mesh, {random_place(i, i % 2)});
  return d;
}

std::vector<Ray> rays_everywhere(std::size_t count) {
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 8, 1, i);
    const Vec3 origin = point_in_cube(sampler) * 1.5f;
    rays.push_back({origin, 0, square_to_sphere(sampler.next2()), i % 3 == 0 ? sampler.next1() : kForever});
  }
  return rays;
}

bool is_near_edge(Vec2 b) { return std::min({b.x, b.y, 1 - b.x - b.y}) < 1e-3f; }

TEST(Instances, AreMetAsCopiesAre) {
  const Scene kept(many_soups()), copied(expanded(many_soups()));
  ASSERT_EQ(kept.geometry().triangle_count(), 2 + 20 * 150u);
  ASSERT_EQ(copied.geometry().triangles.size(), kept.geometry().triangle_count());
  const std::vector<Ray> rays = rays_everywhere(4000);
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{0, 1}}) {
    const Tracer by_instance(kept, movable), by_copy(copied, movable);
    for (const RayOrder order : {RayOrder::incoherent, RayOrder::camera}) {
      std::vector<Hit> a(rays.size()), b(rays.size());
      by_instance.intersect(rays, a, order);
      by_copy.intersect(rays, b, order);
      std::size_t met = 0, other = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(by_instance.intersect(rays[i], order).triangle, a[i].triangle);
        // A ray may pass an edge on either side.
        if (a[i].triangle != b[i].triangle) {
          ++other;
          continue;
        }
        if (a[i].triangle == kNone) continue;
        met += a[i].triangle > 1;
        EXPECT_NEAR(a[i].distance, b[i].distance, 1e-4f);
        if (is_near_edge(a[i].barycentric)) continue;
        EXPECT_NEAR(a[i].barycentric.x, b[i].barycentric.x, 5e-3f);
        EXPECT_NEAR(a[i].barycentric.y, b[i].barycentric.y, 5e-3f);
      }
      EXPECT_GT(met, 1000u);
      EXPECT_LT(other, 8u);
    }
    std::vector<std::uint8_t> a(rays.size()), b(rays.size());
    std::vector<RGB> through_a(rays.size()), through_b(rays.size());
    by_instance.occluded(rays, a);
    by_copy.occluded(rays, b);
    by_instance.transmittance(rays, through_a);
    by_copy.transmittance(rays, through_b);
    std::size_t other = 0, dimmed = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      other += a[i] != b[i] || max_component(through_a[i] - through_b[i]) > 1e-3f;
      dimmed += through_a[i].g > 0 && through_a[i].g < 1;
      ASSERT_EQ(by_instance.occluded(rays[i]), a[i] != 0);
      EXPECT_NEAR(by_instance.transmittance(rays[i]).g, through_a[i].g, 1e-6f);
    }
    EXPECT_LT(other, 16u);
    EXPECT_GT(dimmed, 100u);
  }
}

TEST(Instances, HaveTheSurfacesOfCopies) {
  const Scene kept(many_soups()), copied(expanded(many_soups()));
  EXPECT_EQ(kept.radius(), copied.radius());
  EXPECT_EQ(kept.bounds().min, copied.bounds().min);
  EXPECT_TRUE(kept.smooth());
  for (std::uint32_t t = 0; t < kept.geometry().triangle_count(); ++t) {
    SurfacePoint a = surface_point(kept, t, {0.2f, 0.3f}), b = surface_point(copied, t, {0.2f, 0.3f});
    ASSERT_EQ(a.position, b.position);
    ASSERT_EQ(a.geometric_normal, b.geometric_normal);
    ASSERT_EQ(a.frame.n, b.frame.n);
    ASSERT_EQ(a.frame.s, b.frame.s);
    ASSERT_EQ(a.texture.uv.x, b.texture.uv.x);
    ASSERT_EQ(a.material, b.material);
    ASSERT_EQ(a.offset > b.offset, t > 1) << "the transform rounds, too";
    DiffusePoint p, q;
    ASSERT_EQ(diffuse_point(kept, t, {0.2f, 0.3f}, p), diffuse_point(copied, t, {0.2f, 0.3f}, q));
    ASSERT_EQ(resolve_bsdf(kept, a).diffuse, resolve_bsdf(copied, b).diffuse);
  }
}

/// A closed shape in a place where coordinates are coarse.
TEST(Instances, AreNotMetAgainByRaysThatLeaveThem) {
  SceneDescription d = floor_description();
  SceneDescription source;
  MeshBuilder builder(source.geometry);
  builder.sphere({30, 0, 0}, 0.5f, 48, 24);
  Geometry ball;
  append_mesh(ball, source.geometry, "ball", 0, kNone);
  std::fill(ball.normals.begin(), ball.normals.end(), Vec3{0, 0, 0});
  const std::uint32_t mesh = add_shared_mesh(d, ball);
  for (std::uint32_t i = 0; i < 40; ++i) add_places(d, mesh, {random_place(i, false, i % 2 ? 0.1f : 3, 200)});
  const Scene scene(d);
  const Tracer tracer(scene);
  for (std::uint32_t i = 0; i < 60'000; ++i) {
    Sampler sampler(SamplerKind::independent, 9, 2, i);
    const auto triangle =
        2 + static_cast<std::uint32_t>(sampler.next1() * static_cast<float>(scene.geometry().triangle_count() - 2));
    const SurfacePoint p = surface_point(scene, triangle, square_to_triangle(sampler.next2()));
    const Frame frame = Frame::from_normal(p.geometric_normal);
    const Vec3 out = frame.to_world(square_to_cosine_hemisphere(sampler.next2()));
    const Instance& own = *scene.geometry().stored(triangle).instance;
    // Outwards no triangle of the ball is met, inwards always one.
    const Hit away = tracer.intersect({offset_origin(p.position, p.geometric_normal, p.offset), 0, out, kForever});
    ASSERT_TRUE(away.triangle == kNone || scene.geometry().stored(away.triangle).instance != &own) << i;
    const Hit across = tracer.intersect({offset_origin(p.position, -p.geometric_normal, p.offset), 0, -out, kForever});
    ASSERT_NE(across.triangle, kNone) << i;
  }
}

TEST(Instances, AreVisitedNearAPoint) {
  const Scene scene(many_soups());
  const Tracer tracer(scene);
  std::size_t all = 0;
  for (std::uint32_t i = 0; i < 50; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 2, i);
    const Vec3 center = point_in_cube(sampler);
    const float radius = 0.3f * sampler.next1();
    std::set<std::uint32_t> visited;
    tracer.visit_near(center, radius, [&](std::uint32_t triangle) {
      visited.insert(triangle);
      return true;
    });
    all += visited.size();
    for (std::uint32_t t = 0; t < scene.geometry().triangle_count(); ++t)
      for (const Vec3& corner : scene.geometry().corners(t))
        ASSERT_TRUE(length(corner - center) >= radius || visited.contains(t));
    int visits = 0;
    tracer.visit_near(center, 10, [&](std::uint32_t) { return ++visits < 5; });
    EXPECT_EQ(visits, 5);
  }
  EXPECT_LT(all, 50 * scene.geometry().triangle_count() / 5);
}

/// A ceiling that is an instance, with a lamp exactly in its plane.
TEST(Instances, HaveHolesWhereLampsLieInTheirPlanes) {
  SceneDescription d;
  d.materials.emplace_back();
  d.emissions.emplace_back();
  add_quad(d, {-0.5f, -0.4f, 2}, {1, 0, 0}, {0, 0.7f, 0}, 0, 0);
  SceneDescription ceiling;
  add_quad(ceiling, {-2, -2, 0}, {4, 0, 0}, {0, 4.5f, 0});
  add_places(d, add_shared_mesh(d, ceiling.geometry), {Transform{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}}});
  const Scene scene(d);
  const Tracer tracer(scene);
  for (const float from : {-1.0f, 5.0f}) {
    EXPECT_LT(tracer.intersect({{0.1f, 0.1f, from}, 0, {0, 0, 2 - from}, kForever}).triangle, 2u);
    EXPECT_GE(tracer.intersect({{1.1f, 0.1f, from}, 0, {0, 0, 2 - from}, kForever}).triangle, 2u);
  }
}

/// Rays would be tested against each of them.
TEST(Instances, InOnePlaceAreMetOnce) {
  SceneDescription d = floor_description();
  SceneDescription pane;
  add_quad(pane, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const std::uint32_t mesh = add_shared_mesh(d, pane.geometry);
  const Transform above{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}}, higher{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}};
  add_places(d, mesh, {above, higher, above, above});
  const Scene scene(d);
  std::multiset<std::uint32_t> visited;
  const Tracer tracer(scene);
  tracer.visit_near({0, 0, 1.5f}, 0.8f, [&](std::uint32_t triangle) {
    visited.insert(triangle);
    return true;
  });
  visited.erase(0);
  visited.erase(1);
  EXPECT_EQ(visited, (std::multiset<std::uint32_t>{2, 3, 4, 5}));
  EXPECT_LT(tracer.intersect({{0.1f, 0.2f, 0.5f}, 0, {0, 0, 1}, kForever}).triangle, 4u);
}

TEST(Instances, CostLittleMemoryEach) {
  SceneDescription d = floor_description();
  d.materials.resize(3);
  d.cameras.push_back(look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45));
  d.environment.emplace();
  const std::uint32_t mesh = add_shared_mesh(d, soup(100));
  const std::uint64_t before = Tracer(Scene(d)).bytes();
  std::vector<Transform> places;
  for (std::uint32_t i = 0; i < 10'000; ++i) places.push_back(random_place(i, false, 0.01f, 10));
  add_places(d, mesh, places);
  const Scene scene(d);
  const std::uint64_t after = Tracer(scene).bytes();
  EXPECT_LT((after - before) / places.size(), 200 - sizeof(Instance));
}

}  // namespace
}  // namespace glowworm
