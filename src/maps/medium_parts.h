// Boundary correction for the kernels of photons in media that reach out of their medium.
#pragma once

#include "density/volume_radii.h"
#include "points/volume_photons.h"
#include "trace/tracer.h"

namespace glowworm {

/// A piece of a beam blurs its flux over a tube. No segment looks up the part of the tube that lies behind surfaces,
/// interfaces or the bounds of the medium, so that flux would be lost (boundary bias: Jensen, Realistic Image Synthesis
/// Using Photon Mapping, 2001, section 7.3). Sets BeamPieces::factor to one over the share of each tube, weighted with
/// its kernel, that lies in the medium, by rays from the beam to the sides of the tube: at most 8, and 1 far from
/// boundaries. A ray leaves the medium at an opaque surface, and is in it again behind the next. Uses all threads;
/// deterministic.
/// @param scale factor on the radii
void correct_pieces(const Tracer& tracer, const VolumeBeams& beams, float scale, BeamPieces& pieces);

/// The same for points, which are blurred over the discs across segments. How much of a disc lies in the medium depends
/// on the direction of the segment, so one factor for all would brighten segments towards a wall and darken those along
/// it. Sets PhotonKernels::walls to tangent planes of boundaries that the rays meet. It chooses planes that cut off as
/// much as possible of the kernel outside the medium, and as little as possible inside. Multiplies the flux by a factor
/// for the part that still lies outside, as at edges.
void correct_photons(const Tracer& tracer, float scale, VolumePhotons& photons, PhotonKernels& kernels);

}  // namespace glowworm
