#include "density/kd_tree.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

// One thread builds subtrees below this number of points.
constexpr std::size_t kParallelPoints = 16384;
// Below this depth cells are halved by count, which bounds the depth even if distances shrink without end: two levels
// for each halving with equal coordinates, and one for each axis on which all coordinates are equal.
constexpr int kMidpointDepth = 64;
// Points whose extent along an axis is less than this share of their widest extent lie on one surface across that axis.
constexpr float kFlat = 1e-3f;
// Points that one piece of work copies.
constexpr std::size_t kPointGrain = 65536;
constexpr std::size_t kMaxPoints = std::size_t{1} << 30;

/// A KdPoint as one block of memory: compilers copy structures member by member.
using Row [[gnu::vector_size(16), gnu::may_alias]] = float;
static_assert(sizeof(KdPoint) == sizeof(Row) && alignof(KdPoint) == alignof(Row) && offsetof(KdPoint, position) == 0);

struct Split {
  int axis = -1;  // -1: all points coincide
  float position = 0;
  std::size_t left_count = 0;
};

class Builder {
 public:
  Builder(std::span<KdPoint> points, std::span<KdPoint> scratch, std::uint32_t leaf_size)
      : points_(points), scratch_(scratch), leaf_size_(leaf_size) {}

  void build(std::vector<KdNode>& nodes, const Box3& bounds) {
    subtree({points_.data(), scratch_.data(), points_.size(), false}, bounds, 0, nodes);
  }

 private:
  /// A run of points in `from`; partitioning writes them to `to`. The two arrays change roles at every level; `swapped`
  /// means that `from` is the scratch array.
  struct Run {
    KdPoint* from;
    KdPoint* to;
    std::size_t count;
    bool swapped;
  };

  void subtree(Run run, const Box3& cell, int depth, std::vector<KdNode>& nodes) {
    Split split;
    if (run.count > leaf_size_) split = choose_split(run, cell, depth);
    if (split.axis < 0) {
      leaf(run, nodes);
      return;
    }
    const Run left{run.to, run.from, split.left_count, !run.swapped};
    const Run right{run.to + split.left_count, run.from + split.left_count, run.count - split.left_count, !run.swapped};
    Box3 left_cell = cell, right_cell = cell;
    left_cell.max[split.axis] = split.position;
    right_cell.min[split.axis] = split.position;
    const std::size_t self = nodes.size();
    nodes.emplace_back();
    if (run.count < kParallelPoints) {
      subtree(left, left_cell, depth + 1, nodes);
      close(nodes, self, split);
      subtree(right, right_cell, depth + 1, nodes);
      return;
    }
    std::vector<KdNode> left_nodes, right_nodes;
    parallel_invoke([&] { subtree(left, left_cell, depth + 1, left_nodes); },
                    [&] { subtree(right, right_cell, depth + 1, right_nodes); });
    nodes.insert(nodes.end(), left_nodes.begin(), left_nodes.end());
    close(nodes, self, split);
    nodes.insert(nodes.end(), right_nodes.begin(), right_nodes.end());
  }

  /// Completes inner node `self` after its whole left subtree has been appended to nodes.
  static void close(std::vector<KdNode>& nodes, std::size_t self, const Split& split) {
    nodes[self].split = split.position;
    nodes[self].bits = static_cast<std::uint32_t>((nodes.size() - self) << 2) | static_cast<std::uint32_t>(split.axis);
  }

  void leaf(const Run& run, std::vector<KdNode>& nodes) {
    if (run.swapped) std::copy_n(run.from, run.count, run.to);
    const KdPoint* first = run.swapped ? run.to : run.from;
    KdNode node;
    node.count = static_cast<std::uint32_t>(run.count);
    node.bits = static_cast<std::uint32_t>((first - points_.data()) << 2) | KdNode::kLeaf;
    nodes.push_back(node);
  }

