// The inner loops of reverse photon mapping [HHS05]: clusters of photons against the leaves of a tree of query points.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "kernels/kernel_shape.h"

namespace glowworm {

/// A node of the reverse photon map, 8 bytes. Nodes are in depth-first preorder: the left child of an inner node
/// follows it.
struct ReverseNode {
  static constexpr std::uint32_t kInner = 0, kLeaf = 1;  ///< types
  static constexpr std::uint32_t kMaxCount = 255;        ///< points in a leaf
  static constexpr std::uint32_t kMaxNodes = 1u << 28, kMaxPoints = 1u << 30;
  static constexpr int kMaxDepth = 160;  ///< maximum length of a path from the root to a leaf: T_h of [HHS05]

  std::uint32_t word;  ///< inner: bits of the split position; leaf: upper 24: diagonal as a float without its last 8
                       ///< bits, lower 8: number of points
  std::uint32_t link;  ///< lowest 2: type; inner: next 2: axis, upper 28: right child; leaf: upper 30: first point

  /// Points at or below the split position are on the left, at or above it on the right.
  static ReverseNode inner(int axis, float split, std::uint32_t right) {
    ReverseNode node;
    std::memcpy(&node.word, &split, sizeof split);
    node.link = right << 4 | static_cast<std::uint32_t>(axis) << 2 | kInner;
    return node;
  }
  /// @param diagonal of the leaf's cell, metres; kept to 16 bits, rounded up
  static ReverseNode leaf(std::uint32_t first, std::uint32_t count, float diagonal) {
    std::uint32_t bits;
    std::memcpy(&bits, &diagonal, sizeof bits);
    return {(bits + 255u) / 256u << 8 | count, first << 2 | kLeaf};
  }
  bool is_leaf() const { return (link & 3) == kLeaf; }
  int axis() const { return static_cast<int>(link >> 2 & 3); }
  std::uint32_t right() const { return link >> 4; }
  float split() const { return as_float(word); }
  std::uint32_t first() const { return link >> 2; }
  std::uint32_t count() const { return word & 255; }
  float diagonal() const { return as_float(word & ~255u); }

 private:
  static float as_float(std::uint32_t bits) {
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
};
static_assert(sizeof(ReverseNode) == 8);

/// Floats of a reverse photon in A_R: 32 bytes. A leaf of n stores them array by array: n x, n y, n z, n normal x,
/// n normal y, n normal z, then (as 32-bit integers) n targets and n indices of BSDFs. In A_W: n r, n g, n b.
inline constexpr std::size_t kReverseFields = 8;
inline constexpr std::size_t kReverseSums = 3;
/// Floats after the last reverse photon of A_R and A_W that are read but not used.
inline constexpr std::size_t kReversePadding = 16;

/// Bounds of a leaf's points.
struct ReverseLeafBounds {
  float min[3], max[3];
  float normal[3];  ///< a unit vector near all normals
  float spread;     ///< largest distance of a normal from it
};

/// A part of the tree that one thread processes: the nodes below a node, and the points of their leaves.
struct ReverseSubtreeView {
  const ReverseNode* nodes = nullptr;         ///< of the whole tree
  std::uint32_t root = 0;                     ///< of the part
  std::uint32_t first_point = 0;              ///< of the part
  const float* points = nullptr;              ///< A_R from first_point on
  float* sums = nullptr;                      ///< A_W from first_point on; only used by reverse_sum()
  const ReverseLeafBounds* bounds = nullptr;  ///< by node minus root; only the leaves' are read
};

/// Photons, A_P, in structure-of-arrays form, with kReversePadding more elements.
struct ReversePhotons {
  const float *x, *y, *z;                       ///< metres
  const float* inverse_radius_squared;          ///< m^-2
  const float *normal_x, *normal_y, *normal_z;  ///< unit
  const float *r, *g, *b;                       ///< dPhi / (pi h^2) times the norm of the kernel, W m^-2
  float min_normal_cosine = 0;                  ///< photons count if the dot product of the normals is above this
  KernelShape kernel = KernelShape::epanechnikov;
};

/// Consecutive photons of A_P that are searched for together ([HHS05], section 6.3).
struct ReverseCluster {
  static constexpr std::uint32_t kMaxCount = 64;

  std::uint32_t first = 0, count = 0;  ///< photons
  float center[3] = {}, radius = 0;    ///< of a sphere around the supports of all photons, with a margin for rounding
  float min[3] = {}, max[3] = {};      ///< of a box around the same
};

/// Work of the searches.
struct ReverseCounts {
  std::uint64_t tested = 0;      ///< pairs whose distance was computed
  std::uint64_t operations = 0;  ///< pairs inside the kernel support with matching normals
  std::uint64_t steps = 0;       ///< a photon against a vector of reverse photons
  std::uint64_t nodes = 0;       ///< nodes visited
};

/// Adds to each point's sum the contributions of the clusters' photons: K / h^2 dPhi / pi, in the order of the photons.
/// The result has the same bits as single photons would give. All clusters descend the tree together, each as far as
/// its box reaches, and a leaf processes all its photons at once.
void reverse_sum(const ReverseSubtreeView& part, const ReversePhotons& photons,
                 std::span<const ReverseCluster> clusters, ReverseCounts& counts);

/// A photon inside the kernel support at a point.
struct ReversePair {
  std::uint32_t point;   ///< index in A_R
  std::uint32_t photon;  ///< index in A_P
  float profile;         ///< K over its norm
};

/// Appends the pairs that reverse_sum() would sum. Pairs of one point are in the order of their photons.
void reverse_collect(const ReverseSubtreeView& part, const ReversePhotons& photons,
                     std::span<const ReverseCluster> clusters, std::vector<ReversePair>& pairs, ReverseCounts& counts);

}  // namespace glowworm
