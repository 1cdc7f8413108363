// Building blocks for tests of scenes.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "scene/scene.h"

namespace glowworm {

inline void expect_near(Vec3 a, Vec3 b, float tolerance) { EXPECT_LT(length(a - b), tolerance); }

/// An image made from a function of the texture coordinates.
class FunctionImage : public TextureImage {
 public:
  explicit FunctionImage(std::function<RGB(Vec2)> color, std::function<float(Vec2)> alpha = nullptr)
      : color_(std::move(color)), alpha_(std::move(alpha)) {}
  RGB color(Vec2 uv) const override { return color_(uv); }
  float alpha(Vec2 uv) const override { return alpha_ ? alpha_(uv) : 1.0f; }
  bool has_alpha() const override { return alpha_ != nullptr; }
  int width() const override { return 64; }
  int height() const override { return 64; }

 private:
  std::function<RGB(Vec2)> color_;
  std::function<float(Vec2)> alpha_;
};

inline TextureNode image_node(std::function<RGB(Vec2)> color, std::function<float(Vec2)> alpha = nullptr) {
  TextureNode node;
  node.kind = TextureKind::image;
  node.image = std::make_shared<FunctionImage>(std::move(color), std::move(alpha));
  return node;
}

/// Adds the parallelogram corner, corner + x, corner + x + y, corner + y; its front is on the side of x cross y, and
/// (u, v) run from 0 to 1 along x and y.
inline void add_quad(SceneDescription& d, Vec3 corner, Vec3 x, Vec3 y, std::uint32_t material = 0,
                     std::uint32_t emission = kNone) {
  Geometry quad;
  quad.positions = {corner, corner + x, corner + x + y, corner + y};
  quad.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  quad.triangles = {{0, 1, 2}, {0, 2, 3}};
  append_mesh(d.geometry, quad, "quad", material, emission);
}

/// Moves all that has a position.
inline void translate(SceneDescription& d, Vec3 by) {
  for (Vec3& p : d.geometry.positions) p += by;
  for (Light& light : d.lights) light.position += by;
  for (Camera& camera : d.cameras) camera.to_world.translation += by;
}

/// A place so far away that a scene of a few metres is moved to the origin.
inline constexpr Vec3 kFarAway{300'001.3f, -200'002.7f, 250'003.1f};

/// A square floor at z = 0, four metres wide around the origin, facing +z, and no light.
inline SceneDescription floor_description() {
  SceneDescription d;
  d.name = "floor";
  d.materials.emplace_back();
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  return d;
}

inline std::uint32_t add_emission(SceneDescription& d, RGB radiance, bool two_sided = false,
                                  std::uint32_t texture = kNone) {
  Emission emission;
  emission.radiance = {radiance, texture};
  emission.two_sided = two_sided;
  d.emissions.push_back(emission);
  return static_cast<std::uint32_t>(d.emissions.size() - 1);
}

/// A ceiling panel that faces down, one by two metres, off centre.
inline void add_panel(SceneDescription& d, float height, std::uint32_t emission) {
  add_quad(d, {-0.25f, -0.5f, height}, {0, 2, 0}, {1, 0, 0}, 0, emission);
}

inline Light spot_light(SpotFalloff falloff) {
  Light light;
  light.kind = LightKind::spot;
  light.intensity = RGB(30, 20, 10);
  light.position = {0.3f, -0.2f, 1.5f};
  light.direction = normalize({0.2f, 0.3f, -1});
  light.cos_inner = std::cos(0.3f);
  light.cos_outer = std::cos(0.7f);
  light.falloff = falloff;
  return light;
}

inline Light point_light() {
  Light light;
  light.intensity = RGB(3, 5, 7);
  light.position = {0.5f, 0.25f, 1};
  return light;
}

inline Light sun_light() {
  Light light;
  light.kind = LightKind::directional;
  light.intensity = RGB(4, 3, 2);
  light.direction = normalize({0.5f, -0.25f, -1});
  return light;
}

/// A luminaire of uneven intensity, the same on both sides, which aims askew. @param pole of its table
inline Light luminaire(TablePole pole) {
  Light light;
  light.kind = LightKind::luminaire;
  light.intensity = RGB(0.3f, 0.2f, 0.1f);
  light.position = {-0.4f, 0.3f, 1.2f};
  light.direction = normalize({0.1f, -0.3f, -1});
  light.right = {1, 0.5f, 0};
  const bool all_around = pole == TablePole::forward;
  light.table = std::make_shared<const IntensityTable>(
      pole,
      all_around ? std::vector<float>{0, 1.2f, kPi, 2 * kPi - 1.2f, 2 * kPi}
                 : std::vector<float>{-1, -0.2f, 1, 1.5f, 1.6f},
      std::vector<float>{0, 0.4f, 1.5f, 2.2f},
      std::vector<float>{50, 60, 20, 0, 50, 30, 40, 10, 50, 10, 0, 0, 50, 30, 40, 10, 50, 60, 20, 0});
  return light;
}

/// A small uneven image, some of it black, with a bright texel.
inline Environment image_environment(EnvironmentMapping mapping) {
  Environment e;
  e.mapping = mapping;
  e.width = 8;
  e.height = mapping == EnvironmentMapping::lat_long ? 4 : 8;
  for (int i = 0; i < e.width * e.height; ++i)
    e.pixels.push_back(i % 5 == 3 ? RGB(0.0f) : RGB(0.2f + 0.1f * (i % 7), 0.5f, 0.1f * (i % 3)));
  e.pixels[e.width + 1] = RGB(9, 8, 7);
  e.scale = RGB(2, 1, 0.5f);
  const float c = std::cos(0.4f), s = std::sin(0.4f);
  e.to_world = {{c, 0, s}, {0, 1, 0}, {-s, 0, c}, {0, 0, 0}};
  return e;
}

/// A light that the tests go through, by its number.
enum class LightCase {
  panel,
  two_sided,
  textured,
  point,
  spot,
  gltf_spot,
  quartic_spot,
  sun,
  luminaire,
  luminaire_up,
  luminaire_right,
  sky,
  lat_long,
  equal_area,
  all,
  count_
};

inline const char* light_case_name(LightCase c) {
  static constexpr const char* names[] = {"panel",           "two_sided",    "textured", "point",      "spot",
                                          "gltf_spot",       "quartic_spot", "sun",      "luminaire",  "luminaire_up",
                                          "luminaire_right", "sky",          "lat_long", "equal_area", "all"};
  return names[static_cast<int>(c)];
}

inline std::vector<LightCase> light_cases() {
  std::vector<LightCase> cases;
  for (int i = 0; i < static_cast<int>(LightCase::count_); ++i) cases.push_back(static_cast<LightCase>(i));
  return cases;
}

/// The spots among them, with their falloff.
inline constexpr std::pair<LightCase, SpotFalloff> kSpotCases[] = {{LightCase::spot, SpotFalloff::smoothstep},
                                                                   {LightCase::gltf_spot, SpotFalloff::quadratic},
                                                                   {LightCase::quartic_spot, SpotFalloff::quartic}};

/// The floor under the light of a case.
inline SceneDescription lit_floor(LightCase light) {
  SceneDescription d = floor_description();
  const bool all = light == LightCase::all;
  if (light == LightCase::panel || all) add_panel(d, 2, add_emission(d, RGB(5, 4, 3)));
  if (light == LightCase::two_sided || all)
    add_quad(d, {1, -1, 0.5f}, {0, 1.5f, 0}, {0.2f, 0, 1}, 0, add_emission(d, RGB(1, 2, 3), true));
  if (light == LightCase::textured || all) {
    d.textures.push_back(image_node([](Vec2 uv) { return RGB(uv.x, uv.y * uv.y, uv.x > 0.5f ? 1.0f : 0.1f); }));
    add_panel(d, 1.75f, add_emission(d, RGB(6.0f), false, static_cast<std::uint32_t>(d.textures.size() - 1)));
  }
  if (light == LightCase::point || all) d.lights.push_back(point_light());
  if (light == LightCase::spot || all) d.lights.push_back(spot_light(SpotFalloff::smoothstep));
  if (light == LightCase::gltf_spot) d.lights.push_back(spot_light(SpotFalloff::quadratic));
  if (light == LightCase::quartic_spot) d.lights.push_back(spot_light(SpotFalloff::quartic));
  if (light == LightCase::sun || all) d.lights.push_back(sun_light());
  if (light == LightCase::luminaire || all) d.lights.push_back(luminaire(TablePole::forward));
  if (light == LightCase::luminaire_up) d.lights.push_back(luminaire(TablePole::up));
  if (light == LightCase::luminaire_right) d.lights.push_back(luminaire(TablePole::right));
  if (light == LightCase::sky) {
    d.environment = Environment{};
    d.environment->scale = RGB(1, 2, 3);
  }
  if (light == LightCase::lat_long || all) d.environment = image_environment(EnvironmentMapping::lat_long);
  if (light == LightCase::equal_area) d.environment = image_environment(EnvironmentMapping::equal_area);
  return d;
}

}  // namespace glowworm
