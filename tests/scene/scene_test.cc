// Construction of scenes, and shading of surfaces.
#include "scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/frame.h"
#include "core/offset_origin.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/default_camera.h"
#include "scene/environment.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"
#include "scene/studio_light.h"
#include "scene/surface.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

TEST(SceneTest, AddsACameraThatSeesAllAndTheStudioLight) {
  const Scene scene(floor_description());
  ASSERT_EQ(scene.cameras().size(), 1u);
  EXPECT_EQ(scene.notes().size(), 2u);
  const Camera& camera = scene.camera("");
  for (const Vec3& p : scene.geometry().positions) {
    const Vec3 seen = inverse(camera.to_world).point(p);
    EXPECT_LE(std::max(std::abs(seen.x), std::abs(seen.y)) / seen.z, camera.half_extent * 1.0001f);
  }
  EXPECT_EQ(scene.environment()->name, "studio light");
  EXPECT_GT(scene.light_power().total(), 0);
  EXPECT_NEAR(scene.radius(), 2 * std::sqrt(2.0f), 1e-5f);
}

TEST(SceneTest, MovesToTheOriginFromAfar) {
  SceneDescription d = lit_floor(LightCase::all);
  d.cameras.push_back(look_at({1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 40));
  const Scene near(d);
  EXPECT_EQ(near.origin(), (Vec3{0, 0, 0}));
  EXPECT_EQ(near.geometry().positions, d.geometry.positions);
  SceneDescription along_x = d;
  translate(along_x, {300'000.4f, 0.3f, 500});
  EXPECT_EQ(Scene(along_x).origin().y, 0);
  EXPECT_EQ(Scene(along_x).origin().z, 0) << "a hundred sizes away is near";
  EXPECT_NEAR(Scene(along_x).origin().x, 300'000.4f, 3);
  translate(d, kFarAway);
  const Scene far(d);
  for (std::size_t v = 0; v < d.geometry.positions.size(); ++v) {
    EXPECT_EQ(far.outside(far.geometry().positions[v]), Vec3d(d.geometry.positions[v]));
    EXPECT_EQ(far.inside(d.geometry.positions[v]), far.geometry().positions[v]);
  }
  EXPECT_LT(length(far.center()), 0.1f);
  for (std::size_t i = 0; i < d.lights.size(); ++i)
    EXPECT_EQ(far.lights()[i].position, d.lights[i].position - far.origin());
  EXPECT_EQ(far.camera("").to_world.translation, d.cameras[0].to_world.translation - far.origin());
  const Scene edited(far, {far.emissions(), far.lights(), far.environment(), nullptr, {}, ""});
  EXPECT_EQ(edited.origin(), far.origin());
  EXPECT_EQ(edited.lights()[0].position, far.lights()[0].position);
}

TEST(SceneTest, TellsThatItsVerticesWereRounded) {
  const auto moved = [](float by) {
    SceneDescription d = floor_description();
    translate(d, {by, 0, 0});
    return Scene(std::move(d)).notes();
  };
  const auto bent = testing::Contains(HasSubstr("coordinates are rounded to"));
  EXPECT_THAT(moved(5000), testing::Not(bent));
  EXPECT_THAT(moved(6000), bent);
  EXPECT_THAT(moved(300'000), testing::Contains(HasSubstr("rounded to 0.031 m")));
}

/// A box from (-1, 0, -2) to (1, 3, 2) whose walls face inwards, or all outwards; without its side at z = 2.
SceneDescription open_box(bool inwards) {
  SceneDescription d;
  d.materials.emplace_back();
  const auto wall = [&](Vec3 corner, Vec3 x, Vec3 y) {
    if (inwards)
      add_quad(d, corner, x, y);
    else
      add_quad(d, corner, y, x);
  };
  wall({-1, 0, 2}, {2, 0, 0}, {0, 0, -4});
  wall({-1, 3, -2}, {2, 0, 0}, {0, 0, 4});
  wall({-1, 0, -2}, {2, 0, 0}, {0, 3, 0});
  wall({-1, 0, 2}, {0, 0, -4}, {0, 3, 0});
  wall({1, 0, -2}, {0, 0, 4}, {0, 3, 0});
  return d;
}

/// A box with its walls facing inwards or outwards.
void add_closed_box(SceneDescription& d, Box3 box, bool inwards) {
  const Vec3 size = box.diagonal(), x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
  const auto wall = [&](Vec3 corner, Vec3 a, Vec3 b) { add_quad(d, corner, inwards ? a : b, inwards ? b : a); };
  wall(box.min, x, y);
  wall(box.min, y, z);
  wall(box.min, z, x);
  wall(box.max, -y, -x);
  wall(box.max, -z, -y);
  wall(box.max, -x, -z);
}

/// A house of boxes in a land 100 km across.
SceneDescription house_in_wide_land(float from_origin) {
  SceneDescription d;
  d.materials.emplace_back();
  add_quad(d, {-5e4f, 0, -5e4f}, {0, 0, 1e5f}, {1e5f, 0, 0});
  for (int i = 0; i < 3; ++i)
    add_closed_box(d, {{3.0f * static_cast<float>(i), 0, 0}, {3.0f * static_cast<float>(i) + 2, 3, 2}}, false);
  translate(d, {0, 0, from_origin});
  return d;
}

TEST(SceneTest, TellsThatSmallTrianglesWereRounded) {
  const auto bent =
      testing::Contains(HasSubstr("95% of the scene's triangles are small and far from the origin, where "
                                  "coordinates are rounded to 0.062 m"));
  EXPECT_THAT(Scene(house_in_wide_land(1e6f)).notes(), bent);
  const auto rounded = testing::Contains(HasSubstr("coordinates are rounded to"));
  EXPECT_THAT(Scene(house_in_wide_land(1e5f)).notes(), testing::Not(rounded));
  SceneDescription few = house_in_wide_land(1e6f);
  for (int i = 0; i < 200; ++i) add_quad(few, {100, 0, 1e6f + 100 * static_cast<float>(i)}, {0, 0, 100}, {100, 0, 0});
  EXPECT_THAT(Scene(few).notes(), testing::Not(rounded));
}

SceneDescription closed_box(Box3 box, bool inwards) {
  SceneDescription d;
  d.materials.emplace_back();
  add_closed_box(d, box, inwards);
  return d;
}

TEST(DefaultCamera, IsNotBlockedByAPillar) {
  SceneDescription d = closed_box({{-10, 0, -4}, {10, 5, 4}}, true);
  // One before the middle of each short wall, and two rows of smaller ones.
  for (const float x : {-6.9f, 6.9f}) add_closed_box(d, {{x - 0.5f, 0, -1}, {x + 0.5f, 5, 1}}, false);
  for (const float x : {-3.0f, 3.0f})
    for (const float z : {-3.0f, 3.0f}) add_closed_box(d, {{x - 0.3f, 0, z - 0.3f}, {x + 0.3f, 5, z + 0.3f}}, false);
  const Scene scene(std::move(d));
  const Camera& camera = scene.camera("");
  EXPECT_TRUE(scene.bounds().contains(camera.to_world.translation));
  // The middle of the picture looks far along the room.
  const Vec3 eye = camera.to_world.translation;
  float nearest = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 9; ++i) {
    const Vec2 film{40 + 10.0f * static_cast<float>(i % 3), 40 + 10.0f * static_cast<float>(i / 3)};
    const Vec3 way = generate_ray(camera, film, 100, 100, {0.5f, 0.5f}).direction;
    for (const auto& [a, b, c] : scene.geometry().triangles) {
      const Vec3 p = scene.geometry().positions[a], e1 = scene.geometry().positions[b] - p,
                 e2 = scene.geometry().positions[c] - p;
      const float determinant = dot(e1, cross(way, e2));
      if (determinant == 0) continue;
      const Vec3 s = (eye - p) / determinant, q = cross(s, e1);
      const float u = dot(s, cross(way, e2)), v = dot(way, q), t = dot(e2, q);
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) nearest = std::min(nearest, t);
    }
  }
  EXPECT_GT(nearest, 5);
}

TEST(DefaultCamera, SeesAHollowObjectFromOutside) {
  // A shell with many outer faces, whose lining faces the middle on all sides.
  SceneDescription d = closed_box({{-1, -1, -1}, {1, 1, 1}}, true);
  add_closed_box(d, {{-1.1f, -1.1f, -1.1f}, {1.1f, 1.1f, 1.1f}}, false);
  for (int i = 0; i < 8; ++i) {
    const float z = -1 + 0.25f * static_cast<float>(i);
    add_closed_box(d, {{1.1f, -1, z}, {1.2f, 1, z + 0.2f}}, false);
  }
  const Scene scene(std::move(d));
  EXPECT_FALSE(scene.bounds().contains(scene.camera("").to_world.translation));
}

TEST(DefaultCamera, LooksStraightAtTheFrontOfAPanel) {
  for (const bool turned : {false, true}) {
    SceneDescription d;
    d.materials.emplace_back();
    if (turned)
      add_quad(d, {0, 0, 0}, {0, 2, 0}, {3, 0, 0});
    else
      add_quad(d, {0, 0, 0}, {3, 0, 0}, {0, 2, 0});
    const Camera camera = Scene(std::move(d)).camera("");
    const Vec3 eye = camera.to_world.translation;
    expect_near({eye.x, eye.y, 0}, {1.5f, 1, 0}, 1e-4f);
    EXPECT_EQ(eye.z > 0, !turned);
  }
}

TEST(StudioLight, LightsObjectsThatGlowButNoRooms) {
  for (const bool room : {false, true}) {
    SceneDescription d = closed_box({{-1, -1, -1}, {1, 1, 1}}, room);
    add_quad(d, {-0.2f, 0.5f, 0}, {0, 0, 0.4f}, {0.4f, 0, 0}, 0, add_emission(d, RGB(1.0f)));
    EXPECT_FALSE(needs_studio_light(d));
    d.emission_may_be_decoration = true;
    EXPECT_EQ(needs_studio_light(d), !room);
    d.emissions[0].radiance.value = RGB(0, 10, 0);
    EXPECT_FALSE(needs_studio_light(d));
    d.emissions[0].radiance.value = RGB(1.0f);
    d.lights.push_back(point_light());
    EXPECT_FALSE(needs_studio_light(d));
  }
}

TEST(StudioLight, ShowsFormAndIsWhiteAtItsBrightest) {
  const Camera front = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45),
               side = look_at({5, 0, 0}, {0, 0, 0}, {0, 1, 0}, 45);
  const auto shade = [](const Environment& e, Vec3 normal) {
    RGB sum;
    constexpr int kSide = 64;
    for (int i = 0; i < kSide * kSide; ++i)
      sum += radiance(e, Frame::from_normal(normal).to_world(
                             square_to_cosine_hemisphere({(static_cast<float>(i % kSide) + 0.5f) / kSide,
                                                          (static_cast<float>(i / kSide) + 0.5f) / kSide}))) /
             (kSide * kSide);
    EXPECT_FLOAT_EQ(sum.r, sum.b);
    return sum.g;
  };
  const Environment light = studio_light(front), from_side = studio_light(side);
  const float left = shade(light, {-1, 0, 0}), right = shade(light, {1, 0, 0}), top = shade(light, {0, 1, 0});
  const float bottom = shade(light, {0, -1, 0}), ahead = shade(light, {0, 0, 1});
  EXPECT_GT(left, 1.3f * right);
  EXPECT_GT(top, 1.3f * left);
  EXPECT_GT(right, 1.3f * bottom);
  for (const float value : {left, right, top, bottom, ahead}) EXPECT_LE(value, 1.0f);
  EXPECT_GT(ahead, 0.5f);
  // Turned with the viewer.
  EXPECT_NEAR(shade(from_side, {1, 0, 0}), ahead, 0.01f);
  EXPECT_NEAR(shade(from_side, {0, 0, 1}), left, 0.01f);
}

TEST(SceneTest, LooksIntoABoxThatIsOpenToOneSide) {
  const Camera camera = Scene(open_box(true)).camera("");
  EXPECT_NEAR(camera.to_world.translation.x, 0, 1e-5f);
  EXPECT_NEAR(camera.to_world.translation.y, 1.5f, 1e-5f);
  EXPECT_GT(camera.to_world.translation.z, 2);
  // The opening fills the picture's height nearly.
  const Vec3 seen = inverse(camera.to_world).point({0, 3, 2});
  EXPECT_LE(std::abs(seen.y) / seen.z, camera.half_extent);
  EXPECT_GE(std::abs(seen.y) / seen.z, 0.9f * camera.half_extent);
}

TEST(SceneTest, LooksAtSolidsFromOutsideAndAtRoomsFromWithin) {
  EXPECT_GT(length(Scene(open_box(false)).camera("").to_world.translation - Vec3{0, 1.5f, 0}), 4);
  SceneDescription room = open_box(true);
  add_quad(room, {-1, 0, 2}, {0, 3, 0}, {2, 0, 0});
  const Scene scene(std::move(room));
  EXPECT_TRUE(scene.bounds().contains(scene.camera("").to_world.translation));
}

TEST(SceneTest, UnknownCameraListsTheCameras) {
  SceneDescription d = lit_floor(LightCase::point);
  for (const char* name : {"front", "back"}) {
    d.cameras.push_back(look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 40));
    d.cameras.back().name = name;
  }
  const Scene scene(std::move(d));
  EXPECT_EQ(scene.camera("").name, "front");
  EXPECT_EQ(scene.camera("back").name, "back");
  try {
    scene.camera("side");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("front, back"), std::string::npos) << error.what();
  }
}

TEST(SceneTest, RejectsInconsistentScenes) {
  const auto refused = [](const std::function<void(SceneDescription&)>& damage) {
    SceneDescription d = lit_floor(LightCase::all);
    damage(d);
    EXPECT_THROW(Scene{std::move(d)}, Error);
  };
  refused([](auto& d) { d.geometry = {}; });
  refused([](auto& d) { d.geometry.material[1] = 9; });
  refused([](auto& d) { d.geometry.emission[1] = 9; });
  refused([](auto& d) { d.geometry.triangles[1][2] = 1000; });
  refused([](auto& d) { d.geometry.normals.pop_back(); });
  refused([](auto& d) { d.geometry.positions[0].x = std::numeric_limits<float>::infinity(); });
  refused([](auto& d) { d.materials[0].reflectance.texture = 9; });
  refused([](auto& d) { d.materials[0].bump.texture = 9; });
  refused([](auto& d) { d.emissions[0].radiance.texture = 9; });
  refused([](auto& d) { d.textures[0].image = nullptr; });
  refused([](auto& d) { d.textures[0].child_a = 0; });
  refused([](auto& d) { d.environment->pixels.pop_back(); });
  refused([](auto& d) { d.lights[1].direction = {0, 0, 0}; });
  refused([](auto& d) {
    d.materials[0].kind = MaterialKind::mix;
    d.materials[0].mix_a = d.materials[0].mix_b = 0;
  });
  refused([](auto& d) {  // each node doubles the cost of the one before
    for (std::uint32_t i = 0; i < 60; ++i) {
      TextureNode node;
      node.kind = TextureKind::scale;
      node.child_a = node.child_b = static_cast<std::uint32_t>(d.textures.size() - 1);
      d.textures.push_back(node);
    }
  });
}

TEST(SurfacePointTest, InterpolatesAndKeepsToItsSide) {
  SceneDescription d = floor_description();
  d.geometry.normals[0] = normalize({1, 0, -1});  // against the winding: turned over
  d.geometry.normals[1] = d.geometry.normals[2] = {0, 0, -1};
  const Scene scene(std::move(d));
  const SurfacePoint p = surface_point(scene, 0, {0.25f, 0.25f});
  expect_near(p.position, {0, -1, 0}, 1e-6f);
  EXPECT_NEAR(p.texture.uv.x, 0.5f, 1e-6f);
  EXPECT_NEAR(p.texture.uv.y, 0.25f, 1e-6f);
  expect_near(p.geometric_normal, {0, 0, 1}, 1e-6f);
  EXPECT_GT(p.frame.n.z, 0.8f);
  EXPECT_LT(p.frame.n.z, 0.999f);
  expect_near(cross(p.frame.s, p.frame.t), p.frame.n, 1e-5f);
  EXPECT_GT(p.frame.s.x, 0.8f);  // along u
}

TEST(SurfacePointTest, DegenerateCoordinatesStillMakeAFrame) {
  for (const Vec2 uv : {Vec2{0, 0}, Vec2{0.5f, 0.5f}, Vec2{1e30f, 1e30f}}) {
    SceneDescription d = floor_description();
    for (Vec2& each : d.geometry.uvs) each = uv;
    d.geometry.uvs[1].x *= 1.0000001f;
    const Scene scene(std::move(d));
    const SurfacePoint p = surface_point(scene, 0, {0.2f, 0.3f});
    EXPECT_NEAR(length(p.frame.s), 1, 1e-5f);
    EXPECT_NEAR(length(p.frame.t), 1, 1e-5f);
    EXPECT_NEAR(dot(p.frame.s, p.frame.n), 0, 1e-5f);
  }
}

Scene with_normal_map(RGB stored, bool mirrored) {
  SceneDescription d = floor_description();
  if (mirrored)
    for (Vec2& uv : d.geometry.uvs) uv.y = 1 - uv.y;
  d.textures.push_back(image_node([stored](Vec2) { return stored; }));
  d.materials[0].normal_map.texture = 0;
  return Scene(std::move(d));
}

TEST(ResolveBsdf, NormalMapTiltsAlongTheTextureAxes) {
  const Vec3 tilted = normalize({0.3f, 0.4f, 0.8f});
  const RGB stored = RGB(tilted.x + 1, tilted.y + 1, tilted.z + 1) / 2;
  for (const bool mirrored : {false, true}) {
    const Scene scene = with_normal_map(stored, mirrored);
    SurfacePoint p = surface_point(scene, 0, {0.2f, 0.3f});
    resolve_bsdf(scene, p);
    expect_near(p.frame.n, {tilted.x, mirrored ? -tilted.y : tilted.y, tilted.z}, 1e-4f);
  }
}

TEST(ResolveBsdf, NormalStaysOnTheSideOfTheSurface) {
  const Scene leaning = with_normal_map(RGB(1, 0.5f, 0.55f), false),
              behind = with_normal_map(RGB(1, 0.5f, 0.4f), false);
  for (const Scene* scene : {&leaning, &behind}) {
    SurfacePoint p = surface_point(*scene, 0, {0.2f, 0.3f});
    resolve_bsdf(*scene, p);
    EXPECT_GT(dot(p.frame.n, p.geometric_normal), 0);
    EXPECT_NEAR(length(p.frame.n), 1, 1e-5f);
    expect_near(cross(p.frame.s, p.frame.t), p.frame.n, 1e-5f);
  }
}

TEST(ResolveBsdf, BumpLeansAgainstTheSlope) {
  SceneDescription d = floor_description();
  d.textures.push_back(image_node([](Vec2 uv) { return RGB(2 * uv.x); }));  // two metres up over four metres of x
  d.materials[0].bump = {1, 0, Channel::red};
  const Scene scene(std::move(d));
  SurfacePoint p = surface_point(scene, 0, {0.2f, 0.3f});
  resolve_bsdf(scene, p);
  expect_near(p.frame.n, normalize({-0.5f, 0, 1}), 1e-3f);
}

TEST(ResolveBsdf, MixChoosesByAmountAndByPlaceAlone) {
  SceneDescription d = floor_description();
  d.materials.resize(3);
  d.materials[0].kind = MaterialKind::mix;
  d.materials[0].mix_a = 1;
  d.materials[0].mix_b = 2;
  d.materials[0].mix_amount.value = 0.3f;
  const Scene scene(std::move(d));
  std::vector<double> observed(2), expected = {14000, 6000};
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const Vec2 where = square_to_triangle(Sampler(SamplerKind::independent, 1, 1, i).next2());
    SurfacePoint p = surface_point(scene, 0, where), again = p;
    resolve_bsdf(scene, p);
    resolve_bsdf(scene, again);
    EXPECT_EQ(p.material, again.material);
    ++observed[p.material - 1];
  }
  expect_fit(chi_squared_counts(observed, expected).p_value, 2, "mix");
}

