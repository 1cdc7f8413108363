// Ray tracing: batches against single rays, and both against a loop over all triangles.
#include "trace/tracer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "builtin/builtin.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"

namespace glowworm {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Vec3 random_point(Sampler& sampler) {
  const Vec2 u = sampler.next2();
  return {2 * u.x - 1, 2 * u.y - 1, 2 * sampler.next1() - 1};
}

/// Triangles of all sizes, anywhere within a cube two metres wide.
SceneDescription triangle_soup(std::uint32_t count) {
  SceneDescription d;
  d.name = "soup";
  d.materials.emplace_back();
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 0, i);
    const Vec3 corner = random_point(sampler);
    const float size = 0.05f + 0.5f * sampler.next1();
    Geometry triangle;
    triangle.positions = {corner, corner + random_point(sampler) * size, corner + random_point(sampler) * size};
    triangle.triangles = {{0, 1, 2}};
    append_mesh(d.geometry, triangle, "soup", 0, kNone);
  }
  return d;
}

/// Rays from anywhere to anywhere; lengths differ, and every third one ends after a random distance.
std::vector<Ray> random_rays(std::size_t count, std::uint32_t seed) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, 1, static_cast<std::uint32_t>(i));
    const Vec3 origin = random_point(sampler) * 1.5f;
    const Vec3 direction = square_to_sphere(sampler.next2()) * (0.5f + sampler.next1());
    rays.push_back({origin, 0, direction, i % 3 == 0 ? sampler.next1() : kInfinity});
  }
  return rays;
}

/// The closest hit by Moeller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection" (1997), in double
/// precision. `margin` is how far the barycentric coordinates of the closest near miss or hit stay from an edge.
struct PlainHit {
  double distance = std::numeric_limits<double>::infinity();
  std::uint32_t triangle = kNone;
  double u = 0, v = 0;
  bool doubtful = false;  ///< some triangle is met so near to its edge that single precision may decide otherwise
};

PlainHit plain_intersect(const Geometry& g, const Ray& ray) {
  struct D3 {
    double x, y, z;
  };
  const auto wide = [](Vec3 a) { return D3{a.x, a.y, a.z}; };
  const auto minus = [](D3 a, D3 b) { return D3{a.x - b.x, a.y - b.y, a.z - b.z}; };
  const auto cross3 = [](D3 a, D3 b) {
    return D3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const auto dot3 = [](D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  PlainHit best;
  const D3 o = wide(ray.origin), d = wide(ray.direction);
  for (std::uint32_t i = 0; i < g.triangle_count(); ++i) {
    const D3 a = wide(g.positions[g.triangles[i][0]]);
    const D3 e1 = minus(wide(g.positions[g.triangles[i][1]]), a), e2 = minus(wide(g.positions[g.triangles[i][2]]), a);
    const D3 p = cross3(d, e2);
    const double determinant = dot3(e1, p);
    if (determinant == 0) continue;
    const D3 s = minus(o, a), q = cross3(s, e1);
    const double u = dot3(s, p) / determinant, v = dot3(d, q) / determinant, t = dot3(e2, q) / determinant;
    constexpr double kEdge = 1e-4;
    if (std::min({u, v, 1 - u - v}) < -kEdge || t < -kEdge || t > ray.t_max + kEdge) continue;
    if (std::min({u, v, 1 - u - v}) < kEdge || t < kEdge || std::abs(t - ray.t_max) < kEdge) {
      best.doubtful = true;
      continue;
    }
    if (t < best.distance) best = {t, i, u, v, best.doubtful};
  }
  return best;
}

TEST(Tracer, FindsTheClosestOfAllTriangles) {
  const Scene scene(triangle_soup(600));
  const Tracer tracer(scene);
  std::size_t compared = 0, hits = 0;
  for (const Ray& ray : random_rays(1500, 7)) {
    const PlainHit plain = plain_intersect(scene.geometry(), ray);
    if (plain.doubtful) continue;
    ++compared;
    const Hit hit = tracer.intersect(ray);
    ASSERT_EQ(hit.triangle, plain.triangle);
    ASSERT_EQ(tracer.occluded(ray), plain.triangle != kNone);
    if (plain.triangle == kNone) continue;
    ++hits;
    EXPECT_NEAR(hit.distance, plain.distance, 1e-4);
    EXPECT_NEAR(hit.barycentric.x, plain.u, 1e-3);
    EXPECT_NEAR(hit.barycentric.y, plain.v, 1e-3);
  }
  EXPECT_GT(compared, 1200u);
  EXPECT_GT(hits, 400u);
  EXPECT_LT(hits, compared);
}

TEST(Tracer, CameraRaysPassTheBacksOfSingleSidedSurfaces) {
  SceneDescription d = floor_description();
  d.materials[0].single_sided = true;
  d.materials.emplace_back();
  add_quad(d, {-2, -2, 1}, {4, 0, 0}, {0, 4, 0}, 1);
  // Two faces in one plane: one of them faces the camera from either side.
  add_quad(d, {-2, -2, 2}, {4, 0, 0}, {0, 4, 0});
  add_quad(d, {-2, -2, 2}, {0, 4, 0}, {4, 0, 0});
  const Scene scene(std::move(d));
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{0, 1}}) {
    const Tracer tracer(scene, movable);
    const auto distances = [&](const Ray& ray, RayOrder order) {
      Hit hit;
      tracer.intersect({&ray, 1}, {&hit, 1}, order);
      const Hit alone = tracer.intersect(ray, order);
      EXPECT_EQ(hit.triangle, alone.triangle);
      return hit.distance;
    };
    const Ray up{{0.5f, 0.3f, -1}, 0, {0, 0, 1}, kInfinity}, down{{0.5f, 0.3f, 1.9f}, 0, {0, 0, -1}, kInfinity};
    EXPECT_FLOAT_EQ(distances(up, RayOrder::incoherent), 1);
    EXPECT_FLOAT_EQ(distances(up, RayOrder::camera), 2) << "the back of the floor is not seen, that of the quad is";
    EXPECT_FLOAT_EQ(distances(down, RayOrder::camera), 0.9f);
    EXPECT_FLOAT_EQ(distances({{0.5f, 0.3f, 1.5f}, 0, {0, 0, 1}, kInfinity}, RayOrder::camera), 0.5f);
    EXPECT_TRUE(tracer.occluded(up)) << "light stays out";
  }
}

