#include "scene/light_power.h"

#include <algorithm>
#include <cmath>

#include "core/warp.h"

namespace glowworm {

namespace {
/// Points of a triangle, along each of two axes, at which a textured emission is read.
constexpr int kGrid = 6;
}  // namespace

RGB mean_radiance(const Geometry& g, const SceneDescription& scene, std::uint32_t triangle) {
  const ColorInput& input = scene.emissions[g.emission[triangle]].radiance;
  if (input.texture == kNone) return input.value;
  const auto& [a, b, c] = g.triangles[triangle];
  RGB sum;
  for (int y = 0; y < kGrid; ++y)
    for (int x = 0; x < kGrid; ++x) {
      const Vec2 w = square_to_triangle({(x + 0.5f) / kGrid, (y + 0.5f) / kGrid});
      sum += evaluate(scene.textures, input, g.uvs[a] * (1 - w.x - w.y) + g.uvs[b] * w.x + g.uvs[c] * w.y);
    }
  // What the grid misses must still have a chance to be found, or it would be lost to sampling altogether.
  const RGB mean = sum / (kGrid * kGrid), floor = input.value * 1e-3f;
  return {std::max(mean.r, floor.r), std::max(mean.g, floor.g), std::max(mean.b, floor.b)};
}

RGB triangle_power(const Geometry& g, const SceneDescription& scene, std::uint32_t triangle) {
  const float sides = scene.emissions[g.emission[triangle]].two_sided ? 2.0f : 1.0f;
  return mean_radiance(g, scene, triangle) * (kPi * g.area(triangle) * sides);
}

RGB light_power(const Light& light, float scene_radius) {
  switch (light.kind) {
    case LightKind::point:
      return light.intensity * (4 * kPi);
    case LightKind::spot:
      return light.intensity *
             (2 * kPi * ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) * mean_spot_falloff(light)));
    case LightKind::directional:
      return light.intensity * (kPi * scene_radius * scene_radius);
  }
  return RGB(0.0f);
}

float spot_falloff(const Light& light, float cos_theta) {
  if (cos_theta >= light.cos_inner) return 1;
  if (cos_theta <= light.cos_outer) return 0;
  const float t = (cos_theta - light.cos_outer) / (light.cos_inner - light.cos_outer);
  return light.gltf_falloff ? t * t : t * t * (3 - 2 * t);
}

}  // namespace glowworm