TEST(EmittedRadiance, IsSeenFromTheFrontUnlessTwoSided) {
  const Scene scene(lit_floor(LightCase::all));
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    const SurfacePoint p = surface_point(scene, triangle, {0.3f, 0.3f});
    const bool two_sided = scene.emissions()[scene.geometry().emission[triangle]].two_sided;
    EXPECT_FALSE(is_black(emitted_radiance(scene, p, p.geometric_normal)));
    EXPECT_EQ(is_black(emitted_radiance(scene, p, -p.geometric_normal)), !two_sided);
  }
  EXPECT_TRUE(is_black(emitted_radiance(scene, surface_point(scene, 0, {0.3f, 0.3f}), {0, 0, 1})));
}

Scene with_alpha(float cutoff) {
  SceneDescription d = floor_description();
  d.textures.push_back(image_node([](Vec2) { return RGB(1.0f); }, [](Vec2 uv) { return uv.x; }));
  d.materials[0].alpha = {1, 0, Channel::alpha};
  d.materials[0].alpha_cutoff = cutoff;
  return Scene(std::move(d));
}

TEST(Alpha, CutoffDividesTheSurface) {
  const Scene scene = with_alpha(0.5f);
  EXPECT_TRUE(scene.has_alpha(0));
  EXPECT_EQ(coverage(scene, 0, texture_point(scene.geometry(), 0, {0.4f, 0})), 0);  // u = 0.4
  EXPECT_EQ(coverage(scene, 0, texture_point(scene.geometry(), 0, {0.6f, 0})), 1);
  EXPECT_FALSE(Scene(floor_description()).has_alpha(0));
}

