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

/// A colour parameter, which may be a texture; `otherwise` if it is not given.
ColorInput color_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, RGB otherwise,
                       PbrtColorUse use = PbrtColorUse::reflectance);

/// A number parameter, which may be a texture; `otherwise` if it is not given.
FloatInput float_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, float otherwise);

/// Whether a parameter, which may be null, is the name of a texture of a table.
bool names_texture_in(const PbrtTextures& table, const PbrtParameter* parameter);

/// The default encoding of an image file, as in pbrt: sRGB, but linear for floating-point formats.
TextureOptions default_image_options(const std::string& file);

/// Adds a texture node that shows an image file.
std::uint32_t add_image_texture(PbrtContext& context, const PbrtParameters& parameters, const std::string& file,
                                const TextureOptions& options, StandIn stand_in);

}  // namespace glowworm
