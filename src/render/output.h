// From the film to files: the image with its layers, and the statistics.
#pragma once
#include <string>

#include "glowworm/statistics.h"
#include "image/image.h"
#include "render/film.h"
#include "render/job.h"
#include "render/picture_info.h"

namespace glowworm {

/// The program's version.
const char* version();

/// Key of the estimated relative error (render/filtered.h) in the metadata; absent for fewer than two samples.
inline constexpr const char* kRelativeError = "glowworm:relative_error";

/// The film as a picture: the image, and a layer for each AOV in the settings; its metadata holds settings, version,
/// seed and time.
Image make_image(const Film& film, const PictureInfo& info);
Image make_image(const Film& film, const Job& job);

/// The arguments of make_image() besides the film; at any time.
PictureInfo picture_info(const Job& job);

/// Bytes that make_image() and writing its picture need.
std::uint64_t image_bytes(const RenderSettings& settings);

/// The statistics of a render; docs/guide.md lists the keys of the JSON object and their units.
api::RenderStatistics statistics_of(const Job& job, const Tracer& tracer);

}  // namespace glowworm
