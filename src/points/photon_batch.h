// Photons, in structure-of-arrays form.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/parallel.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "points/batch.h"

namespace glowworm {

/// Flux that arrived at surfaces. All arrays have the same length; index i is one photon.
struct PhotonBatch : Batch<PhotonBatch> {
  LargeVector<Vec3> position;   ///< metres
  LargeVector<Vec3> direction;  ///< unit, back along its path (w_j of the estimators)
  LargeVector<RGB> flux;        ///< W: dPhi_j
  LargeVector<Vec3> normal;     ///< unit, geometric, on the side where the photon arrived

  template <class Any>
  static auto arrays(Any& batch) {
    return std::tie(batch.position, batch.direction, batch.flux, batch.normal);
  }
  void push_back(Vec3 p, Vec3 d, RGB f, Vec3 n) { add(p, d, f, n); }
  /// Photon i of this batch is photon places[i] of the result. Throws Cancelled when interrupted.
  PhotonBatch moved(std::span<const std::uint32_t> places) const;
  Box3 bounds() const;
};

/// Element i is element places[i] of the result. Throws Cancelled when interrupted: arrays on disk take long.
template <class Array>
Array moved(const Array& from, std::span<const std::uint32_t> places) {
  Array to(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (i % 65536 == 0) check_cancelled();
    to[places[i]] = from[i];
  }
  return to;
}

/// Places that put points of one cell of a coarse grid together, in their order, and cells along a Hilbert curve. Work
/// that goes through space then touches few pages of memory at a time.
std::vector<std::uint32_t> places_by_cell(std::span<const Vec3> points);

}  // namespace glowworm
