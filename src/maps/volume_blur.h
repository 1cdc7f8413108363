// How far the flux of photons in media is blurred: as far as gives the least error.
#pragma once
#include <vector>

#include "maps/volume_maps.h"

namespace glowworm {

/// For each medium, the factor on the radii of its points that makes the expected square error of the light along
/// segments least, in [1/2, 2]; 1 without points. Their variance falls as the square of the radius, and the blur grows
/// as its square, so the square error is V / s^2 + B s^4 at the factor s, least at s^6 = V / (2 B). V and B are
/// measured along some beams, which are lines that rays see, too: V from the photons that meet them, B from what twice
/// the radii find beyond what chance explains. No factor above 1 makes radii so wide beside the free path that the mean
/// light changes by 0.5%. What is smaller than a kernel is blurred by any radius, and not found.
/// @param kernels of `photons.points`, without walls
std::vector<float> best_radius_factors(const Tracer& tracer, const MediaPhotons& photons, const PhotonKernels& kernels);

}  // namespace glowworm
