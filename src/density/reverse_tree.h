// The reverse photon map of [HHS05]: a kd-tree over the query points of a task.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_array.h"
#include "density/kd_tree.h"
#include "kernels/reverse.h"
#include "points/query_points.h"

namespace glowworm {

/// A part of the tree for one thread: the nodes and points below a node.
struct ReverseSubtree {
  std::uint32_t root = 0, node_count = 0;
  std::uint32_t first_point = 0, point_count = 0;
};

/// Memory of a tree. It only grows and serves one tree after another, because the system need not clear memory that is
/// reused.
struct ReverseMemory {
  LargeArray<KdPoint> points;  ///< while the tree is built
  LargeArray<float> fields;    ///< A_R
};

/// A kd-tree over query points by the sliding-midpoint rule, whose leaves are runs of A_R.
class ReverseTree {
 public:
  /// Points in a leaf at most, T_m of [HHS05].
  static constexpr std::uint32_t kLeafSize = 32;
  /// Maximum number of points in a subtree: the working set of a thread stays in its cache.
  static constexpr std::uint32_t kSubtreePoints = 8192;

  /// Builds the tree on all threads; the result does not depend on their number.
  /// @param chosen the points to take, as indices that become the targets; points with positions that are not finite
  /// are left out. Fewer than 2^27.
  /// @param memory must outlive the tree; null: the tree has its own
  ReverseTree(const QueryPoints& points, std::span<const std::uint32_t> chosen, std::uint32_t leaf_size = kLeafSize,
              ReverseMemory* memory = nullptr);

  const std::vector<ReverseNode>& nodes() const { return nodes_; }
  /// In order of their points; together they hold all points.
  const std::vector<ReverseSubtree>& subtrees() const { return subtrees_; }
  std::uint32_t size() const { return size_; }
  /// A_R, in the layout of kReverseFields.
  std::span<const float> points() const { return points_; }

  /// Bounds of the leaves of a subtree, by node less root; returns the box of its points.
  /// @param points its part of A_R
  Box3 measure(const ReverseSubtree& subtree, const float* points, std::vector<ReverseLeafBounds>& bounds) const;

 private:
  std::vector<ReverseNode> nodes_;
  std::vector<ReverseSubtree> subtrees_;
  ReverseMemory own_;
  std::span<float> points_;
  std::uint32_t size_ = 0;
};

}  // namespace glowworm
