// Geometry, textures, cameras and the environment's image.
#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/environment.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Geometry small_mesh() {
  Geometry mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNaN, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(AppendMesh, DropsTrianglesWithoutAreaOrNotFinite) {
  Geometry mesh = small_mesh();
  mesh.triangles = {{0, 1, 2}, {0, 1, 4}, {1, 1, 2}, {0, 1, 3}};
  Geometry g;
  const AppendResult result = append_mesh(g, mesh, "mesh", 7, kNone);
  EXPECT_EQ(result.degenerate, 2u);
  EXPECT_EQ(result.not_finite, 1u);
  ASSERT_EQ(g.triangle_count(), 1u);
  EXPECT_EQ(g.material, std::vector<std::uint32_t>{7});
  EXPECT_EQ(g.emission, std::vector<std::uint32_t>{kNone});
  EXPECT_EQ(g.positions.size(), 3u);  // vertices of dropped triangles stay out of the bounds
  EXPECT_EQ(g.normals.size(), 3u);
  EXPECT_EQ(g.uvs.size(), 3u);
}

TEST(AppendMesh, JoinsMeshes) {
  Geometry g, mesh = small_mesh();
  mesh.normals.assign(mesh.positions.size(), {0, 0, 5});
  mesh.normals[1] = {kNaN, 0, 0};
  mesh.uvs.assign(mesh.positions.size(), {0.25f, kNaN});
  mesh.material = {3};
  mesh.emission = {4};
  append_mesh(g, mesh, "a", 0, kNone);
  append_mesh(g, mesh, "b", 0, kNone);
  ASSERT_EQ(g.triangle_count(), 2u);
  EXPECT_EQ(g.triangles[1], (std::array<std::uint32_t, 3>{3, 4, 5}));
  EXPECT_EQ(g.material[1], 3u);
  EXPECT_EQ(g.emission[1], 4u);
  EXPECT_EQ(g.normals[3], (Vec3{0, 0, 1}));
  EXPECT_EQ(g.normals[4], (Vec3{0, 0, 0}));
  EXPECT_EQ(g.uvs[3].x, 0);
}

TEST(AppendMesh, NamesTheMeshOfAnIndexOutOfRange) {
  Geometry g, mesh = small_mesh();
  mesh.triangles.push_back({0, 1, 99});
  try {
    append_mesh(g, mesh, "teapot", 0, kNone);
    FAIL() << "accepted vertex 99";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("teapot"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("99"), std::string::npos) << error.what();
  }
  mesh = small_mesh();
  mesh.uvs.resize(2);
  EXPECT_THROW(append_mesh(g, mesh, "teapot", 0, kNone), Error);
  EXPECT_EQ(g.triangle_count(), 0u);
}

TextureNode node_of(TextureKind kind, RGB value = RGB(1.0f)) {
  TextureNode node;
  node.kind = kind;
  node.value = value;
  return node;
}

TEST(Texture, CoordinatesAreTurnedThenScaledThenMoved) {
  TextureNode node = image_node([](Vec2 uv) { return RGB(uv.x, uv.y, 0); });
  node.uv_rotation = kPi / 2;
  node.uv_scale = {2, 3};
  node.uv_offset = {0.5f, -0.25f};
  const RGB c = evaluate({node}, 0, Vec2{0.25f, 0.75f});  // turned: (-0.75, 0.25)
  EXPECT_NEAR(c.r, 2 * -0.75f + 0.5f, 1e-6f);
  EXPECT_NEAR(c.g, 3 * 0.25f - 0.25f, 1e-6f);
}

TEST(Texture, ImageIsInvertedAfterItsFactor) {
  TextureNode node = image_node([](Vec2) { return RGB(0.25f, 0.5f, 1); });
  node.value = RGB(2.0f);
  EXPECT_EQ(evaluate({node}, 0, {}), RGB(0.5f, 1, 2));
  node.invert = true;
  EXPECT_EQ(evaluate({node}, 0, {}), RGB(0.5f, 0, 0));
}

TEST(Texture, ImageMayShowItsAlpha) {
  TextureNode node = image_node([](Vec2) { return RGB(0.1f, 0.2f, 0.3f); }, [](Vec2) { return 0.75f; });
  node.from_alpha = true;
  node.value = RGB(0.5f);
  EXPECT_EQ(evaluate({node}, 0, {}), RGB(0.375f));
  node.invert = true;
  EXPECT_EQ(evaluate({node}, 0, {}), RGB(0.625f));
}