TEST(Alpha, ChanceHasItsProbabilityAndBelongsToTheRay) {
  const Scene scene = with_alpha(-1);
  const float covered = coverage(scene, 0, texture_point(scene.geometry(), 0, {0.3f, 0}));
  std::vector<double> observed(2), expected = {14000, 6000};
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const Vec3 direction = square_to_sphere(Sampler(SamplerKind::independent, 3, 1, i).next2());
    const bool present = is_present(covered, 0, {1, 2, 3}, direction);
    EXPECT_EQ(is_present(covered, 0, {1, 2, 3}, direction), present);
    ++observed[present];
  }
  expect_fit(chi_squared_counts(observed, expected).p_value, 2, "alpha");
}

TEST(Geometry, KeepsTrianglesOfEverySize) {
  for (const float scale : {1e-6f, 1e-3f, 1.0f, 1e6f, 1e11f}) {
    SceneDescription d;
    d.materials.emplace_back();
    add_quad(d, {0, 0, 0}, {3 * scale, 0, 0}, {0, 4 * scale, 0}, 0, add_emission(d, RGB(1.0f)));
    ASSERT_EQ(d.geometry.triangle_count(), 2u) << scale;
    EXPECT_FLOAT_EQ(d.geometry.area(0) / scale / scale, 6);
    EXPECT_EQ(d.geometry.normal(0), (Vec3{0, 0, 1}));
    const Scene scene(d);
    EXPECT_FLOAT_EQ(surface_point(scene, 0, {0.25f, 0.25f}).geometric_normal.z, 1);
    // Half the solid angle of a hemisphere or less, from above: a density of 1 / (2 pi) or more, and finite.
    const LightSample light = sample_light(scene, {scale, scale, scale}, 0.25f, {0.5f, 0.5f});
    EXPECT_GT(light.pdf, 0.1f) << scale;
    EXPECT_LT(light.pdf, 10) << scale;
  }
}

