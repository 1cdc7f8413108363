// Segments of camera and gather rays in participating media: where maps of volume photons are looked up, as query
// points are for maps on surfaces.
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/large_array.h"
#include "core/rgb.h"
#include "core/vec.h"

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
struct VolumeSegments {
  LargeVector<Vec3> origin;           ///< metres
  LargeVector<Vec3> direction;        ///< unit, away from the viewer
  LargeVector<float> length;          ///< metres; may be infinite
  LargeVector<SegmentMedium> medium;  ///< along the segment
  LargeVector<RGB> weight;            ///< throughput from the origin to the target
  LargeVector<std::uint32_t> target;  ///< slot, or any other target index

  std::size_t size() const { return origin.size(); }
  /// Calls work(array of each...) for each of the arrays.
  template <class Work, class... Batches>
  static void for_arrays(const Work& work, Batches&... batches) {
    work(batches.origin...);
    work(batches.direction...);
    work(batches.length...);
    work(batches.medium...);
    work(batches.weight...);
    work(batches.target...);
  }
  void reserve(std::size_t n) {
    for_arrays([n](auto& array) { array.reserve(n); }, *this);
  }
  /// Removes all segments but keeps their memory.
  void clear() {
    for_arrays([](auto& array) { array.clear(); }, *this);
  }
  void push_back(Vec3 o, Vec3 d, float l, const SegmentMedium& m, RGB w, std::uint32_t t) {
    origin.push_back(o);
    direction.push_back(d);
    length.push_back(l);
    medium.push_back(m);
    weight.push_back(w);
    target.push_back(t);
  }
  void append(const VolumeSegments& other) {
    for_arrays([](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); }, *this, other);
  }
};

}  // namespace glowworm
