// Maps of volume photons: radiance that a medium scatters along segments, from the photons or beams around them.
#pragma once
#include <cstdint>
#include <span>

#include "core/rgb.h"
#include "core/statistics.h"
#include "density/volume_index.h"
#include "density/volume_radii.h"
#include "points/volume_photons.h"
#include "points/volume_segments.h"

namespace glowworm {

/// An index of photons or of beams. It keeps no state of segments; estimate() may be called by several threads.
class VolumeMap {
 public:
  /// Builds the index over photons, on all threads (Phase::build_photon_map). Replaces the previous index. Photons
  /// whose numbers are not finite, or without flux, are left out.
  /// @param flux  what estimate() sums, one value for each photon, W, in place of VolumePhotons::flux
  /// @param scale factor on the radii
  void build(const VolumePhotons& photons, std::span<const RGB> flux, const PhotonKernels& kernels, float scale,
             Statistics& statistics);
  /// As above, of beams. @param pieces volume_beam_pieces() of these beams
  void build(const VolumeBeams& beams, std::span<const RGB> flux, const BeamPieces& pieces, float scale,
             Statistics& statistics);

  /// Adds to found[i] (W sr^-1 m^-2) the radiance that arrives at the origin of segment i from the photons or beams
  /// along it, as one part of them tells (BeamPieces::parts), on all threads (Phase::reorder and Phase::density; counts
  /// pairs_tested, shader_operations, packet_steps and packet_active_lanes). Segments of length 0, or whose numbers are
  /// not finite, except for the length, add nothing. The amount depends on the photons and on segment i only: it is the
  /// same, bit for bit, for any number of threads and any other segments in the call.
  ///
  /// Photons: only those whose foot on the segment's line lies in the segment count, within their radius. Beams: a beam
  /// is a tube of its radius, and the segment counts where it is in the tube. Full crossings sum K1(u / r) / (r
  /// sin(theta)), where K1 is the projection of the tube's kernel; ends cut a crossing off, so parallel beams have a
  /// finite sum. Either way, the segment's end is sharp, and the part of a kernel that reaches out of the medium at its
  /// boundary is lost: within a radius of a boundary the estimate is too low, by half at most beside a plane, unless
  /// BeamPieces::factor or PhotonKernels::walls make up for it.
  void estimate(const VolumeSegments& segments, std::span<RGB> found, Statistics& statistics) const;

  /// Whether no photon or beam is in the index.
  bool empty() const { return index_.empty(); }
  /// Bytes of an index of so many photons or beams, at most.
  static std::uint64_t photon_bytes(std::size_t photons);
  static std::uint64_t beam_bytes(std::size_t beams);
  /// Bytes that estimate() takes for so many segments, beside the memory of each thread.
  static std::uint64_t segment_bytes(std::size_t segments);

 private:
  VolumeIndex index_;
};

}  // namespace glowworm
