#include "bake/source_texture.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "bake/light.h"
#include "core/parallel.h"
#include "image/image.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

constexpr int kMaxSide = 2048;
constexpr int kBoardSide = 256;  ///< of a picture of two by two cells

/// The first node of a kind among a node and those that it is made of; null where there is none.
const TextureNode* first_of_kind(const std::vector<TextureNode>& textures, std::uint32_t id, TextureKind kind) {
  if (id == kNone) return nullptr;
  const TextureNode& node = textures[id];
  if (node.kind == kind) return &node;
  for (const std::uint32_t child : {node.child_a, node.child_b, node.child_amount})
    if (const TextureNode* found = first_of_kind(textures, child, kind)) return found;
  return nullptr;
}

/// The node of which a picture of a colour and an alpha covers one period: an image, or else a checkerboard. Null:
/// there is no picture.
const TextureNode* framing_node(const std::vector<TextureNode>& textures, std::uint32_t color, std::uint32_t alpha) {
  for (const TextureKind kind : {TextureKind::image, TextureKind::checkerboard})
    for (const std::uint32_t id : {color, alpha})
      if (const TextureNode* node = first_of_kind(textures, id, kind)) {
        const bool is_placed = !node->second_uv && node->uv_scale.x != 0 && node->uv_scale.y != 0;
        return is_placed ? node : nullptr;
      }
  return nullptr;
}

}  // namespace

const ColorInput& base_input(const Material& material) {
  const bool is_glass = material.kind == MaterialKind::dielectric || material.kind == MaterialKind::thin_dielectric;
  return is_glass ? material.transmittance : material.reflectance;
}

RGB base_factor(const Scene& scene, std::uint32_t triangle) {
  const Material& m = scene.materials()[scene.geometry().material[triangle]];
  const bool is_metal = m.kind == MaterialKind::conductor || m.kind == MaterialKind::coated_conductor;
  if (is_metal && m.reflectance.texture == kNone) return baked_albedo(scene, triangle, {1 / 3.0f, 1 / 3.0f});
  return clamp(base_input(m).value, 0, 1);
}

RGB base_color(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, bool keeps_source) {
  const Material& m = scene.materials()[scene.geometry().material[triangle]];
  const std::uint32_t texture = base_input(m).texture;
  const RGB factor = base_factor(scene, triangle);
  if (texture == kNone) return factor;
  const TexturePoint at = texture_point(scene.geometry(), triangle, barycentric);
  if (keeps_source) return clamp(factor * evaluate(scene.textures(), texture, at), 0, 1);
  if (!framing_node(scene.textures(), texture, m.alpha.texture)) return factor;
  return factor * clamp(evaluate(scene.textures(), texture, TexturePoint(at.uv)), 0, 1);
}

std::optional<SourceTexture> source_texture(const Scene& scene, const ColorInput& color, const FloatInput& alpha,
                                            float white) {
  const std::vector<TextureNode>& textures = scene.textures();
  const TextureNode* frame = framing_node(textures, color.texture, alpha.texture);
  if (!frame) return std::nullopt;
  SourceTexture out;
  const bool is_board = frame->kind == TextureKind::checkerboard;
  const float periods = is_board ? 0.5f : 1;
  const Vec2 scale = frame->uv_scale * periods, offset = frame->uv_offset * periods;
  // Rows of glTF's textures run downwards, ours upwards.
  out.scale = scale;
  out.offset = {offset.x, 1 - scale.y - offset.y};
  const int width = is_board ? kBoardSide : std::clamp(frame->image->width(), 1, kMaxSide);
  const int height = is_board ? kBoardSide : std::clamp(frame->image->height(), 1, kMaxSide);
  const auto columns = static_cast<std::size_t>(width), count = columns * static_cast<std::size_t>(height);
  const auto place = [&](std::size_t texel) {
    const float s = (static_cast<float>(texel % columns) + 0.5f) / static_cast<float>(width);
    const float t = 1 - (static_cast<float>(texel / columns) + 0.5f) / static_cast<float>(height);
    return TexturePoint((s - offset.x) / scale.x, (t - offset.y) / scale.y);
  };
  std::vector<RGB> colors(count);
  parallel_for_each(count, 4096, [&](std::size_t i) { colors[i] = evaluate(textures, color, place(i)); });
  out.white = white;
  if (white == 0)
    for (const RGB& c : colors) out.white = std::max(out.white, max_component(c));
  const float factor = out.white > 0 ? 1 / out.white : 0;
  const bool has_alpha = alpha.texture != kNone;
  const std::size_t channels = has_alpha ? 4 : 3;
  std::vector<std::uint8_t> bytes(channels * count);
  parallel_for_each(count, 4096, [&](std::size_t i) {
    std::uint8_t* const pixel = bytes.data() + channels * i;
    const RGB c = clamp(colors[i] * factor, 0, 1);
    for (int k = 0; k < 3; ++k) pixel[k] = to_byte(srgb_encode(c[k]));
    if (has_alpha) pixel[3] = to_byte(evaluate(textures, alpha, place(i)));
  });
  out.png = encode_png(width, height, static_cast<int>(channels), std::move(bytes), {});
  return out;
}

}  // namespace glowworm
