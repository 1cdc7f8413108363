// Reads files of most formats by OpenImageIO.
#pragma once
#include <memory>
#include <string>

#include "image/image_reader.h"

namespace glowworm {

/// Opens a file by a reader of OpenImageIO. Returns null and sets `failure` to the reason if it cannot be read.
std::unique_ptr<ImageReader> open_by_openimageio(const std::string& path, const std::string& plugin,
                                                 std::string& failure);

}  // namespace glowworm