/// Random triangles: anywhere, of any size and slenderness, some of them upright.
struct AnyTriangle {
  Vec3 corner, e1, e2, normal;

  explicit AnyTriangle(std::uint32_t i) {
    Sampler sampler(SamplerKind::independent, 8, 0, i);
    const float away = std::pow(10.0f, 8 * sampler.next1() - 4), size = std::pow(10.0f, 8 * sampler.next1() - 4);
    corner = square_to_sphere(sampler.next2()) * away;
    e1 = square_to_sphere(sampler.next2()) * size;
    e2 = square_to_sphere(sampler.next2()) * size;
    if (i % 3 == 0) e2 = e1 + e2 * 0.01f;
    if (i % 4 == 0) corner.z = i % 8 ? away : 0, e1.z = e2.z = 0;
    Geometry geometry;
    geometry.positions = {corner, corner + e1, corner + e2};
    geometry.triangles = {{0, 1, 2}};
    normal = geometry.normal(0);
    e1 = geometry.positions[1] - corner;
    e2 = geometry.positions[2] - corner;
  }
  bool has_area() const { return !(normal == Vec3{0, 0, 0}); }
};

TEST(OffsetOrigin, IsOutsideOfItsTriangleForTheTestOfRays) {
  std::size_t tried = 0;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const AnyTriangle t(i);
    if (!t.has_area()) continue;
    const auto offset = static_cast<float>(rounding_offset(t.corner, t.e1, t.e2));
    Sampler sampler(SamplerKind::independent, 9, 0, i);
    for (int k = 0; k < 20; ++k, ++tried) {
      const Vec2 w = square_to_triangle(sampler.next2());
      const Vec3 p = t.corner + t.e1 * w.x + t.e2 * w.y;
      const Vec3 above = offset_origin(p, t.normal, offset), below = offset_origin(p, -t.normal, offset);
      // The height in the plane by which Embree tells the sides, rounded as Embree rounds it.
      const Vec3 scaled = cross(t.e1, t.e2);
      ASSERT_LT(dot(scaled, t.corner - above), 0) << i;
      ASSERT_GT(dot(scaled, t.corner - below), 0) << i;
    }
  }
  EXPECT_GT(tried, 300000u);
}