/// A lamp that cameras do not see lies in a ceiling: they see the ceiling there, and all else meets the lamp.
TEST(Tracer, CameraRaysPassUnseenSurfaces) {
  SceneDescription d = floor_description();
  d.materials.emplace_back().unseen = true;
  d.emissions.emplace_back().radiance.value = RGB(1.0f);
  add_quad(d, {-0.5f, -0.5f, 1}, {1, 0, 0}, {0, 1, 0}, 1, 0);
  add_quad(d, {-2, -2, 1}, {4, 0, 0}, {0, 4, 0}, 0);
  add_quad(d, {-2, -2, 0.5f}, {0.1f, 0, 0}, {0, 0.1f, 0}, 1);
  const Scene scene(std::move(d));
  const std::uint32_t lamp = 2, ceiling = 4;
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{2, 3}}) {
    const Tracer tracer(scene, movable);
    const Ray up{{0.3f, 0.1f, 0.2f}, 0, {0, 0, 1}, kInfinity}, aside{{-1.96f, -1.98f, 0.2f}, 0, {0, 0, 1}, kInfinity};
    const std::vector<Ray> rays(16, up);
    std::vector<Hit> hits(16);
    for (const RayOrder order : {RayOrder::camera, RayOrder::incoherent}) {
      const std::uint32_t expected = order == RayOrder::camera ? ceiling : lamp;
      EXPECT_EQ(tracer.intersect(up, order).triangle / 2, expected / 2);
      tracer.intersect(rays, hits, order);
      EXPECT_EQ(hits.back().triangle / 2, expected / 2);
    }
    EXPECT_FLOAT_EQ(tracer.intersect(aside, RayOrder::camera).distance, 0.8f);
    EXPECT_FLOAT_EQ(tracer.intersect(aside).distance, 0.3f);
    EXPECT_TRUE(tracer.occluded({aside.origin, 0, aside.direction, 0.5f})) << "it stops light";
  }
}

