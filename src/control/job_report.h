// What a render leaves besides its film: metadata of its picture, its part, its statistics.
#pragma once
#include "control/job.h"
#include "film/part.h"
#include "film/picture_info.h"
#include "glowworm/statistics.h"
#include "image/image.h"

namespace glowworm {

/// The arguments of make_image() besides the film; at any time.
PictureInfo picture_info(const Job& job);

/// The pixels of a film of the job in its picture.
FrameView frame_view(const Film& film, const Job& job);

/// What later frames may use of a job that has ended and filters its picture.
FrameLight frame_light(const Job& job);

/// The film as the job's picture.
Image make_image(const Film& film, const Job& job);

/// The part that a render makes.
Part part_of(const Job& job);

/// The statistics of a render; docs/guide.md lists the keys of the JSON object and their units.
api::RenderStatistics statistics_of(const Job& job, const Tracer& tracer);

}  // namespace glowworm
