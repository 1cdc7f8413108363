// Segments of camera and gather rays in participating media: where maps of volume photons are looked up, as query
// points are for maps on surfaces.
#pragma once
#include <cstdint>

#include "core/rgb.h"
#include "core/vec.h"
#include "points/batch.h"

namespace glowworm {

/// Coefficients of a segment's medium, the same all along it: segments in a heterogeneous medium are short.
struct SegmentMedium {
  RGB sigma_t;              ///< m^-1
  RGB sigma_s;              ///< m^-1
  float g = 0;              ///< mean cosine of the Henyey-Greenstein phase function, in (-1, 1)
  std::uint32_t index = 0;  ///< only photons of this medium count
  float random = 0;         ///< in [0, 1): chooses the part of these that the segment meets
};

/// Segments whose in-scattered radiance is estimated. Arrays of one length, index i one segment. Completion reads
/// `weight` and `target`; the map reads the others.
struct VolumeSegments : Batch<VolumeSegments> {
  LargeVector<Vec3> origin;           ///< metres
  LargeVector<Vec3> direction;        ///< unit, away from the viewer
  LargeVector<float> length;          ///< metres; may be infinite
  LargeVector<SegmentMedium> medium;  ///< along the segment
  LargeVector<RGB> weight;            ///< throughput from the origin to the target
  LargeVector<std::uint32_t> target;  ///< slot, or any other target index

  template <class Any>
  static auto arrays(Any& batch) {
    return std::tie(batch.origin, batch.direction, batch.length, batch.medium, batch.weight, batch.target);
  }
  void push_back(Vec3 o, Vec3 d, float l, const SegmentMedium& m, RGB w, std::uint32_t t) { add(o, d, l, m, w, t); }
};

}  // namespace glowworm
