// Reordering of points along the Hilbert curve, to the depth that pays: neighbours in the order are neighbours in
// space, so packets and blocks of points share searches.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

enum class ReorderMethod : std::uint8_t {
  none,    ///< points keep their order
  octree,  ///< [SF07]: an octree in Hilbert child order that does not divide cells of few points
  radix,   ///< radix sort on Hilbert keys of few bits
};

/// automatic_depth() chooses the depth.
inline constexpr int kAutomaticDepth = -1;

struct ReorderSettings {
  ReorderMethod method = ReorderMethod::radix;
  std::uint32_t threshold = 16;  ///< octree: cells of at most this many points are not divided; 16 as in [SF07]
  int depth = kAutomaticDepth;   ///< levels of the curve, 0 to 21. octree: at most so many; automatic: 21
};

/// Useful number of levels of the Hilbert curve for sorting `points` query points that look up `photons` photons.
/// Sorts until cells of a surface hold about a packet of points, or are small beside the photons' radius,
/// whichever comes first.
int automatic_depth(std::size_t points, std::size_t photons);

/// The order in which to visit the points: element i is the index of the i-th point. Points in one cell of the finest
/// level keep their order. Uses all threads; the result does not depend on their number.
/// @param bounds divided into cells; points outside count to the border cells
/// @param photons number of photons to look up; only the automatic depth reads it
std::vector<std::uint32_t> hilbert_order(std::span<const Vec3> points, const Box3& bounds, std::size_t photons,
                                         const ReorderSettings& settings);

/// The box around points, on all threads. Points with coordinates that are not finite are left out.
Box3 bounds_of(std::span<const Vec3> points);

}  // namespace glowworm
