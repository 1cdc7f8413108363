// Textures of a scene as files of their own.
#pragma once
#include <optional>
#include <string>

#include "scene/scene.h"

namespace glowworm {

/// A texture as glTF has it.
struct SourceTexture {
  std::string png;           ///< sRGB, with alpha where the material has one
  Vec2 scale{1, 1}, offset;  ///< from TEXCOORD_0 to the picture (KHR_texture_transform)
  bool is_transformed() const { return scale.x != 1 || scale.y != 1 || offset.x != 0 || offset.y != 0; }
};

/// The texture of a material's base colour, without the colour's constant factor, and of its alpha, at the size of the
/// first image in it, at most 2048 texels a side. None if the material has no image, or one at second coordinates.
std::optional<SourceTexture> source_texture(const Scene& scene, const Material& material);

}  // namespace glowworm
