// A kd-tree over points by the sliding-midpoint rule.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/vec.h"

namespace glowworm {

/// A node of 8 bytes. Nodes are in depth-first preorder: the left child of an inner node follows it.
struct KdNode {
  static constexpr std::uint32_t kLeaf = 3;

  union {
    float split;          ///< inner: points with a coordinate <= split are on the left
    std::uint32_t count;  ///< leaf: number of points
  };
  std::uint32_t bits;  ///< low 2: axis or kLeaf; others: inner: distance to the right child, leaf: first point

  bool is_leaf() const { return (bits & 3) == kLeaf; }
  int axis() const { return static_cast<int>(bits & 3); }
  std::uint32_t right_offset() const { return bits >> 2; }
  std::uint32_t first() const { return bits >> 2; }
};
static_assert(sizeof(KdNode) == 8);

/// A point with its index in the array that the tree was built from. Aligned so that it moves as one block.
struct alignas(16) KdPoint {
  Vec3 position;
  std::uint32_t index;
};

/// The tree. Its points are in leaf order, so that every leaf and every subtree is a run of them.
struct KdTree {
  /// Maximum depth of any leaf; stacks may have this size.
  static constexpr int kMaxDepth = 128;

  LargeArray<KdPoint> points;
  std::vector<KdNode> nodes;  ///< empty if there are no points
  Box3 bounds;                ///< of the points
};

/// Builds a tree on all threads; the result does not depend on their number. A cell is split at the middle of its
/// longest side. If one side would be empty, the plane slides to the nearest point (Maneewongvatana and Mount, "It's
/// Okay to Be Skinny, If Your Friends Are Fat", 1999), or, if the points lie on a surface across that side, their
/// widest extent is split instead. Leaves hold at most `leaf_size` points, or more that all coincide.
/// @param positions fewer than 2^30, finite
KdTree build_kd_tree(std::span<const Vec3> positions, std::uint32_t leaf_size);

/// A tree that does not own its points.
struct KdNodes {
  std::vector<KdNode> nodes;
  Box3 bounds;
};
/// As above, in the caller's memory: reorders `points` by leaf.
/// @param scratch as long as points
KdNodes build_kd_tree(std::span<KdPoint> points, std::span<KdPoint> scratch, std::uint32_t leaf_size);

}  // namespace glowworm
