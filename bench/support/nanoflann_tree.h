// nanoflann's kd-tree over an array of points, for comparison.
#pragma once
#include <cstdint>
#include <nanoflann.hpp>
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm::bench {

/// nanoflann's view of an array of points, which must stay while it is used.
struct NanoflannPoints {
  std::span<const Vec3> positions;
  std::size_t kdtree_get_point_count() const { return positions.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const { return positions[index][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using NanoflannTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, NanoflannPoints>,
                                                          NanoflannPoints, 3, std::uint32_t>;

}  // namespace glowworm::bench