TEST(Tracer, LightPassesPanesAlone) {
  SceneDescription d = triangle_soup(400);
  Material pane;
  pane.kind = MaterialKind::thin_dielectric;
  pane.transmittance.value = RGB(0.9f, 0.5f, 0.2f);
  d.materials.push_back(pane);
  for (std::size_t i = 0; i < d.geometry.material.size(); ++i) d.geometry.material[i] = i % 3 == 0 ? 0 : 1;
  // Long, thin and slanted: Embree splits such triangles, and meets them more than once.
  for (int i = 0; i < 40; ++i) add_quad(d, {-2, -2, 0.04f * static_cast<float>(i)}, {4, 4, 0.3f}, {0, 0.2f, 0}, 1);
  const Scene scene(std::move(d));
  std::vector<Ray> rays = random_rays(2003, 11);
  for (Ray& ray : rays) ray.direction = normalize(ray.direction);
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{5, 6}}) {
    const Tracer tracer(scene, movable);
    std::vector<RGB> batch(rays.size());
    tracer.transmittance(rays, batch);
    int dark = 0, dimmed = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      RGB expected(1.0f);
      bool doubtful = false;
      // From hit to hit. Where two are close together, the second may be missed.
      for (Ray rest = rays[i]; !is_black(expected);) {
        const Hit hit = tracer.intersect(rest);
        if (hit.triangle == kNone) break;
        doubtful |= hit.distance - rest.t_min < 1e-4f || rays[i].t_max - hit.distance < 1e-4f ||
                    std::min({hit.barycentric.x, hit.barycentric.y, 1 - hit.barycentric.x - hit.barycentric.y}) < 1e-4f;
        expected *= straight_transmittance(scene, hit.triangle, hit.barycentric, rays[i].direction);
        rest.t_min = hit.distance + 1e-5f;
      }
      if (doubtful) continue;
      dark += is_black(expected);
      dimmed += !is_black(expected) && expected.g < 1;
      for (const RGB& got : {batch[i], tracer.transmittance(rays[i])})
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 1e-5f) << i;
    }
    EXPECT_GT(dark, 200);
    EXPECT_GT(dimmed, 300);
  }
}

/// All triangles of a box of half-width `half` around the origin; each face has n x n squares.
SceneDescription tessellated_box(float half, int n) {
  SceneDescription d;
  d.name = "box";
  d.materials.emplace_back();
  const float side = 2 * half / static_cast<float>(n);
  for (int axis = 0; axis < 3; ++axis)
    for (const float end : {-half, half})
      for (int i = 0; i < n * n; ++i) {
        Vec3 corner, u, v;
        corner[axis] = end;
        corner[(axis + 1) % 3] = -half + side * static_cast<float>(i % n);
        corner[(axis + 2) % 3] = -half + side * static_cast<float>(i / n);
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = side;
        add_quad(d, corner, u, v);
      }
  return d;
}

TEST(Tracer, NoRaySlipsBetweenTriangles) {
  const Scene scene(tessellated_box(20, 4));
  const std::vector<Vec3>& corners = scene.geometry().positions;
  std::vector<Ray> rays;
  for (const auto& [a, b, c] : scene.geometry().triangles) {
    const Vec3 p = corners[a], q = corners[b], r = corners[c];
    for (const Vec3 target : {p, q, r, (p + q) * 0.5f, (q + r) * 0.5f, (r + p) * 0.5f})
      for (const Vec3 origin : {Vec3{0, 0, 0}, Vec3{0.1f, -3, 7}, Vec3{11.3f, 1.7f, -2.9f}})
        rays.push_back({origin, 0, target - origin, kInfinity});
  }
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{0, 1}}) {
    const Tracer tracer(scene, movable);
    std::vector<Hit> hits(rays.size());
    std::vector<std::uint8_t> hidden(rays.size());
    tracer.occluded(rays, hidden);
    for (const RayOrder order : {RayOrder::incoherent, RayOrder::camera}) {
      tracer.intersect(rays, hits, order);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_NEAR(hits[i].distance, 1, 1e-5f) << i;
        ASSERT_NEAR(tracer.intersect(rays[i], order).distance, 1, 1e-5f) << i;
        ASSERT_TRUE(hidden[i] == 1 && tracer.occluded(rays[i])) << i;
      }
    }
  }
}

TEST(Tracer, PanesDimOnceAtTheEdgesOfTheirTriangles) {
  SceneDescription d = tessellated_box(2, 3);
  d.materials[0].kind = MaterialKind::thin_dielectric;
  d.materials[0].transmittance.value = RGB(0.5f);
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  const Geometry& g = scene.geometry();
  std::size_t seen = 0;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const auto& [a, b, c] = g.triangles[t];
    const Vec3 p = g.positions[a], q = g.positions[b], r = g.positions[c];
    for (const Vec3 target : {p, q, r, (p + q) * 0.5f, (q + r) * 0.5f, (r + p) * 0.5f}) {
      // Where faces meet, the panes are dimmer or brighter than each other.
      const Vec3 inside{std::abs(target.x), std::abs(target.y), std::abs(target.z)};
      if ((inside.x > 1.99f) + (inside.y > 1.99f) + (inside.z > 1.99f) > 1) continue;
      const Ray ray{{0.1f, 0.2f, -0.3f}, 0, normalize(target - Vec3{0.1f, 0.2f, -0.3f}), kInfinity};
      const RGB expected = straight_transmittance(scene, t, {0.3f, 0.3f}, ray.direction);
      RGB batch;
      tracer.transmittance({&ray, 1}, {&batch, 1});
      EXPECT_NEAR(batch.g, expected.g, 1e-5f);
      EXPECT_NEAR(tracer.transmittance(ray).g, expected.g, 1e-5f);
      ++seen;
    }
  }
  EXPECT_GT(seen, 300u);
}

