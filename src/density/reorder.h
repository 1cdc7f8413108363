// Reordering of points along the Hilbert curve, as far as it pays: neighbours in the order are neighbours in space, so
// that packets and blocks of them share what they look up.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

enum class ReorderMethod : std::uint8_t {
  none,    ///< points stay in the order they have
  octree,  ///< [SF07]: an octree in Hilbert child order that stops dividing cells of few points
  radix,   ///< radix sort on Hilbert keys of few bits
};

/// Depth that is chosen by automatic_depth().
inline constexpr int kAutomaticDepth = -1;

struct ReorderSettings {
  ReorderMethod method = ReorderMethod::radix;
  std::uint32_t threshold = 16;  ///< octree: cells of so many points or fewer are not divided; [SF07] found 16 by hand
  int depth = kAutomaticDepth;   ///< levels of the curve, 0 to 21. octree: at most so many; automatic: 21
};

/// Levels of the Hilbert curve that are worth sorting `points` query points by, where `photons` photons are looked up:
/// until cells of a surface hold about a packet of points, or are small beside the photons' radius, whichever
/// comes first.
int automatic_depth(std::size_t points, std::size_t photons);

/// The order in which to visit the points: element i is the index of the i-th. Points in one cell of the finest level
/// keep their order. The same for any number of threads; runs on all.
/// @param bounds what the cells divide; points outside count to the cells at its border
/// @param photons how many photons the points will be asked about; read for the automatic depth alone
std::vector<std::uint32_t> hilbert_order(std::span<const Vec3> points, const Box3& bounds, std::size_t photons,
                                         const ReorderSettings& settings);

/// The box around points, on all threads. Points with coordinates that are not finite are left out.
Box3 bounds_of(std::span<const Vec3> points);

}  // namespace glowworm
