#include "scene/texture.h"

#include <cmath>

namespace glowworm {

namespace {

Vec2 transformed(const TextureNode& node, Vec2 uv) {
  if (node.uv_rotation != 0) {
    const float c = std::cos(node.uv_rotation), s = std::sin(node.uv_rotation);
    uv = {c * uv.x - s * uv.y, s * uv.x + c * uv.y};
  }
  return {uv.x * node.uv_scale.x + node.uv_offset.x, uv.y * node.uv_scale.y + node.uv_offset.y};
}

bool in_odd_cell(Vec2 uv) {
  // In floating point, because texture coordinates may exceed the range of any integer.
  const float sum = std::floor(uv.x) + std::floor(uv.y);
  return sum - 2 * std::floor(sum / 2) != 0;
}

RGB color_of(const std::vector<TextureNode>& textures, std::uint32_t id, Vec2 uv);

RGB child_color(const std::vector<TextureNode>& textures, const TextureNode& node, std::uint32_t child, Vec2 uv) {
  return child == kNone ? node.value : color_of(textures, child, uv);
}

float mix_amount(const std::vector<TextureNode>& textures, const TextureNode& node, Vec2 uv) {
  return node.child_amount == kNone ? 0.5f : mean(color_of(textures, node.child_amount, uv));
}

RGB color_of(const std::vector<TextureNode>& textures, std::uint32_t id, Vec2 uv) {
  const TextureNode& node = textures[id];
  switch (node.kind) {
    case TextureKind::constant:
      return node.value;
    case TextureKind::image: {
      if (!node.image) return node.value;
      const RGB texel = node.image->color(transformed(node, uv));
      return node.value * (node.invert ? RGB(1.0f) - texel : texel);
    }
    case TextureKind::scale: {
      const Vec2 inner = transformed(node, uv);
      return child_color(textures, node, node.child_a, inner) * child_color(textures, node, node.child_b, inner);
    }
    case TextureKind::mix: {
      const Vec2 inner = transformed(node, uv);
      const float amount = mix_amount(textures, node, inner);
      // A texture with weight 0 is not read, because it may be expensive.
      if (amount <= 0) return child_color(textures, node, node.child_a, inner);
      if (amount >= 1) return child_color(textures, node, node.child_b, inner);
      return lerp(child_color(textures, node, node.child_a, inner), child_color(textures, node, node.child_b, inner),
                  amount);
    }
    case TextureKind::checkerboard: {
      const Vec2 inner = transformed(node, uv);
      return child_color(textures, node, in_odd_cell(inner) ? node.child_b : node.child_a, uv);
    }
  }
  return node.value;
}

float alpha_of(const std::vector<TextureNode>& textures, std::uint32_t id, Vec2 uv) {
  if (id == kNone) return 1;
  const TextureNode& node = textures[id];
  const Vec2 inner = transformed(node, uv);
  switch (node.kind) {
    case TextureKind::constant:
      return 1;
    case TextureKind::image:
      return node.image ? node.image->alpha(inner) : 1.0f;
    case TextureKind::scale:
      return alpha_of(textures, node.child_a, inner) * alpha_of(textures, node.child_b, inner);
    case TextureKind::mix: {
      const float amount = std::clamp(mix_amount(textures, node, inner), 0.0f, 1.0f);
      return (1 - amount) * alpha_of(textures, node.child_a, inner) + amount * alpha_of(textures, node.child_b, inner);
    }
    case TextureKind::checkerboard:
      return alpha_of(textures, in_odd_cell(inner) ? node.child_b : node.child_a, uv);
  }
  return 1;
}

}  // namespace

RGB evaluate(const std::vector<TextureNode>& textures, std::uint32_t id, Vec2 uv) { return color_of(textures, id, uv); }

RGB evaluate(const std::vector<TextureNode>& textures, const ColorInput& input, Vec2 uv) {
  return input.texture == kNone ? input.value : input.value * color_of(textures, input.texture, uv);
}

float evaluate(const std::vector<TextureNode>& textures, const FloatInput& input, Vec2 uv) {
  if (input.texture == kNone) return input.value;
  switch (input.channel) {
    case Channel::mean:
      return input.value * mean(color_of(textures, input.texture, uv));
    case Channel::red:
      return input.value * color_of(textures, input.texture, uv).r;
    case Channel::green:
      return input.value * color_of(textures, input.texture, uv).g;
    case Channel::blue:
      return input.value * color_of(textures, input.texture, uv).b;
    case Channel::alpha:
      return input.value * alpha_of(textures, input.texture, uv);
  }
  return input.value;
}

}  // namespace glowworm
