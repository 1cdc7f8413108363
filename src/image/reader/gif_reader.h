// Reads GIF files by giflib. OpenImageIO (2.4) looks pixels up beyond the end of small palettes.
#pragma once
#include <memory>
#include <string>

#include "image/image_reader.h"

namespace glowworm {

/// Opens the first picture of a GIF file as 8-bit RGBA, sRGB-encoded. Pixels that the picture leaves out are
/// transparent; those beyond the palette are black. If it cannot be read, returns null and sets `failure` to
/// the reason.
std::unique_ptr<ImageReader> open_gif(const char* path, std::string& failure);

}  // namespace glowworm