TEST(OffsetOrigin, IsOfTheRoundingErrorOfTheTriangle) {
  // Upright: a unit in the last place or two, and next to nothing where the plane goes through the origin.
  EXPECT_GE(rounding_offset({3, 4, 100}, {1, 0, 0}, {0, 1, 0}), 0x1p-17);
  EXPECT_LT(rounding_offset({3, 4, 100}, {1, 0, 0}, {0, 1, 0}), 0x1p-16);
  EXPECT_GT(rounding_offset({3, 4, 0}, {1, 0, 0}, {0, 1, 0}), 0);
  EXPECT_LT(rounding_offset({3, 4, 0}, {1, 0, 0}, {0, 1, 0}), 0x1p-23);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const AnyTriangle t(i);
    const double offset = rounding_offset(t.corner, t.e1, t.e2);
    if (!t.has_area()) continue;
    // It scales with the scene, by powers of two to the bit.
    EXPECT_EQ(rounding_offset(t.corner * 0x1p-20f, t.e1 * 0x1p-20f, t.e2 * 0x1p-20f), offset * 0x1p-20);
    EXPECT_EQ(rounding_offset(t.corner * 0x1p+40f, t.e1 * 0x1p+40f, t.e2 * 0x1p+40f), offset * 0x1p+40);
  }
}

