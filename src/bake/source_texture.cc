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

std::optional<SourceTexture> source_texture(const Scene& scene, const ColorInput& color, const FloatInput& alpha,
                                            float white) {
  const std::vector<TextureNode>& textures = scene.textures();
  const TextureNode* image = first_image(textures, color.texture);
  if (!image) image = first_image(textures, alpha.texture);
  if (!image || image->second_uv || image->uv_scale.x == 0 || image->uv_scale.y == 0) return std::nullopt;
  SourceTexture out;
  // Rows of glTF's textures run downwards, ours upwards.
  out.scale = image->uv_scale;
  out.offset = {image->uv_offset.x, 1 - image->uv_scale.y - image->uv_offset.y};
  const int width = std::clamp(image->image->width(), 1, kMaxSide);
  const int height = std::clamp(image->image->height(), 1, kMaxSide);
  const auto columns = static_cast<std::size_t>(width), count = columns * static_cast<std::size_t>(height);
  const auto place = [&](std::size_t texel) {
    const float s = (static_cast<float>(texel % columns) + 0.5f) / static_cast<float>(width);
    const float t = 1 - (static_cast<float>(texel / columns) + 0.5f) / static_cast<float>(height);
    return TexturePoint((s - image->uv_offset.x) / image->uv_scale.x, (t - image->uv_offset.y) / image->uv_scale.y);
  };
  std::vector<RGB> colors(count);
  parallel_for_each(count, 16384, [&](std::size_t i) { colors[i] = evaluate(textures, color, place(i)); });
  out.white = white;
  if (white == 0)
    for (const RGB& c : colors) out.white = std::max(out.white, max_component(c));
  const float factor = out.white > 0 ? 1 / out.white : 0;
  const bool has_alpha = alpha.texture != kNone;
  const std::size_t channels = has_alpha ? 4 : 3;
  std::vector<std::uint8_t> bytes(channels * count);
  parallel_for_each(count, 16384, [&](std::size_t i) {
    std::uint8_t* const pixel = bytes.data() + channels * i;
    const RGB c = clamp(colors[i] * factor, 0, 1);
    for (int k = 0; k < 3; ++k) pixel[k] = to_byte(srgb_encode(c[k]));
    if (has_alpha) pixel[3] = to_byte(evaluate(textures, alpha, place(i)));
  });
  out.png = encode_png(width, height, static_cast<int>(channels), std::move(bytes), {});
  return out;
}

}  // namespace glowworm
