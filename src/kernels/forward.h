// Masked traversal of the photon tree of [SF07] by packets of query points.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/kernel_shape.h"

namespace glowworm {

/// Maximum number of query points in a packet.
inline constexpr int kForwardMaxLanes = 16;

/// A node of the tree, 8 bytes: one photon, on the node's split plane. Nodes are in preorder: the left child follows
/// its parent.
struct ForwardNode {
  static constexpr std::uint32_t kAxisMask = 3, kLeaf = 3;
  std::uint32_t split;  ///< bits of the split position as a float, whose lowest two hold the axis, or kLeaf
  std::uint32_t right;  ///< right child; 0 if there is none
};
static_assert(sizeof(ForwardNode) == 8);

/// Data for the test of a photon: 16 bytes. In the order of the nodes, so no index to the cold data is needed; the
/// kernel width takes its place.
struct ForwardHot {
  float x, y, z;                 ///< metres
  float inverse_radius_squared;  ///< 1 / h^2 in m^-2; infinite if the photon never counts
};
static_assert(sizeof(ForwardHot) == 16);

/// Data of photons that pass the test: 24 bytes.
struct ForwardCold {
  float flux[3];  ///< dPhi / (pi h^2) times the norm of the kernel, in W m^-2
  float normal[3];
};
static_assert(sizeof(ForwardCold) == 24);

/// Largest distance of a query point from a node's split plane at which it is still reached, metres.
struct ForwardReach {
  float own;    ///< by the node's photon
  float left;   ///< by photons below the left child, from the right of the plane
  float right;  ///< by photons below the right child, from the left of the plane
};

/// The tree in the layout of the kernels.
struct ForwardTree {
  const ForwardNode* nodes = nullptr;
  const ForwardHot* hot = nullptr;
  const ForwardCold* cold = nullptr;
  const ForwardReach* reach = nullptr;  ///< by node; null if it is `fixed_reach` for all
  float fixed_reach = 0;
  std::uint32_t count = 0;
  float min_normal_cosine = 0;
  KernelShape kernel = KernelShape::epanechnikov;
};

/// Query points, in structure-of-arrays form. The arrays have kForwardMaxLanes - 1 more floats, which are read but not
/// used.
struct ForwardQueries {
  const float *x, *y, *z, *normal_x, *normal_y, *normal_z;
  std::size_t count;
};

/// Work of the packets. [SF07] measures active / shadings in its Table 1.
struct ForwardCounts {
  std::uint64_t shadings = 0;    ///< visits of a packet to a photon with at least one active lane
  std::uint64_t active = 0;      ///< active lanes in them: pairs whose true distance was tested
  std::uint64_t operations = 0;  ///< pairs inside the kernel support, of matching normals
};

/// Adds to r, g, b [i] the sum over the photons of K / h^2 dPhi / pi at query point i, in W m^-2 (sr^-1 with the
/// albedo). Takes query points in order, in packets of `lanes`: 1, 4, 8 or 16, whatever the vector width of the
/// machine. r, g, b are as large as the queries; elements beyond count keep their values.
void forward_gather(const ForwardTree& tree, const ForwardQueries& queries, int lanes, float* r, float* g, float* b,
                    ForwardCounts& counts);

/// A photon inside the kernel support at a query point.
struct ForwardPair {
  std::uint32_t query;
  std::uint32_t photon;
  float profile;  ///< K over its norm
};

/// Appends the pairs of the packet at query point `first`, which forward_gather() would add up.
void forward_collect(const ForwardTree& tree, const ForwardQueries& queries, std::size_t first, int lanes,
                     std::vector<ForwardPair>& pairs, ForwardCounts& counts);

}  // namespace glowworm