std::string refusal_of(const std::function<void(SceneDescription&)>& change) {
  SceneDescription d;
  d.materials.emplace_back();
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  Light light;
  light.name = "lamp";
  light.position = {0, 0, 1};
  d.lights.push_back(light);
  d.cameras.push_back(look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 40));
  d.cameras[0].name = "desk";
  change(d);
  try {
    const Scene scene(std::move(d));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SceneChecks, RejectsValuesBeyondTheRangeOfEmbree) {
  using D = SceneDescription;
  EXPECT_EQ(refusal_of([](D&) {}), "");
  EXPECT_EQ(refusal_of([](D& d) { d.geometry.positions[2] = {1e11f, 1, 0}; }), "");
  EXPECT_THAT(refusal_of([](D& d) {
                d.geometry.positions[2] = {2e12f, 1, 0};
              }),
              HasSubstr("vertex 2 is at (2e+12, 1, 0), but a scene may reach to 1e+12 m only"));
  EXPECT_THAT(refusal_of([](D& d) { d.geometry.positions[2].y = NAN; }), HasSubstr("vertex 2 is at (1, nan, 0)"));
  EXPECT_THAT(refusal_of([](D& d) { d.cameras[0].to_world.translation.z = -3e12f; }),
              HasSubstr("camera \"desk\" is at (0, 0, -3e+12)"));
  EXPECT_THAT(refusal_of([](D& d) { d.cameras[0].lens_radius = 1e30f; }),
              HasSubstr("camera \"desk\" has a lens of 1e+30 m"));
  EXPECT_THAT(refusal_of([](D& d) { d.cameras[0].focal_distance = NAN; }), HasSubstr("a focal distance of nan m"));
  EXPECT_THAT(refusal_of([](D& d) {
                d.cameras[0].half_extent = 1e10f;
                d.cameras[0].window[1] = 1e10f;
              }),
              HasSubstr("a picture plane of 1e+20 m"));
  EXPECT_THAT(refusal_of([](D& d) { d.lights[0].position.x = 1e20f; }),
              HasSubstr("light \"lamp\" is at (1e+20, 0, 1)"));
  EXPECT_THAT(refusal_of([](D& d) {
                for (Vec3& p : d.geometry.positions) p = p * 1e-10f;
              }),
              HasSubstr("m across, but its size must be at least 1e-07 m"));
}