/// A ceiling of two large triangles with a lamp of two small ones exactly in its plane, turned in space.
SceneDescription ceiling_with_lamp(float height) {
  SceneDescription d;
  d.name = "ceiling";
  d.materials.emplace_back();
  d.emissions.emplace_back();
  const Frame frame = Frame::from_normal(normalize(Vec3{0.3f, 0.5f, -0.8f}));
  add_quad(d, frame.to_world({-2, -2, 0}), frame.to_world({4, 0, 0}), frame.to_world({0, 4.5f, 0}));
  add_quad(d, frame.to_world({-0.5f, -0.4f, height}), frame.to_world({1, 0, 0}), frame.to_world({0, 0.7f, 0}));
  d.geometry.emission[2] = d.geometry.emission[3] = 0;
  return d;
}

TEST(Tracer, ALampInTheCeilingsPlaneIsSeenFromBothSides) {
  const Scene scene(ceiling_with_lamp(0));
  const Frame frame = Frame::from_normal(normalize(Vec3{0.3f, 0.5f, -0.8f}));
  for (const std::vector<std::uint32_t>& movable : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{2, 3}}) {
    Tracer tracer(scene, movable);
    const auto lamp_share = [&](float side) {
      int lamp = 0, on_lamp = 0;
      for (std::uint32_t i = 0; i < 4000; ++i) {
        Sampler sampler(SamplerKind::independent, 6, 6, i);
        const Vec2 u = sampler.next2();
        const Vec3 target{3 * u.x - 1.5f, 3 * u.y - 1.5f, 0}, origin{0.2f, -0.1f, side};
        const Hit hit = tracer.intersect({frame.to_world(origin), 0, frame.to_world(target - origin), kInfinity});
        EXPECT_NEAR(hit.distance, 1, 1e-5f);
        lamp += hit.triangle == 2 || hit.triangle == 3;
        on_lamp += std::abs(target.x) < 0.499f && target.y > -0.399f && target.y < 0.299f;
      }
      return static_cast<float>(lamp) / static_cast<float>(on_lamp);
    };
    EXPECT_NEAR(lamp_share(-1.5f), 1, 0.02f);
    EXPECT_NEAR(lamp_share(1.5f), 1, 0.02f);
    if (movable.empty()) continue;
    // A lamp that leaves the plane leaves the ceiling whole.
    auto moved = std::make_shared<Geometry>(scene.geometry());
    for (std::size_t vertex = 4; vertex < 8; ++vertex) moved->positions[vertex] += frame.n * 0.01f;
    const Scene lower(scene, {scene.emissions(), scene.lights(), scene.environment(), moved, {}, {}});
    tracer.follow(lower);
    const Ray through{frame.to_world({0.1f, 0.1f, -1}), 0, frame.n, kInfinity};
    EXPECT_LT(tracer.intersect(through).triangle, 2u);
    EXPECT_TRUE(tracer.occluded({through.origin, 0, frame.n, 1.005f}));
    tracer.follow(scene);
    EXPECT_NEAR(lamp_share(1.5f), 1, 0.02f);
  }
}

TEST(Tracer, ShadowRaysReachALampInTheCeilingsPlane) {
  const Scene scene(ceiling_with_lamp(0));
  const Tracer tracer(scene);
  const DiffuseTriangle& lamp = scene.diffuse_triangle(2);
  for (std::uint32_t i = 0; i < 2000; ++i) {
    Sampler sampler(SamplerKind::independent, 7, 6, i);
    const Vec2 u = sampler.next2();
    // Up to rounding from the lamp, which is finer than the ceiling's.
    const Vec3 end = lamp.corner + lamp.edge[0] * (0.01f + 0.48f * u.x) + lamp.edge[1] * (0.01f + 0.48f * u.y);
    const Vec3 origin = random_point(sampler) * 1.5f;
    const Vec3 n = face_forward(lamp.normal, origin - end);
    if (std::abs(dot(n, origin - end)) < 0.01f) continue;
    EXPECT_FALSE(tracer.occluded({origin, 0, offset_origin(end, n, lamp.offset()) - origin, 1}));
  }
}

class TracerBatch : public testing::TestWithParam<RayOrder> {};

