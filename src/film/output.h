// From the film to files: the image with its layers.
#pragma once

#include "film/film.h"
#include "film/picture_info.h"
#include "image/image.h"

namespace glowworm {

/// Key of the estimated relative error (film/filtered.h) in the metadata; absent for fewer than two samples.
inline constexpr const char* kRelativeError = "glowworm:relative_error";

/// The film as a picture: the image, and a layer for each AOV in the settings; its metadata holds settings, version,
/// seed and time.
Image make_image(const Film& film, const PictureInfo& info);

/// Bytes that make_image() and writing its picture need.
std::uint64_t image_bytes(const RenderSettings& settings);

}  // namespace glowworm
