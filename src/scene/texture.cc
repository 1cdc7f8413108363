#include "scene/texture.h"

#include <cmath>
#include <limits>

namespace glowworm {

namespace {

Vec2 transformed(const TextureNode& node, Vec2 uv) {
  if (node.uv_rotation != 0) {
    const float c = std::cos(node.uv_rotation), s = std::sin(node.uv_rotation);
    uv = {c * uv.x - s * uv.y, s * uv.x + c * uv.y};
  }
  return {uv.x * node.uv_scale.x + node.uv_offset.x, uv.y * node.uv_scale.y + node.uv_offset.y};
}

/// The point as the children of a node see it.
TexturePoint transformed(const TextureNode& node, TexturePoint at) {
  at.uv = transformed(node, at.uv);
  at.second_uv = transformed(node, at.second_uv);
  return at;
}

Vec2 image_uv(const TextureNode& node, const TexturePoint& at) {
  return transformed(node, node.second_uv ? at.second_uv : at.uv);
}

bool in_odd_cell(Vec2 uv) {
  // In floating point, because texture coordinates may exceed the range of any integer.
  const float sum = std::floor(uv.x) + std::floor(uv.y);
  return sum - 2 * std::floor(sum / 2) != 0;
}

RGB color_of(const std::vector<TextureNode>& textures, std::uint32_t id, const TexturePoint& at);

RGB child_color(const std::vector<TextureNode>& textures, const TextureNode& node, std::uint32_t child,
                const TexturePoint& at) {
  return child == kNone ? node.value : color_of(textures, child, at);
}

float mix_amount(const std::vector<TextureNode>& textures, const TextureNode& node, const TexturePoint& at) {
  return node.child_amount == kNone ? 0.5f : mean(color_of(textures, node.child_amount, at));
}

RGB color_of(const std::vector<TextureNode>& textures, std::uint32_t id, const TexturePoint& at) {
  const TextureNode& node = textures[id];
  switch (node.kind) {
    case TextureKind::constant:
      return node.value;
    case TextureKind::vertex_color:
      return at.tint.color;
    case TextureKind::image: {
      if (!node.image) return node.value;
      const Vec2 uv = image_uv(node, at);
      const RGB texel = node.value * (node.from_alpha ? RGB(node.image->alpha(uv)) : node.image->color(uv));
      return node.invert ? clamp(RGB(1.0f) - texel, 0, std::numeric_limits<float>::infinity()) : texel;
    }
    case TextureKind::scale: {
      const TexturePoint inner = transformed(node, at);
      return child_color(textures, node, node.child_a, inner) * child_color(textures, node, node.child_b, inner);
    }
    case TextureKind::mix: {
      const TexturePoint inner = transformed(node, at);
      const float amount = mix_amount(textures, node, inner);
      // A texture with weight 0 is not read, because it may be expensive.
      if (amount <= 0) return child_color(textures, node, node.child_a, inner);
      if (amount >= 1) return child_color(textures, node, node.child_b, inner);
      return lerp(child_color(textures, node, node.child_a, inner), child_color(textures, node, node.child_b, inner),
                  amount);
    }
    case TextureKind::checkerboard: {
      const TexturePoint inner = transformed(node, at);
      return child_color(textures, node, in_odd_cell(inner.uv) ? node.child_b : node.child_a, at);
    }
  }
  return node.value;
}

float alpha_of(const std::vector<TextureNode>& textures, std::uint32_t id, const TexturePoint& at) {
  if (id == kNone) return 1;
  const TextureNode& node = textures[id];
  if (node.kind == TextureKind::image) return node.image ? node.image->alpha(image_uv(node, at)) : 1.0f;
  const TexturePoint inner = transformed(node, at);
  switch (node.kind) {
    case TextureKind::constant:
    case TextureKind::image:
      return 1;
    case TextureKind::vertex_color:
      return at.tint.alpha;
    case TextureKind::scale:
      return alpha_of(textures, node.child_a, inner) * alpha_of(textures, node.child_b, inner);
    case TextureKind::mix: {
      const float amount = std::clamp(mix_amount(textures, node, inner), 0.0f, 1.0f);
      return (1 - amount) * alpha_of(textures, node.child_a, inner) + amount * alpha_of(textures, node.child_b, inner);
    }
    case TextureKind::checkerboard:
      return alpha_of(textures, in_odd_cell(inner.uv) ? node.child_b : node.child_a, at);
  }
  return 1;
}

}  // namespace

TexturePoint texture_point(const Geometry& scene, std::uint32_t triangle, Vec2 barycentric) {
  const StoredTriangle stored = scene.stored(triangle);
  const Geometry& geometry = *stored.mesh;
  const auto& [a, b, c] = geometry.triangles[stored.index];
  const float u = barycentric.x, v = barycentric.y, w = 1 - u - v;
  TexturePoint at(geometry.uvs[a] * w + geometry.uvs[b] * u + geometry.uvs[c] * v);
  if (!geometry.second_uvs.empty())
    at.second_uv = geometry.second_uvs[a] * w + geometry.second_uvs[b] * u + geometry.second_uvs[c] * v;
  if (!geometry.colors.empty()) {
    const VertexColor &p = geometry.colors[a], &q = geometry.colors[b], &r = geometry.colors[c];
    at.tint = {p.color * w + q.color * u + r.color * v, p.alpha * w + q.alpha * u + r.alpha * v};
  }
  return at;
}

RGB evaluate(const std::vector<TextureNode>& textures, std::uint32_t id, const TexturePoint& at) {
  return color_of(textures, id, at);
}

RGB evaluate(const std::vector<TextureNode>& textures, const ColorInput& input, const TexturePoint& at) {
  return input.texture == kNone ? input.value : input.value * color_of(textures, input.texture, at);
}

float evaluate(const std::vector<TextureNode>& textures, const FloatInput& input, const TexturePoint& at) {
  if (input.texture == kNone) return input.value;
  switch (input.channel) {
    case Channel::mean:
      return input.value * mean(color_of(textures, input.texture, at));
    case Channel::red:
      return input.value * color_of(textures, input.texture, at).r;
    case Channel::green:
      return input.value * color_of(textures, input.texture, at).g;
    case Channel::blue:
      return input.value * color_of(textures, input.texture, at).b;
    case Channel::alpha:
      return input.value * alpha_of(textures, input.texture, at);
    case Channel::gloss: {
      const float roughness = 1 - input.value * alpha_of(textures, input.texture, at);
      return roughness * roughness;
    }
  }
  return input.value;
}

}  // namespace glowworm