/// Packets may differ from single rays in the last bits of a distance, and where two surfaces are that close.
void expect_same(const Hit& batch, const Hit& single) {
  if (batch.triangle != single.triangle) {
    EXPECT_NEAR(batch.distance, single.distance, 1e-4f);
    return;
  }
  if (single.triangle == kNone) return;
  EXPECT_NEAR(batch.distance, single.distance, 2e-5f * (1 + single.distance));
  EXPECT_NEAR(batch.barycentric.x, single.barycentric.x, 1e-3f);
  EXPECT_NEAR(batch.barycentric.y, single.barycentric.y, 1e-3f);
}

TEST_P(TracerBatch, OfAnyCountMatchesSingleRays) {
  const Scene scene(triangle_soup(2000));
  const Tracer tracer(scene);
  for (const std::size_t count : {0, 1, 3, 7, 8, 9, 15, 16, 17, 31, 33, 1001}) {
    const std::vector<Ray> rays = random_rays(count, 3);
    // One more at the end tells whether a packet writes beyond the batch.
    Hit sentinel;
    sentinel.triangle = 12345;
    sentinel.distance = -7;
    std::vector<Hit> hits(count + 1, sentinel);
    std::vector<std::uint8_t> hidden(count + 1, 77);
    tracer.intersect(rays, std::span(hits).first(count), GetParam());
    tracer.occluded(rays, std::span(hidden).first(count));
    EXPECT_EQ(hits[count].triangle, 12345u);
    EXPECT_EQ(hits[count].distance, -7);
    EXPECT_EQ(hidden[count], 77);
    for (std::size_t i = 0; i < count; ++i) {
      expect_same(hits[i], tracer.intersect(rays[i]));
      EXPECT_EQ(hidden[i], hits[i].triangle != kNone ? 1 : 0);
    }
  }
}

TEST_P(TracerBatch, RespectsTheLengthOfRays) {
  SceneDescription d = floor_description();
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  // Down from a height of 1 m: two lengths of the direction.
  const Vec3 origin{0.3f, -0.2f, 1}, down{0, 0, -0.5f};
  const std::vector<Ray> rays = {{origin, 0, down, kInfinity},      {origin, 0, down, 2.001f},
                                 {origin, 0, down, 1.999f},         {origin, 1.999f, down, 3},
                                 {origin, 2.001f, down, kInfinity}, {origin, 0, -down, kInfinity}};
  const std::vector<std::uint8_t> expected = {1, 1, 0, 1, 0, 0};
  std::vector<Hit> hits(rays.size());
  std::vector<std::uint8_t> hidden(rays.size());
  tracer.intersect(rays, hits, GetParam());
  tracer.occluded(rays, hidden);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i].triangle != kNone, expected[i] == 1) << i;
    EXPECT_EQ(hidden[i], expected[i]) << i;
    EXPECT_EQ(tracer.occluded(rays[i]), expected[i] == 1) << i;
    if (expected[i] == 1) {
      EXPECT_NEAR(hits[i].distance, 2, 1e-5f);
    }
  }
}

/// A sheet one metre above the floor whose left half (u < 0.5) has the alpha given, in front of the floor.
SceneDescription sheet_above_floor(float alpha, float cutoff) {
  SceneDescription d = floor_description();
  d.textures.push_back(
      image_node([](Vec2) { return RGB(1.0f); }, [alpha](Vec2 uv) { return uv.x < 0.5f ? alpha : 1.0f; }));
  Material sheet;
  sheet.alpha.texture = 0;
  sheet.alpha.channel = Channel::alpha;
  sheet.alpha_cutoff = cutoff;
  d.materials.push_back(sheet);
  add_quad(d, {-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 1);
  return d;
}

std::vector<Ray> rays_down(std::size_t count) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 2, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2();
    rays.push_back({{1.9f * u.x - 0.95f, 1.9f * u.y - 0.95f, 2}, 0, {0, 0, -1}, kInfinity});
  }
  return rays;
}

TEST_P(TracerBatch, PassesThroughAlphaCutouts) {
  const Scene scene(sheet_above_floor(0.3f, 0.5f));
  const Tracer tracer(scene);
  const std::vector<Ray> rays = rays_down(501);
  std::vector<Hit> hits(rays.size());
  std::vector<std::uint8_t> hidden(rays.size());
  tracer.intersect(rays, hits, GetParam());
  std::vector<Ray> shadow = rays;
  for (Ray& ray : shadow) ray.t_max = 1.5f;  // ends between sheet and floor
  tracer.occluded(shadow, hidden);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool cut_out = rays[i].origin.x < 0;
    EXPECT_NEAR(hits[i].distance, cut_out ? 2 : 1, 1e-5f);
    EXPECT_EQ(hidden[i], cut_out ? 0 : 1);
    EXPECT_EQ(tracer.intersect(rays[i]).triangle, hits[i].triangle);
    EXPECT_EQ(tracer.occluded(shadow[i]), hidden[i] == 1);
  }
}