TEST(SceneChecks, InstancesHaveMeshes) {
  EXPECT_THAT(refusal_of([](SceneDescription& d) {
                d.geometry.instances.push_back({Transform(), 7, 0, 0});
              }),
              HasSubstr("instance 0 has an invalid mesh"));
}

TEST(SceneChecks, LightsAreNeitherNegativeNorInfinite) {
  using D = SceneDescription;
  EXPECT_THAT(refusal_of([](D& d) {
                d.lights[0].intensity = {-1, -2, -3};
              }),
              HasSubstr("light \"lamp\" is negative: (-1, -2, -3)"));
  // The colour of a spectral line.
  EXPECT_EQ(refusal_of([](D& d) { d.lights[0].intensity = {-0.2f, 1, 0}; }), "");
  EXPECT_THAT(refusal_of([](D& d) { d.lights[0].intensity = RGB(1e31f); }), HasSubstr("is brighter than 1e+30"));
  EXPECT_THAT(refusal_of([](D& d) { d.lights[0].intensity.g = INFINITY; }), HasSubstr("not finite: (1, inf, 1)"));
  EXPECT_THAT(refusal_of([](D& d) {
                d.emissions.push_back({"tube", {RGB(-1.0f)}, false, nullptr});
              }),
              HasSubstr("emission \"tube\" is negative"));
  EXPECT_THAT(refusal_of([](D& d) {
                d.environment.emplace();
                d.environment->name = "sky";
                d.environment->scale = RGB(-1.0f);
              }),
              HasSubstr("environment \"sky\" is negative"));
  EXPECT_THAT(refusal_of([](D& d) { d.film.scale = 1e20f; }), HasSubstr("the film multiplies radiance by 1e+20"));
  // Within bounds by themselves, but not over the area.
  EXPECT_THAT(refusal_of([](D& d) {
                for (Vec3& p : d.geometry.positions) p = p * 1e9f;
                d.lights[0].kind = LightKind::directional;
                d.lights[0].intensity = RGB(1e30f);
              }),
              HasSubstr("a light has a power of"));
}