TEST(Texture, NodesCombine) {
  std::vector<TextureNode> nodes = {node_of(TextureKind::constant, RGB(1, 2, 4)),
                                    node_of(TextureKind::constant, RGB(3, 0, 8)),
                                    node_of(TextureKind::constant, RGB(0.25f)),
                                    node_of(TextureKind::scale),
                                    node_of(TextureKind::mix),
                                    node_of(TextureKind::checkerboard)};
  for (std::size_t i = 3; i < nodes.size(); ++i) {
    nodes[i].child_a = 0;
    nodes[i].child_b = 1;
    nodes[i].child_amount = 2;
  }
  EXPECT_EQ(evaluate(nodes, 3, {}), RGB(3, 0, 32));
  EXPECT_EQ(evaluate(nodes, 4, {}), RGB(1.5f, 1.5f, 5));
  for (const float x : {-1.5f, -0.5f, 0.5f, 1.5f, 1000000.5f})
    for (const float y : {-0.5f, 0.5f}) {
      const bool odd = static_cast<long>(std::floor(x) + std::floor(y)) % 2 != 0;
      EXPECT_EQ(evaluate(nodes, 5, Vec2{x, y}), odd ? nodes[1].value : nodes[0].value) << x << " " << y;
    }
}

TEST(Texture, InputsMultiplyTheirChannel) {
  const std::vector<TextureNode> nodes = {
      image_node([](Vec2) { return RGB(0.3f, 0.6f, 0.9f); }, [](Vec2 uv) { return uv.x; })};
  EXPECT_EQ(evaluate(nodes, ColorInput{RGB(1, 2, 3), kNone}, {}), RGB(1, 2, 3));
  EXPECT_EQ(evaluate(nodes, ColorInput{RGB(1, 2, 3), 0}, {}), RGB(1, 2, 3) * RGB(0.3f, 0.6f, 0.9f));
  const float expected[] = {0.6f, 0.3f, 0.6f, 0.9f, 0.75f};
  for (int channel = 0; channel < 5; ++channel)
    EXPECT_NEAR(evaluate(nodes, FloatInput{2, 0, static_cast<Channel>(channel)}, Vec2{0.75f, 0}), 2 * expected[channel],
                1e-6f);
  EXPECT_EQ(evaluate(nodes, FloatInput{2, kNone, Channel::alpha}, {}), 2);
}

TEST(Camera, LooksAtItsTarget) {
  const Vec3 eye = {1, 2, 3}, target = {4, 0, -2};
  const Camera camera = look_at(eye, target, {0, 1, 0}, 40);
  const CameraRay ray = generate_ray(camera, {320, 240}, 640, 480, {0.1f, 0.9f});
  expect_near(ray.origin, eye, 1e-6f);
  expect_near(ray.direction, normalize(target - eye), 1e-5f);
  // Right of the picture is right of the way, and its top is up.
  const Vec3 right = cross(target - eye, {0, 1, 0});
  EXPECT_GT(dot(generate_ray(camera, {640, 240}, 640, 480, {}).direction, right), 0);
  EXPECT_GT(generate_ray(camera, {320, 0}, 640, 480, {}).direction.y,
            generate_ray(camera, {320, 480}, 640, 480, {}).direction.y);
}

TEST(Camera, FieldOfViewSpansTheShorterSide) {
  const Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 50);
  const auto angle = [&](Vec2 a, Vec2 b, int width, int height) {
    return std::acos(dot(generate_ray(camera, a, width, height, {}).direction,
                         generate_ray(camera, b, width, height, {}).direction));
  };
  EXPECT_NEAR(angle({200, 0}, {200, 100}, 400, 100), 50 * kPi / 180, 1e-4f);
  EXPECT_NEAR(angle({0, 200}, {100, 200}, 100, 400), 50 * kPi / 180, 1e-4f);
  // The longer side: tan of its half is four times as large.
  EXPECT_NEAR(std::tan(angle({0, 50}, {400, 50}, 400, 100) / 2), 4 * std::tan(25 * kPi / 180), 1e-3f);
}

TEST(Camera, MirroredWorldMirrorsThePicture) {
  Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 50);
  const Vec3 plain = generate_ray(camera, {10, 20}, 100, 100, {}).direction;
  camera.to_world.x = -camera.to_world.x;
  const Vec3 mirrored = generate_ray(camera, {10, 20}, 100, 100, {}).direction;
  expect_near(mirrored, {-plain.x, plain.y, plain.z}, 1e-6f);
}

