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

/// What glTF's base colour stands for: light that passes glass, and that others reflect.
const ColorInput& base_input(const Material& material);

/// The factor of the base colour that a new file gives a triangle. Metal without a texture of its reflectance has
/// baked_albedo(), by its index.
RGB base_factor(const Scene& scene, std::uint32_t triangle);

/// The base colour at a place that files of formats with base colours show: the factor times its texture.
/// @param keeps_source whether the file is a glTF file with light, which shows all its textures and colours of vertices
RGB base_color(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, bool keeps_source);

/// A colour, and an alpha if that has a texture: at the size of the first image in them, at most 2048 texels a side, or
/// else two by two cells of the first checkerboard. None if they have neither, or an image at second coordinates.
/// @param white value of the brightest code, which clips the colour; 0: its brightest component
std::optional<SourceTexture> source_texture(const Scene& scene, const ColorInput& color, const FloatInput& alpha,
                                            float white);

}  // namespace glowworm
