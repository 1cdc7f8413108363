// Beams of photons on their way through media.
#pragma once
#include <cstdint>

#include "points/volume_photons.h"
#include "transport/medium.h"

namespace glowworm {

/// Appends a photon's way through a medium: one beam, or several where colours fall off unequally. Ways
/// thinner than kThinOpacity become beams with a probability in proportion to their opacity, by which their flux is
/// divided.
/// @param path at the start of the way @param span the part of the way in the medium @param flux of the photon there, W
/// @param u in [0, 1), chooses the ways that become beams
void add_beams(const Medium& medium, const PathState& path, MediumSpan span, RGB flux, std::uint32_t source, float u,
               VolumeBeams& beams);

}  // namespace glowworm
