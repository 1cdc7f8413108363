// Radii of volume photons and beams, from their density. The user sets nothing.
#pragma once
#include <cstdint>
#include <vector>

#include "points/volume_photons.h"

namespace glowworm {

/// Returns kernels without walls. The radius of each photon is that of a sphere that holds about k photons of its
/// medium; positive and finite. Does not depend on the number of threads.
PhotonKernels volume_photon_kernels(const VolumePhotons& photons, std::uint32_t k);

/// The pieces that beams are cut into: small boxes hold them, and each has a radius of its own, so that a beam is
/// narrow where beams are dense.
struct BeamPieces {
  /// The pieces of beam i are first[i] to first[i + 1] - 1, from its origin on. One more element than beams.
  std::vector<std::uint32_t> first;
  std::vector<float> end;     ///< of each piece: the distance from the beam's origin where it ends, metres
  std::vector<float> radii;   ///< of each piece, metres, positive and finite
  std::vector<float> factor;  ///< of each piece, on the flux (maps/medium_parts.h); empty: 1
  /// For each medium, how many parts its beams are divided into. A segment meets one part, and a segment as long as the
  /// mean beam crosses about k beams of it. Empty: one part.
  std::vector<std::uint32_t> parts;

  /// The distance from the origin of beam i where one of its pieces begins.
  float begin(std::size_t i, std::size_t piece) const { return piece == first[i] ? 0 : end[piece - 1]; }
  /// Pieces of so many beams, at most.
  static std::size_t most(std::size_t beams);
};

/// Cuts beams into pieces, which are a multiple of their radii long, the same for all beams of a medium: as short as so
/// many pieces can be. About k / 4 beams of the same medium cross a sphere of a beam's radius: a segment passes many
/// such spheres. Beams of much flux are wider. Does not depend on the number of threads.
BeamPieces volume_beam_pieces(const VolumeBeams& beams, std::uint32_t k);

}  // namespace glowworm