TEST_P(TracerBatch, PassesAShareOfRaysThroughHalfTransparentSurfaces) {
  const Scene scene(sheet_above_floor(0.3f, -1));
  const Tracer tracer(scene);
  const std::vector<Ray> rays = rays_down(20000);
  std::vector<Hit> hits(rays.size());
  tracer.intersect(rays, hits, GetParam());
  std::size_t over = 0, stopped = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].origin.x >= 0) {
      EXPECT_NEAR(hits[i].distance, 1, 1e-5f);
      continue;
    }
    ++over;
    stopped += hits[i].distance < 1.5f;
    EXPECT_EQ(tracer.intersect(rays[i]).triangle, hits[i].triangle);
  }
  // 4.9 standard deviations: a chance of one in a million.
  const double n = static_cast<double>(over);
  EXPECT_NEAR(stopped / n, 0.3, 4.9 * std::sqrt(0.3 * 0.7 / n));
}

// A sensor sends the same ray to a lamp again and again: chance would decide once for all of its light.
TEST(Tracer, PassesLightByTheShareThatIsAbsent) {
  SceneDescription d = sheet_above_floor(0.3f, -1);
  // Half of a second sheet, over the other side, is a pane, and half of it black.
  Material pane;
  pane.kind = MaterialKind::thin_dielectric;
  pane.reflectance.value = RGB(0.0f);
  pane.transmittance.value = RGB(0.5f);
  d.materials.push_back(pane);
  Material screen;
  screen.kind = MaterialKind::mix;
  screen.mix_a = 0;
  screen.mix_b = 2;
  screen.mix_amount.value = 0.4f;
  d.materials.push_back(screen);
  add_quad(d, {-1, -1, 1.5f}, {2, 0, 0}, {0, 2, 0}, 3);
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  std::vector<Ray> rays = rays_down(100);
  for (Ray& ray : rays) ray.t_max = 1.8f;  // ends between the sheets and the floor
  std::vector<RGB> passed(rays.size());
  tracer.transmittance(rays, passed);
  SurfacePoint on_pane = surface_point(scene, 4, {0.3f, 0.3f});
  on_pane.material = 2;
  const Bsdf glass = resolve_bsdf(scene, on_pane);
  const RGB screened = shaded(on_pane, glass).straight_transmittance({0, 0, 1}) * 0.4f;
  ASSERT_GT(screened.g, 0.1f);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RGB expected = rays[i].origin.x < 0 ? screened * 0.7f : RGB(0.0f);
    EXPECT_NEAR(passed[i].g, expected.g, 1e-6f);
    EXPECT_EQ(tracer.transmittance(rays[i]), passed[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, TracerBatch, testing::Values(RayOrder::incoherent, RayOrder::camera),
                         [](const auto& info) { return info.param == RayOrder::camera ? "camera" : "incoherent"; });

TEST(Tracer, ArraysOfCoherentAndOtherRaysMatchSingleRays) {
  const Scene scene(triangle_soup(2000));
  const Tracer tracer(scene);
  std::vector<Vec3> origin, direction;
  for (const Ray& ray : random_rays(501, 5)) origin.push_back(ray.origin), direction.push_back(ray.direction);
  // Rows of a picture, seen from one place.
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 100; ++x) {
      origin.push_back({0, 0, 5});
      direction.push_back({0.01f * static_cast<float>(x - 50), 0.05f * static_cast<float>(y - 10), -1});
    }
  std::vector<float> t_max(origin.size());
  for (std::size_t i = 0; i < t_max.size(); ++i) t_max[i] = i % 3 == 0 ? 0.5f : kInfinity;
  std::vector<float> distance(origin.size());
  std::vector<std::uint32_t> triangle(origin.size());
  std::vector<Vec2> barycentric(origin.size());
  for (const std::size_t given : {std::size_t{0}, std::size_t{1}, t_max.size()}) {
    const std::span<const float> ends = std::span(t_max).first(given);
    tracer.intersect({origin, direction, 0.01f, ends}, {distance, triangle, barycentric});
    for (std::size_t i = 0; i < origin.size(); ++i) {
      const float end = given == 0 ? kInfinity : ends[given == 1 ? 0 : i];
      expect_same({distance[i], triangle[i], barycentric[i]},
                  tracer.intersect(Ray{origin[i], 0.01f, direction[i], end}));
      if (triangle[i] == kNone) {
        EXPECT_EQ(distance[i], kInfinity);
        EXPECT_EQ(barycentric[i].x, 0);
      }
    }
  }
}

TEST(Tracer, RaysThatLeaveASurfaceDoNotHitItAgain) {
  const Scene scene(triangle_soup(300));
  const Tracer tracer(scene);
  std::size_t tried = 0;
  for (const Ray& ray : random_rays(4000, 11)) {
    const Hit hit = tracer.intersect(ray);
    if (hit.triangle == kNone) continue;
    const SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
    for (const float sign : {1.0f, -1.0f}) {
      const Vec3 n = point.geometric_normal * sign;
      Sampler sampler(SamplerKind::independent, 2, 3, static_cast<std::uint32_t>(tried++));
      const Vec3 direction = Frame::from_normal(n).to_world(square_to_cosine_hemisphere(sampler.next2()));
      const Hit next = tracer.intersect({offset_origin(point.position, n, point.offset), 0, direction, kInfinity});
      EXPECT_NE(next.triangle, hit.triangle);
    }
  }
  EXPECT_GT(tried, 1000u);
}

/// The structure is built on all threads; whatever their number, a ray finds the same triangle, on edges too: a tenth
/// of the rays aim at vertices, where several triangles are as close.
TEST(Tracer, IsTheSameForAnyNumberOfThreads) {
  const Scene scene(builtin_scene("atrium"));
  const Geometry& g = scene.geometry();
  constexpr std::uint32_t kRays = 200'000;
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    Sampler sampler(SamplerKind::independent, 4, 4, i);
    const Vec3 origin = scene.center() + square_to_sphere(sampler.next2()) * (scene.radius() * 0.7f * sampler.next1());
    const auto vertex = static_cast<std::size_t>(sampler.next1() * static_cast<float>(g.positions.size()));
    const Vec3 direction = i % 10 == 0 ? g.positions[vertex] - origin : square_to_sphere(sampler.next2());
    rays.push_back({origin, 0, direction, kInfinity});
  }
  std::vector<std::vector<Hit>> hits;
  for (const int threads : {1, 2, 5, 2}) {
    set_thread_count(threads);
    const Tracer tracer(scene);
    tracer.intersect(rays, hits.emplace_back(rays.size()), RayOrder::incoherent);
  }
  set_thread_count(0);
  for (std::size_t other = 1; other < hits.size(); ++other)
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[other][i].triangle, hits[0][i].triangle) << "ray " << i;
      if (hits[0][i].triangle == kNone) continue;
      ASSERT_EQ(hits[other][i].distance, hits[0][i].distance) << "ray " << i;
    }
}