  /// Finds the plane and partitions the run into run.to.
  static Split choose_split(const Run& run, const Box3& cell, int depth) {
    if (depth >= kMidpointDepth) return halve(run);
    int axis = cell.longest_axis();
    const float middle = 0.5f * cell.min[axis] + 0.5f * cell.max[axis];
    std::size_t left = partition(run, axis, middle);
    if (left > 0 && left < run.count) return {axis, middle, left};

    // One side is empty. Slide along this axis. If its coordinates are all equal but for rounding, split the widest
    // axis: a plane between coordinates of a wall that differ by rounding would divide its photons at random into two
    // sets over the same area.
    const Box3 tight = bounds_of(run);
    const Vec3 extent = tight.diagonal();
    const int widest = tight.longest_axis();
    if (!(extent[widest] > 0)) return {};
    float plane;
    if (extent[axis] > kFlat * extent[widest]) {
      plane = left == 0 ? tight.min[axis] : std::nextafter(tight.max[axis], tight.min[axis]);
    } else {
      axis = widest;
      plane = 0.5f * tight.min[axis] + 0.5f * tight.max[axis];
      if (!(plane < tight.max[axis])) plane = tight.min[axis];
    }
    left = partition(run, axis, plane);
    return {axis, plane, left};
  }

  static Box3 bounds_of(const Run& run) {
    const auto* from = reinterpret_cast<const Row*>(run.from);
    Row low = from[0], high = from[0];
    for (std::size_t i = 1; i < run.count; ++i) {
      const Row row = from[i];
      low = row < low ? row : low;
      high = row > high ? row : high;
    }
    Box3 box;
    box.grow(Vec3{low[0], low[1], low[2]});
    box.grow(Vec3{high[0], high[1], high[2]});
    return box;
  }

  /// Splits the widest axis at the median; planes lie between different coordinates only.
  static Split halve(const Run& run) {
    const Box3 tight = bounds_of(run);
    const int axis = tight.longest_axis();
    if (!(tight.min[axis] < tight.max[axis])) return {};
    KdPoint* const middle = run.from + run.count / 2;
    std::nth_element(run.from, middle, run.from + run.count, [axis](const KdPoint& a, const KdPoint& b) {
      return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.index < b.index;
    });
    float plane = middle->position[axis];
    if (!(plane < tight.max[axis])) plane = std::nextafter(tight.max[axis], tight.min[axis]);
    return {axis, plane, partition(run, axis, plane)};
  }

  /// Writes the points at or below the plane to the front of run.to, and the others, in reverse, to its back. No branch
  /// depends on the data: each point is written to both places, and one of the two positions advances.
  static std::size_t partition(const Run& run, int axis, float plane) {
    switch (axis) {
      case 0:
        return partition_along<0>(run, plane);
      case 1:
        return partition_along<1>(run, plane);
      default:
        return partition_along<2>(run, plane);
    }
  }
  template <int kAxis>
  static std::size_t partition_along(const Run& run, float plane) {
    const auto* from = reinterpret_cast<const Row*>(run.from);
    auto* const begin = reinterpret_cast<Row*>(run.to);
    Row* to = begin;
    // Free places between front and back equal the points to come.
    for (auto between = static_cast<std::ptrdiff_t>(run.count) - 1; between >= 0; --between) {
      const Row row = *from++;
      to[0] = row;
      to[between] = row;
      to += row[kAxis] <= plane;
    }
    return static_cast<std::size_t>(to - begin);
  }

  std::span<KdPoint> points_, scratch_;
  std::uint32_t leaf_size_;
};

}  // namespace

KdTree build_kd_tree(std::span<const Vec3> positions, std::uint32_t leaf_size) {
  if (positions.size() >= kMaxPoints) throw Error("a photon map holds fewer than 2^30 photons at once");
  KdTree tree;
  tree.points = LargeArray<KdPoint>(positions.size());
  parallel_for_each(positions.size(), kPointGrain, [&](std::size_t i) {
    tree.points[i] = {positions[i], static_cast<std::uint32_t>(i)};
  });
  LargeArray<KdPoint> scratch(tree.points.size());
  KdNodes built = build_kd_tree(tree.points.span(), scratch.span(), leaf_size);
  tree.nodes = std::move(built.nodes);
  tree.bounds = built.bounds;
  return tree;
}

KdNodes build_kd_tree(std::span<KdPoint> points, std::span<KdPoint> scratch, std::uint32_t leaf_size) {
  if (points.size() >= kMaxPoints) throw Error("a kd-tree holds fewer than 2^30 points");
  KdNodes tree;
  if (points.empty()) return tree;
  std::vector<Box3> parts((points.size() + kPointGrain - 1) / kPointGrain);
  parallel_for(0, points.size(), kPointGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) parts[first / kPointGrain].grow(points[i].position);
  });
  for (const Box3& part : parts) tree.bounds.grow(part);
  Builder(points, scratch, std::max(leaf_size, 1u)).build(tree.nodes, tree.bounds);
  return tree;
}

}  // namespace glowworm
