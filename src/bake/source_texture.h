// Textures of a scene as files of their own.
#pragma once
#include <optional>
#include <string>

#include "scene/scene.h"

namespace glowworm {

/// A texture as glTF has it.
struct SourceTexture {
  std::string png;           ///< sRGB, with alpha where the material has one
  float white = 1;           ///< value of the brightest code
  Vec2 scale{1, 1}, offset;  ///< from TEXCOORD_0 to the picture (KHR_texture_transform)
  bool is_transformed() const { return scale.x != 1 || scale.y != 1 || offset.x != 0 || offset.y != 0; }
};

/// A colour, and an alpha if that has a texture, at the size of the first image in them, at most 2048 texels a side.
/// None if they have no image, or one at second coordinates.
/// @param white value of the brightest code, which clips the colour; 0: its brightest component
std::optional<SourceTexture> source_texture(const Scene& scene, const ColorInput& color, const FloatInput& alpha,
                                            float white);

}  // namespace glowworm
