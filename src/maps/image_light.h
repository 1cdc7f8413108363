// Light of lamps without size and suns that flat mirrors and glass bring to points in air: exact, in place of photons
// that pass.
#pragma once
#include <span>
#include <vector>

#include "gather/point_pass.h"
#include "maps/air_light.h"
#include "transport/light_images.h"

namespace glowworm {

/// Adds to `part` of the radiance the irradiance at points, W m^-2, that lights without size bring by their images.
/// Photons that come from these do not pass points (PhotonPassSettings::discs). Runs on all threads; counts
/// occlusion_rays. Points at the same place, as samples of one sensor are, share their rays.
void add_image_light(const Tracer& tracer, const LightImages& images, std::span<const AirPoint> points,
                     SlotRadiance& radiance, std::vector<RGB>& part, Statistics& statistics);

}  // namespace glowworm
