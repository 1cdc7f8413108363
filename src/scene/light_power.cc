#include "scene/light_power.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/warp.h"

namespace glowworm {

namespace {
/// Parts into which a triangle's edge is divided for samples of a textured emission: one per texel, within bounds.
constexpr int kMinParts = 6, kMaxParts = 256;
/// Maximum number of samples of all triangles; above that, there is less than one per texel.
constexpr std::uint64_t kMaxPoints = 20'000'000;

/// Maximum number of texels that the longest edge of a triangle crosses, in any image under node `id`; infinite if
/// unknown.
/// @param scale of the texture coordinates by the nodes above
float texels_across(const Geometry& g, const std::vector<TextureNode>& textures, std::uint32_t id,
                    std::uint32_t triangle, Vec2 scale) {
  if (id == kNone) return 0;
  const TextureNode& node = textures[id];
  scale = {scale.x * node.uv_scale.x, scale.y * node.uv_scale.y};
  switch (node.kind) {
    case TextureKind::constant:
    case TextureKind::vertex_color:
      return 0;
    case TextureKind::scale:
      return std::max(texels_across(g, textures, node.child_a, triangle, scale),
                      texels_across(g, textures, node.child_b, triangle, scale));
    case TextureKind::mix:
    case TextureKind::checkerboard:
      return HUGE_VALF;
    case TextureKind::image:
      break;
  }
  const std::vector<Vec2>& uvs = node.second_uv && !g.second_uvs.empty() ? g.second_uvs : g.uvs;
  const auto& [a, b, c] = g.triangles[triangle];
  // An edge crosses at most this many texels, whatever rotation the nodes apply.
  const auto side = static_cast<float>(std::max(node.image->width(), node.image->height()));
  const float most = std::max(std::abs(scale.x), std::abs(scale.y)) * side;
  float texels = 0;
  for (const Vec2 edge : {uvs[b] - uvs[a], uvs[c] - uvs[b], uvs[a] - uvs[c]})
    texels = std::max(texels, std::sqrt(edge.x * edge.x + edge.y * edge.y) * most);
  return texels;
}

/// Number of parts of each edge for steps of one texel; kMaxParts + 1 if there are more, or if there are no texels.
int parts_of_edge(const Geometry& g, const std::vector<TextureNode>& textures, std::uint32_t texture,
                  std::uint32_t triangle) {
  const float texels = texels_across(g, textures, texture, triangle, {1, 1});
  if (!(texels <= kMaxParts)) return kMaxParts + 1;
  return std::max(kMinParts, static_cast<int>(std::ceil(texels)));
}

/// Mean over a triangle that is divided into parts * parts equal triangles, each sampled at its centroid.
RGB mean_over_parts(const Geometry& g, const SceneDescription& scene, const ColorInput& input, std::uint32_t triangle,
                    int parts) {
  RGB sum;
  const float step = 1.0f / static_cast<float>(parts);
  for (int y = 0; y < parts; ++y)
    for (int x = 0; x + y < parts; ++x)
      for (const float third : {1.0f / 3, 2.0f / 3}) {
        if (third > 0.5f && x + y + 1 >= parts) continue;  // there is no inverted part beyond the longest edge
        const Vec2 w{(static_cast<float>(x) + third) * step, (static_cast<float>(y) + third) * step};
        sum += evaluate(scene.textures, input, texture_point(g, triangle, w));
      }
  return sum * (step * step);
}

/// @param parts of each edge; @param whole whether these samples read every texel
RGB mean_radiance(const Geometry& g, const SceneDescription& scene, std::uint32_t triangle, int parts, bool whole) {
  const ColorInput& input = scene.emissions[g.emission[triangle]].radiance;
  if (input.texture == kNone) return input.value;
  const RGB mean = mean_over_parts(g, scene, input, triangle, parts);
  // If all texels were read and are black, the triangle is not a light.
  if (whole && is_black(mean)) return RGB(0.0f);
  // Unread texels must keep a chance of being sampled, or their light would be lost.
  const RGB floor = input.value * 1e-3f;
  return {std::max(mean.r, floor.r), std::max(mean.g, floor.g), std::max(mean.b, floor.b)};
}

/// The maximum number of parts of an edge for at most kMaxPoints samples.
int most_parts(const std::vector<int>& parts) {
  for (int most = kMaxParts; most > kMinParts; most /= 2) {
    std::uint64_t points = 0;
    for (const int each : parts) points += static_cast<std::uint64_t>(std::min(each, most)) * std::min(each, most);
    if (points <= kMaxPoints) return most;
  }
  return kMinParts;
}
}  // namespace

std::vector<RGB> triangle_powers(const Geometry& g, const SceneDescription& scene,
                                 const std::vector<std::uint32_t>& triangles) {
  std::vector<int> parts(triangles.size(), 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t texture = scene.emissions[g.emission[triangles[i]]].radiance.texture;
    if (texture != kNone) parts[i] = parts_of_edge(g, scene.textures, texture, triangles[i]);
  }
  const int most = most_parts(parts);
  std::vector<RGB> powers(triangles.size());
  parallel_for_each(triangles.size(), 256, [&](std::size_t i) {
    const std::uint32_t t = triangles[i];
    const float sides = scene.emissions[g.emission[t]].two_sided ? 2.0f : 1.0f;
    powers[i] = mean_radiance(g, scene, t, std::min(parts[i], most), parts[i] <= most) * (kPi * g.area(t) * sides);
  });
  return powers;
}

RGB light_power(const Light& light, float scene_radius) {
  switch (light.kind) {
    case LightKind::point:
      return light.intensity * (4 * kPi);
    case LightKind::spot:
      return light.intensity *
             (2 * kPi * ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) * mean_spot_falloff(light)));
    case LightKind::luminaire:
      return light.intensity *
             (light.table->tilt_factor(light.direction) * static_cast<float>(light.table->integral()));
    case LightKind::directional:
      return light.intensity * (kPi * scene_radius * scene_radius);
  }
  return RGB(0.0f);
}

float table_intensity(const Light& luminaire, Vec3 d) {
  return luminaire.table->tilt_factor(luminaire.direction) *
         luminaire.table->intensity(luminaire_axes(luminaire.right, luminaire.direction).to_local(d));
}

float spot_falloff(const Light& light, float cos_theta) {
  if (cos_theta >= light.cos_inner) return 1;
  if (cos_theta <= light.cos_outer) return 0;
  const float t = (cos_theta - light.cos_outer) / (light.cos_inner - light.cos_outer);
  switch (light.falloff) {
    case SpotFalloff::smoothstep:
      return t * t * (3 - 2 * t);
    case SpotFalloff::quadratic:
      return t * t;
    case SpotFalloff::quartic:
      return (t * t) * (t * t);
  }
  return 0;
}

}  // namespace glowworm
