// Textures: a table of nodes that are evaluated at texture coordinates.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "core/rgb.h"
#include "core/vec.h"
#include "scene/geometry.h"

namespace glowworm {

/// An image for textures. The importers decode files with the image room; tests supply their own.
class TextureImage {
 public:
  virtual ~TextureImage() = default;
  /// Linear colour at (u, v), filtered bilinearly, wrapped as the image says; v runs upwards (v = 0 is the last row).
  virtual RGB color(Vec2 uv) const = 0;
  /// The alpha channel at (u, v) in [0, 1]; 1 where the image has none.
  virtual float alpha(Vec2 uv) const = 0;
  virtual bool has_alpha() const = 0;
  virtual int width() const = 0;
  virtual int height() const = 0;
  /// A number that images of the same texels may share while both exist: images with equal numbers are the same.
  virtual std::uint64_t identity() const { return reinterpret_cast<std::uintptr_t>(this); }
};

/// Where on a surface textures are evaluated.
struct TexturePoint {
  Vec2 uv;           ///< first texture coordinates
  Vec2 second_uv;    ///< second ones, (0,0) where there are none
  VertexColor tint;  ///< colour of the vertices, between them

  TexturePoint() = default;
  TexturePoint(Vec2 first) : uv(first) {}
  TexturePoint(float u, float v) : uv{u, v} {}
};

/// The point of a triangle with these weights of its second and third vertex.
TexturePoint texture_point(const Geometry& scene, std::uint32_t triangle, Vec2 barycentric);

enum class TextureKind : std::uint8_t { constant, image, scale, mix, checkerboard, vertex_color };

/// One node. Texture coordinates of a node are uv_scale * rotate(uv, uv_rotation) + uv_offset.
struct TextureNode {
  TextureKind kind = TextureKind::constant;
  RGB value{1.0f};          ///< constant: the value; image: factor on it
  bool from_alpha = false;  ///< image: its alpha takes the place of its colour
  bool invert = false;      ///< image: 1 - colour, after the factor and at least 0
  bool second_uv = false;   ///< image: looked up at the second texture coordinates
  std::shared_ptr<const TextureImage> image;
  Vec2 uv_scale{1, 1}, uv_offset{0, 0};
  float uv_rotation = 0;               ///< radians, counter-clockwise
  std::uint32_t child_a = kNone;       ///< scale: factor; mix: value at amount 0; checkerboard: even cells
  std::uint32_t child_b = kNone;       ///< scale: factor; mix: value at amount 1; checkerboard: odd cells
  std::uint32_t child_amount = kNone;  ///< mix: amount (its mean)
};

/// A colour or a number of a material: a constant, times an optional texture.
struct ColorInput {
  RGB value{1.0f};
  std::uint32_t texture = kNone;
};
enum class Channel : std::uint8_t {
  mean,
  red,
  green,
  blue,
  alpha,
  gloss,  ///< (1 - value * alpha)^2: the GGX alpha of a glossiness
};
struct FloatInput {
  float value = 1;
  std::uint32_t texture = kNone;
  Channel channel = Channel::mean;
};

/// Evaluates node `id` of a table; nodes refer only to nodes before themselves.
RGB evaluate(const std::vector<TextureNode>& textures, std::uint32_t id, const TexturePoint& at);
RGB evaluate(const std::vector<TextureNode>& textures, const ColorInput& input, const TexturePoint& at);
float evaluate(const std::vector<TextureNode>& textures, const FloatInput& input, const TexturePoint& at);

}  // namespace glowworm
