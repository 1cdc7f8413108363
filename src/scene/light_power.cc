#include "scene/light_power.h"

#include <algorithm>
#include <cmath>

#include "core/warp.h"

namespace glowworm {

namespace {
/// Parts of a triangle's edge between the points at which a textured emission is read: one to a texel, within bounds.
constexpr int kFewestParts = 6, kMostParts = 256;

/// Parts of each edge that make steps of a texel; kMostParts + 1 where there would be more than that, or where there
/// are no texels to go by.
int parts_of_edge(const Geometry& g, const std::vector<TextureNode>& textures, std::uint32_t texture,
                  std::uint32_t triangle) {
  const TextureNode& node = textures[texture];
  if (node.kind != TextureKind::image) return kMostParts + 1;
  const auto& [a, b, c] = g.triangles[triangle];
  float texels = 0;
  for (const Vec2 edge : {g.uvs[b] - g.uvs[a], g.uvs[c] - g.uvs[b], g.uvs[a] - g.uvs[c]}) {
    const float u = edge.x * node.uv_scale.x, v = edge.y * node.uv_scale.y;
    // At any angle, an edge crosses no more texels than this.
    const auto most = static_cast<float>(std::max(node.image->width(), node.image->height()));
    texels = std::max(texels, std::sqrt(u * u + v * v) * most);
  }
  if (!(texels <= kMostParts)) return kMostParts + 1;
  return std::max(kFewestParts, static_cast<int>(std::ceil(texels)));
}

/// Mean over a triangle that is cut into parts * parts alike, each read at its centre of gravity.
RGB mean_over_parts(const Geometry& g, const SceneDescription& scene, const ColorInput& input, std::uint32_t triangle,
                    int parts) {
  const auto& [a, b, c] = g.triangles[triangle];
  RGB sum;
  const float step = 1.0f / static_cast<float>(parts);
  for (int y = 0; y < parts; ++y)
    for (int x = 0; x + y < parts; ++x)
      for (const float third : {1.0f / 3, 2.0f / 3}) {
        if (third > 0.5f && x + y + 1 >= parts) continue;  // beyond the long edge there is no turned part
        const Vec2 w{(static_cast<float>(x) + third) * step, (static_cast<float>(y) + third) * step};
        sum += evaluate(scene.textures, input, g.uvs[a] * (1 - w.x - w.y) + g.uvs[b] * w.x + g.uvs[c] * w.y);
      }
  return sum * (step * step);
}
}  // namespace

RGB mean_radiance(const Geometry& g, const SceneDescription& scene, std::uint32_t triangle) {
  const ColorInput& input = scene.emissions[g.emission[triangle]].radiance;
  if (input.texture == kNone) return input.value;
  const int parts = parts_of_edge(g, scene.textures, input.texture, triangle);
  const RGB mean = mean_over_parts(g, scene, input, triangle, std::min(parts, kMostParts));
  // A triangle whose texels are all black is not a light.
  if (parts <= kMostParts && is_black(mean)) return RGB(0.0f);
  // Light that the points miss keeps a small chance, so that sampling can still find it.
  const RGB floor = input.value * 1e-3f;
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
