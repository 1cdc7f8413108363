// Textures of pbrt scenes.
#pragma once
#include <string>
#include <string_view>

#include "import/pbrt/colors.h"
#include "import/pbrt/context.h"

namespace glowworm {

/// Defines the texture of a Texture directive.
/// @param value_type "float", "spectrum" (or pbrt-v3's "color"); @param kind "constant", "imagemap", ...
void define_texture(PbrtContext& context, const std::string& name, const std::string& value_type,
                    const std::string& kind, const PbrtParameters& parameters);

/// A colour parameter that may be a texture, or `otherwise`.
ColorInput color_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, RGB otherwise,
                       PbrtColorUse use = PbrtColorUse::reflectance);

/// A number parameter that may be a texture, or `otherwise`.
FloatInput float_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, float otherwise);

/// How an image file is meant where nothing is said, as in pbrt: sRGB, but for the formats of floats, which are linear.
TextureOptions default_image_options(const std::string& file);

/// Adds a texture node that shows an image file.
std::uint32_t add_image_texture(PbrtContext& context, const PbrtParameters& parameters, const std::string& file,
                                const TextureOptions& options);

}  // namespace glowworm