TEST(Camera, ScreenWindowAndOrthographic) {
  Camera camera = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 90);
  camera.kind = CameraKind::orthographic;
  camera.half_extent = 2;
  const float window[4] = {0, 3, -1, 1};
  std::copy(window, window + 4, camera.window);
  expect_near(generate_ray(camera, {0, 100}, 200, 100, {}).origin, {0, -2, 5}, 1e-5f);
  expect_near(generate_ray(camera, {200, 0}, 200, 100, {}).origin, {6, 2, 5}, 1e-5f);
  expect_near(generate_ray(camera, {200, 0}, 200, 100, {}).direction, {0, 0, -1}, 1e-6f);
}

TEST(Camera, FisheyesAndPanoramasMapAngles) {
  Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 50);
  const auto towards = [&](Vec2 film) { return generate_ray(camera, film, 200, 200, {}).direction; };
  camera.kind = CameraKind::fisheye;
  camera.half_extent = half_extent_of(camera.kind, 180);
  const float half = std::sqrt(0.5f);
  expect_near(towards({150, 100}), {half, 0, -half}, 1e-6f);
  expect_near(towards({100, 0}), {0, 1, 0}, 1e-6f);
  EXPECT_LT(dot(towards({0, 0}), {0, 0, -1}), -0.6f) << "corners look 127 degrees away";
  camera.kind = CameraKind::hemispherical;
  camera.half_extent = half_extent_of(camera.kind, 180);
  expect_near(towards({150, 100}), {0.5f, 0, -std::sqrt(0.75f)}, 1e-6f);
  EXPECT_TRUE(generate_ray(camera, {1, 1}, 200, 200, {}).is_blind());
  camera.kind = CameraKind::panorama;
  camera.half_extent = half_extent_of(camera.kind, 180);
  const auto seen = [&](Vec2 film) { return generate_ray(camera, film, 400, 200, {}).direction; };
  expect_near(seen({300, 100}), {1, 0, 0}, 1e-6f);
  expect_near(seen({200, 50}), {0, half, -half}, 1e-6f);
  expect_near(seen({1e-3f, 100}), {0, 0, 1}, 1e-4f);
}

TEST(Camera, AngularPicturesShowTheirSolidAngles) {
  constexpr int kSide = 400;
  const struct {
    CameraKind kind;
    double half, expected;  // of the plane; steradians
  } kCases[] = {{CameraKind::fisheye, M_PI, 4 * M_PI},
                {CameraKind::hemispherical, 1, 2 * M_PI},
                {CameraKind::panorama, M_PI, 4 * M_PI}};
  for (const auto& [kind, half, expected] : kCases) {
    double sum = 0;
    const double step = 2 * half / kSide;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const Vec2 plane{static_cast<float>((x + 0.5) * step - half), static_cast<float>((y + 0.5) * step - half)};
        sum += solid_angle_density(kind, plane) * step * step;
        const Vec3 d = angular_direction(kind, plane);
        if (CameraRay{{}, d}.is_blind()) continue;
        const Vec2 back = angular_plane(kind, d);
        ASSERT_LT(std::hypot(back.x - plane.x, back.y - plane.y), 1e-3f);
      }
    EXPECT_NEAR(sum / expected, 1, 0.02);
  }
}

TEST(Camera, LensFocusesOnItsPlane) {
  Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 50);
  camera.to_world.x *= 3.0f;  // lengths stay metres in a scaled space
  camera.to_world.y *= 3.0f;
  camera.to_world.z *= 3.0f;
  camera.lens_radius = 0.2f;
  camera.focal_distance = 4;
  const CameraRay centre = generate_ray(camera, {30, 60}, 100, 100, {0.5f, 0.5f});
  const Vec3 focus = centre.direction * (-4 / centre.direction.z);
  float widest = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const CameraRay ray = generate_ray(camera, {30, 60}, 100, 100, Sampler(SamplerKind::sobol, 1, 2, i).next2());
    expect_near(ray.origin + ray.direction * ((-4 - ray.origin.z) / ray.direction.z), focus, 1e-4f);
    widest = std::max(widest, length(ray.origin));
  }
  EXPECT_LE(widest, 0.2f + 1e-6f);
  EXPECT_GT(widest, 0.19f);
}

