#include "scene/studio_light.h"

#include <algorithm>
#include <cmath>

#include "scene/default_camera.h"
#include "scene/environment.h"

namespace glowworm {

namespace {

constexpr int kHeight = 64;
/// The maximum in glTF without KHR_materials_emissive_strength; a file that uses that extension means light.
constexpr float kBrightestDecoration = 1;
constexpr float kAbove = 0.35f, kBelow = 0.12f;  ///< radiance of the room, against a key of 1

/// A soft lamp: radiance exp(sharpness (cos - 1)) around its centre.
struct Lamp {
  Vec3 direction;  ///< with the viewer at +z
  float radiance, sharpness;
};
const Lamp kLamps[] = {{{-0.55f, 0.75f, 0.6f}, 4.0f, 7}, {{0.9f, 0.25f, 0.5f}, 0.8f, 4}};

float studio_radiance(Vec3 d) {
  float sum = kBelow + (kAbove - kBelow) * (0.5f + 0.5f * d.y);
  for (const Lamp& lamp : kLamps)
    sum += lamp.radiance * std::exp(lamp.sharpness * (dot(d, normalize(lamp.direction)) - 1));
  return sum;
}

}  // namespace

Environment studio_light(const Camera& camera) {
  Environment e;
  e.name = "studio light";
  e.stands_in = true;
  e.width = 2 * kHeight;
  e.height = kHeight;
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < e.width; ++x)
      e.pixels.emplace_back(
          studio_radiance(environment_direction(e, {(static_cast<float>(x) + 0.5f) / static_cast<float>(e.width),
                                                    (static_cast<float>(y) + 0.5f) / static_cast<float>(e.height)})));
  // Irradiance of a surface that faces the key light, computed from the image.
  const Vec3 key = normalize(kLamps[0].direction);
  constexpr int kSide = 64;
  double irradiance = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const float z = 1 - 2 * (static_cast<float>(i / kSide) + 0.5f) / kSide;
    const float phi = 2 * kPi * (static_cast<float>(i % kSide) + 0.5f) / kSide, r = std::sqrt(1 - z * z);
    const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
    irradiance += std::max(0.0f, dot(d, key)) * radiance(e, d).g * 4 * kPi / (kSide * kSide);
  }
  e.scale = RGB(kPi / static_cast<float>(irradiance));
  // The viewer's horizontal direction. If the camera looks straight down, the key light is still at its upper left.
  const Vec3 back = camera.to_world.z * -1.0f, up = camera.to_world.y;
  Vec3 side = back.x * back.x + back.z * back.z > 1e-4f ? Vec3{back.x, 0, back.z} : Vec3{-up.x, 0, -up.z};
  side = length(side) > 0 ? normalize(side) : Vec3{0, 0, 1};
  e.to_world = {cross({0, 1, 0}, side), {0, 1, 0}, side, {0, 0, 0}};
  return e;
}

bool needs_studio_light(const SceneDescription& scene) {
  if (!scene.lights.empty() || scene.environment) return false;
  if (std::any_of(scene.media.begin(), scene.media.end(), emits)) return false;
  if (scene.emissions.empty()) return true;
  if (!scene.emission_may_be_decoration) return false;
  for (const Emission& emission : scene.emissions)
    if (const RGB l = emission.radiance.value;
        emission.radiance.texture == kNone && std::max({l.r, l.g, l.b}) > kBrightestDecoration)
      return false;
  const SceneShape shape = shape_of(scene.geometry);
  return shape == SceneShape::object || shape == SceneShape::panel;
}

}  // namespace glowworm
