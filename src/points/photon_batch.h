// Photons, in structure-of-arrays form.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/parallel.h"
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// Flux that arrived at surfaces. All arrays have the same length; index i is one photon.
struct PhotonBatch {
  LargeVector<Vec3> position;   ///< metres
  LargeVector<Vec3> direction;  ///< unit, back along its path (w_j of the estimators)
  LargeVector<RGB> flux;        ///< W: dPhi_j
  LargeVector<Vec3> normal;     ///< unit, geometric, on the side where the photon arrived

  std::size_t size() const { return position.size(); }
  /// Calls work(array of each batch...) for each of the arrays.
  template <class Work, class... Batches>
  static void for_arrays(const Work& work, Batches&... batches) {
    work(batches.position...);
    work(batches.direction...);
    work(batches.flux...);
    work(batches.normal...);
  }
  void resize(std::size_t n) {
    for_arrays([n](auto& array) { array.resize(n); }, *this);
  }
  void reserve(std::size_t n) {
    for_arrays([n](auto& array) { array.reserve(n); }, *this);
  }
  void clear() { resize(0); }
  void push_back(Vec3 p, Vec3 d, RGB f, Vec3 n) {
    position.push_back(p);
    direction.push_back(d);
    flux.push_back(f);
    normal.push_back(n);
  }
  void append(const PhotonBatch& other);
  /// Photon i of the result is photon order[i] of this batch.
  PhotonBatch permuted(std::span<const std::uint32_t> order) const;
  /// Photon i of this batch is photon places[i] of the result. Throws Cancelled when interrupted.
  PhotonBatch moved(std::span<const std::uint32_t> places) const;
  Box3 bounds() const;
};

/// Element i of the result is element order[i] of `from`.
template <class T>
LargeVector<T> permuted(std::span<const T> from, std::span<const std::uint32_t> order) {
  LargeVector<T> to(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) to[i] = from[order[i]];
  return to;
}

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
