#include "bake/source_texture.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "image/image.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

constexpr int kMaxSide = 2048;

/// The first image among a node and those that it is made of; null where there is none.
const TextureNode* first_image(const std::vector<TextureNode>& textures, std::uint32_t id) {
  if (id == kNone) return nullptr;
  const TextureNode& node = textures[id];
  if (node.kind == TextureKind::image) return &node;
  for (const std::uint32_t child : {node.child_a, node.child_b, node.child_amount})
    if (const TextureNode* found = first_image(textures, child)) return found;
  return nullptr;
}

}  // namespace

std::optional<SourceTexture> source_texture(const Scene& scene, const Material& material) {
  const std::vector<TextureNode>& textures = scene.textures();
  const TextureNode* image = first_image(textures, material.reflectance.texture);
  if (!image) image = first_image(textures, material.alpha.texture);
  if (!image || image->second_uv || image->uv_scale.x == 0 || image->uv_scale.y == 0) return std::nullopt;
  SourceTexture out;
  // Rows of glTF's textures run downwards, ours upwards.
  out.scale = image->uv_scale;
  out.offset = {image->uv_offset.x, 1 - image->uv_scale.y - image->uv_offset.y};
  const int width = std::clamp(image->image->width(), 1, kMaxSide);
  const int height = std::clamp(image->image->height(), 1, kMaxSide);
  const bool has_alpha = material.alpha.texture != kNone;
  const std::size_t channels = has_alpha ? 4 : 3;
  std::vector<std::uint8_t> bytes(channels * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const ColorInput color{RGB(1.0f), material.reflectance.texture};
  parallel_for(0, static_cast<std::size_t>(height), 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t y = first; y < last; ++y)
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
        const float s = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
        const float t = 1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
        const TexturePoint at((s - image->uv_offset.x) / image->uv_scale.x,
                              (t - image->uv_offset.y) / image->uv_scale.y);
        std::uint8_t* const pixel = bytes.data() + channels * (y * static_cast<std::size_t>(width) + x);
        const RGB c = clamp(evaluate(textures, color, at), 0, 1);
        for (int i = 0; i < 3; ++i) pixel[i] = to_byte(srgb_encode(c[i]));
        if (has_alpha) pixel[3] = to_byte(evaluate(textures, material.alpha, at));
      }
  });
  out.png = encode_png(width, height, static_cast<int>(channels), std::move(bytes), {});
  return out;
}

}  // namespace glowworm
