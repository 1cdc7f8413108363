#include "density/kd_tree.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

// Below this many points a subtree is built by one thread.
constexpr std::size_t kParallelCount = 16384;
// Below this depth cells are halved by count, which bounds the depth for points at ever smaller distances: two levels
// a halving where coordinates are equal, and one an axis in which all are.
constexpr int kMidpointDepth = 64;
// Points that are copied by one piece of work.
constexpr std::size_t kPointGrain = 65536;
constexpr std::size_t kMaxPoints = std::size_t{1} << 30;

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
  /// A run of points: they lie in `from`, and partitioning writes them to `to`. The two change roles at every level;
  /// `swapped` says that `from` is the scratch array.
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
    if (run.count < kParallelCount) {
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

  /// Completes inner node `self`, all of whose left subtree stands at the end of nodes.
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

    // One side is empty. Slide along this axis, or where its coordinates are all equal, split the widest one.
    Box3 tight;
    for (std::size_t i = 0; i < run.count; ++i) tight.grow(run.from[i].position);
    float plane;
    if (tight.min[axis] < tight.max[axis]) {
      plane = left == 0 ? tight.min[axis] : std::nextafter(tight.max[axis], tight.min[axis]);
    } else {
      axis = tight.longest_axis();
      if (!(tight.min[axis] < tight.max[axis])) return {};
      plane = 0.5f * tight.min[axis] + 0.5f * tight.max[axis];
      if (!(plane < tight.max[axis])) plane = tight.min[axis];
    }
    left = partition(run, axis, plane);
    return {axis, plane, left};
  }

  /// Splits the widest axis at the median; the planes go between different coordinates only.
  static Split halve(const Run& run) {
    Box3 tight;
    for (std::size_t i = 0; i < run.count; ++i) tight.grow(run.from[i].position);
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

  /// Writes the points at or under the plane to the front of run.to, the others, in reverse, to its back. Without a
  /// branch on the data: both places are written, only one pointer moves on.
  static std::size_t partition(const Run& run, int axis, float plane) {
    switch (axis) {
      case 0:
        return partition_by(run, [plane](const KdPoint& p) { return p.position.x <= plane; });
      case 1:
        return partition_by(run, [plane](const KdPoint& p) { return p.position.y <= plane; });
      default:
        return partition_by(run, [plane](const KdPoint& p) { return p.position.z <= plane; });
    }
  }
  template <class IsLeft>
  static std::size_t partition_by(const Run& run, const IsLeft& is_left) {
    std::size_t left = 0, right = run.count - 1;
    for (std::size_t i = 0; i < run.count; ++i) {
      const bool to_left = is_left(run.from[i]);
      run.to[left] = run.from[i];
      run.to[right] = run.from[i];
      left += to_left;
      right -= !to_left;
    }
    return left;
  }

  std::span<KdPoint> points_, scratch_;
  std::uint32_t leaf_size_;
};

}  // namespace

KdTree build_kd_tree(std::span<const Vec3> positions, std::uint32_t leaf_size) {
  if (positions.size() >= kMaxPoints) throw Error("a photon map holds fewer than 2^30 photons at once");
  LargeArray<KdPoint> points(positions.size());
  parallel_for(0, positions.size(), kPointGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) points[i] = {positions[i], static_cast<std::uint32_t>(i)};
  });
  return build_kd_tree(std::move(points), leaf_size);
}

KdTree build_kd_tree(LargeArray<KdPoint> points, std::uint32_t leaf_size) {
  KdTree tree;
  tree.points = std::move(points);
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