TEST(SceneChecks, LightsAreWithinTheRangeOfPictures) {
  const auto refusal_of_tube = [](float radiance) {
    return refusal_of([&](SceneDescription& d) {
      d.lights.clear();
      d.emissions.push_back({"tube", {RGB(radiance)}, false, nullptr});
      d.geometry.emission.assign(d.geometry.triangles.size(), 0);
    });
  };
  EXPECT_EQ(refusal_of_tube(2.7e11f), "");
  EXPECT_THAT(refusal_of_tube(6e12f), HasSubstr("emission \"tube\" is brighter than 2.74878e+11"));
  EXPECT_EQ(refusal_of_tube(1e-12f), "");
  EXPECT_THAT(refusal_of_tube(1e-38f), HasSubstr("the brightest light has 1e-38 W sr^-1 m^-2"));
  EXPECT_EQ(refusal_of([](SceneDescription& d) { d.lights[0].intensity = RGB(1e-11f); }), "");
  EXPECT_THAT(refusal_of([](SceneDescription& d) { d.lights[0].intensity = RGB(1e-38f); }),
              HasSubstr("the brightest light has"));
}

TEST(SceneChecks, EditsAreCheckedToo) {
  SceneDescription d;
  d.materials.emplace_back();
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  d.lights.emplace_back();
  const Scene scene(std::move(d));
  SceneEdit edit{scene.emissions(), scene.lights(), scene.environment(), nullptr, {}, ""};
  edit.lights[0].intensity = RGB(-1.0f);
  EXPECT_THROW(Scene(scene, edit), Error);
  edit.lights = scene.lights();
  edit.more_cameras.push_back(look_at({1e19f, 0, 0}, {0, 0, 0}, {0, 1, 0}, 40));
  EXPECT_THROW(Scene(scene, edit), Error);
}

TEST(Scene, FindsPanesInMixesOfAnyDepth) {
  SceneDescription d = floor_description();
  const auto mix_of = [&](std::uint32_t a, std::uint32_t b) {
    Material m;
    m.kind = MaterialKind::mix;
    m.mix_a = a;
    m.mix_b = b;
    d.materials.push_back(m);
  };
  // Each mixes the one before with itself: 2^80 ways lead to the first.
  for (std::uint32_t i = 0; i < 80; ++i) mix_of(i, i);
  Material pane;
  pane.kind = MaterialKind::thin_dielectric;
  d.materials.push_back(pane);
  mix_of(83, 0);
  mix_of(81, 0);
  const Scene scene(std::move(d));
  for (std::uint32_t i = 0; i <= 80; ++i) EXPECT_FALSE(scene.is_pane(i));
  for (std::uint32_t i = 81; i <= 83; ++i) EXPECT_TRUE(scene.is_pane(i));
}

}  // namespace
}  // namespace glowworm