TEST(Tracer, CountsTheBytesItHolds) {
  const Scene small(triangle_soup(100)), large(triangle_soup(5000));
  const Tracer small_tracer(small), large_tracer(large);
  EXPECT_GT(small_tracer.bytes(), 0u);
  // Vertices and indices alone: three vertices of 12 bytes and three indices of 4 bytes a triangle.
  EXPECT_GT(large_tracer.bytes(), 5000u * 48);
}

/// A tracer that followed its scene to where some triangles are now answers as one that was made of it.
TEST(Tracer, FollowsMovedTriangles) {
  SceneDescription description = triangle_soup(400);
  description.emissions.emplace_back();
  std::vector<std::uint32_t> movable;
  for (std::uint32_t i = 0; i < 400; i += 9) {
    description.geometry.emission[i] = 0;
    movable.push_back(i);
  }
  const Scene before(description);
  auto moved = std::make_shared<Geometry>(before.geometry());
  for (const std::uint32_t i : movable)
    for (const std::uint32_t vertex : moved->triangles[i]) moved->positions[vertex] += Vec3{0.3f, -0.2f, 0.1f};
  const Scene after(before, {before.emissions(), before.lights(), before.environment(), moved, {}, {}});
  Tracer following(before, movable);
  const Tracer made(after);
  const std::vector<Ray> rays = random_rays(4000, 5);
  std::vector<Hit> first(rays.size()), second(rays.size()), wanted(rays.size());
  following.intersect(rays, first, RayOrder::incoherent);
  following.follow(after);
  following.intersect(rays, second, RayOrder::incoherent);
  made.intersect(rays, wanted, RayOrder::incoherent);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(second[i].triangle, wanted[i].triangle) << "ray " << i;
    if (second[i].triangle == kNone) continue;
    ASSERT_NEAR(second[i].distance, wanted[i].distance, 1e-5f) << "ray " << i;
    changed += second[i].triangle != first[i].triangle || second[i].distance != first[i].distance;
  }
  EXPECT_GT(changed, 100u);
  EXPECT_EQ(&following.scene(), &after);
}