TEST(Environment, CoordinatesUndoDirections) {
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    const Environment e = image_environment(mapping);
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const Vec2 uv = Sampler(SamplerKind::sobol, 5, 0, i).next2();
      const Vec3 direction = environment_direction(e, uv);
      EXPECT_NEAR(length(direction), 1, 1e-6f);
      expect_near(environment_direction(e, environment_coordinates(e, direction)), direction, 2e-5f);
    }
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
      for (const float sign : {1.0f, -1.0f})
        expect_near(environment_direction(e, environment_coordinates(e, axis * sign)), axis * sign, 1e-5f);
  }
}

TEST(Environment, LatLongLooksAlongMinusZInItsMiddle) {
  const Environment e;
  expect_near(environment_direction(e, {0.5f, 0.5f}), {0, 0, -1}, 1e-6f);
  expect_near(environment_direction(e, {0.75f, 0.5f}), {1, 0, 0}, 1e-6f);
  expect_near(environment_direction(e, {0.5f, 0}), {0, 1, 0}, 1e-6f);
}

TEST(Environment, EqualAreaHasItsPolesInTheMiddleAndTheCorners) {
  Environment e;
  e.mapping = EnvironmentMapping::equal_area;
  expect_near(environment_direction(e, {0.5f, 0.5f}), {0, 0, 1}, 1e-6f);
  expect_near(environment_direction(e, {1, 0.5f}), {1, 0, 0}, 1e-6f);
  expect_near(environment_direction(e, {0.5f, 1}), {0, 1, 0}, 1e-6f);
  expect_near(environment_direction(e, {0, 0}), {0, 0, -1}, 1e-6f);
}

TEST(Environment, IntegralOfWhiteIsTheWholeSphere) {
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    Environment e = image_environment(mapping);
    for (RGB& texel : e.pixels) texel = RGB(1.0f);
    EXPECT_NEAR(environment_integral(e).r / e.scale.r, 4 * kPi, 1e-4f);
  }
}

/// Radiance at a point given in texels, from the image's upper left corner.
RGB radiance_at(const Environment& e, float x, float y) {
  return radiance(e, environment_direction(e, {x / static_cast<float>(e.width), y / static_cast<float>(e.height)}));
}

void expect_close(RGB a, RGB b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-3f);
}

TEST(Environment, InterpolatesBetweenTheCentresOfTexels) {
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    const Environment e = image_environment(mapping);
    const RGB here = e.scale * e.pixels[2 * e.width + 5], right = e.scale * e.pixels[2 * e.width + 6];
    const RGB above = e.scale * e.pixels[e.width + 5], across = e.scale * e.pixels[e.width + 6];
    expect_close(radiance_at(e, 5.5f, 2.5f), here);
    expect_close(radiance_at(e, 5.75f, 2.5f), here * 0.75f + right * 0.25f);
    expect_close(radiance_at(e, 6, 2), (here + right + above + across) * 0.25f);
  }
}

TEST(Environment, IsContinuousAcrossTheEdgesOfItsImage) {
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    const Environment e = image_environment(mapping);
    const auto size = static_cast<float>(e.height);
    for (std::uint32_t i = 0; i < 200; ++i) {
      const float v = Sampler(SamplerKind::sobol, 5, 0, i).next2().x * size, tiny = 1e-4f;
      if (mapping == EnvironmentMapping::lat_long) {
        expect_close(radiance_at(e, tiny, v), radiance_at(e, static_cast<float>(e.width) - tiny, v));
      } else {
        expect_close(radiance_at(e, tiny, v), radiance_at(e, tiny, size - v));
        expect_close(radiance_at(e, v, tiny), radiance_at(e, size - v, tiny));
      }
    }
  }
}

TEST(Environment, IntegralIsThatOfTheInterpolatedImage) {
  constexpr int kSide = 512;
  for (const auto mapping : {EnvironmentMapping::lat_long, EnvironmentMapping::equal_area}) {
    const Environment e = image_environment(mapping);
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec3 d = square_to_sphere(
          {(static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide});
      const RGB value = radiance(e, d);
      for (int c = 0; c < 3; ++c) sum[c] += value[c] * 4 * kPi / (kSide * kSide);
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(environment_integral(e)[c] / sum[c], 1, 1e-3);
  }
}

}  // namespace
}  // namespace glowworm
