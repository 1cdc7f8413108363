// Reads Radiance pictures (.hdr, .pic).
#pragma once
#include <memory>
#include <string>

#include "image/image_reader.h"

namespace glowworm {

/// Opens a Radiance picture (Ward, "Real Pixels", Graphics Gems II, 1991; Radiance, "File Formats", 2021): pixels
/// without compression or with run lengths, old or new; rows and columns in any of the eight orders. Colours are
/// divided by EXPOSURE and COLORCORR. XYZE becomes linear RGB of Rec. 709. Without FORMAT, pixels are RGBE. Returns
/// null and sets `failure` to the reason if the header is not one.
std::unique_ptr<ImageReader> open_hdr(const std::string& path, std::string& failure);

}  // namespace glowworm