TEST(TracerTest, VisitsAllTrianglesNearAPlace) {
  const Scene scene(builtin_scene("ajar"));
  const Tracer tracer(scene);
  const Geometry& geometry = scene.geometry();
  const Box3 bounds = geometry.bounds();
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Vec3 u{to_unit_float(hash32(3 * i)), to_unit_float(hash32(3 * i + 1)), to_unit_float(hash32(3 * i + 2))};
    const Vec3 extent = bounds.diagonal();
    const Vec3 center = bounds.min + Vec3{u.x * extent.x, u.y * extent.y, u.z * extent.z};
    const float radius = 0.05f * length(extent) * to_unit_float(hash32(i));
    std::set<std::uint32_t> visited;
    tracer.visit_near(center, radius, [&](std::uint32_t triangle) {
      visited.insert(triangle);
      return true;
    });
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t)
      for (const std::uint32_t vertex : geometry.triangles[t])
        EXPECT_TRUE(length(geometry.positions[vertex] - center) >= radius || visited.contains(t)) << t;
  }
}

TEST(TracerTest, VisitsNoMoreTrianglesAfterTheEnd) {
  const Scene scene(builtin_scene("ajar"));
  const Tracer tracer(scene);
  int visits = 0;
  tracer.visit_near({}, 1e3f, [&](std::uint32_t) { return ++visits < 5; });
  EXPECT_EQ(visits, 5);
}

/// Sheets of one plane that overlap, and boards elsewhere whose places depend on `moment`.
Scene overlapping_sheets(std::uint32_t moment) {
  SceneDescription d = floor_description();
  for (std::uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(SamplerKind::independent, 4, i, i < 100 ? 0 : moment);
    const Vec2 u = sampler.next2();
    const Vec3 corner{2 * u.x - 1.5f, 2 * u.y - 1.5f, i < 100 ? 0 : -0.1f - sampler.next1()};
    add_quad(d, corner, {1, 0, 0}, {0, 1, 0});
  }
  return Scene(std::move(d));
}

TEST(TracerTest, TiesByNumberStayWhereOtherTrianglesMove) {
  const std::vector<Ray> rays = [] {
    std::vector<Ray> out;
    for (std::uint32_t i = 0; i < 5000; ++i) {
      Sampler sampler(SamplerKind::independent, 5, i, 0);
      const Vec2 u = sampler.next2();
      out.push_back({{2 * u.x - 1, 2 * u.y - 1, 1}, 0, {0.1f * sampler.next1(), 0, -1}, kInfinity});
    }
    return out;
  }();
  const auto triangles = [&](std::uint32_t moment, TieRule ties) {
    const Scene scene = overlapping_sheets(moment);
    std::vector<Hit> hits(rays.size());
    Tracer(scene, ties).intersect(rays, hits, RayOrder::incoherent);
    std::vector<std::uint32_t> out;
    for (const Hit& hit : hits) out.push_back(hit.triangle);
    return out;
  };
  const std::vector<std::uint32_t> first = triangles(0, TieRule::number);
  for (std::uint32_t moment = 1; moment < 5; ++moment) EXPECT_EQ(triangles(moment, TieRule::number), first) << moment;
  const std::vector<std::uint32_t> others = triangles(0, TieRule::structure);
  std::size_t lower = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_LE(first[i], others[i]) << i;
    lower += first[i] < others[i];
  }
  EXPECT_GT(lower, rays.size() / 20);
}

/// Embree would test each ray against all of them.
TEST(TracerTest, HoldsOneOfManyEqualTriangles) {
  SceneDescription d = floor_description();
  const Scene once(d);
  const Tracer tracer_once(once);
  for (int i = 0; i < 10; ++i) d.geometry.triangles.insert(d.geometry.triangles.end(), {{0, 1, 2}, {0, 2, 3}});
  d.geometry.material.resize(22, 0);
  d.geometry.emission.resize(22, kNone);
  const Scene scene(d);
  const Tracer tracer(scene);
  EXPECT_EQ(tracer.bytes(), tracer_once.bytes());
  std::multiset<std::uint32_t> visited;
  tracer.visit_near({}, 1e3f, [&](std::uint32_t triangle) {
    visited.insert(triangle);
    return true;
  });
  EXPECT_EQ(visited, (std::multiset<std::uint32_t>{0, 1}));
  EXPECT_EQ(tracer.intersect(Ray{{0.5f, -1, 1}, 0, {0, 0, -1}, kInfinity}).triangle, 0u);
}

}  // namespace
}  // namespace glowworm
