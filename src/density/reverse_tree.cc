#include "density/reverse_tree.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

// More coincident points than this in one leaf of the kd-tree make a tree of their own.
static_assert(ReverseNode::kMaxDepth >= KdTree::kMaxDepth + 27);
static_assert(ReverseTree::kLeafSize <= ReverseNode::kMaxCount);

// Points are copied into A_R in pieces of so many subtrees.
constexpr std::size_t kSubtreeGrain = 4;
// Prefetch distance, in points.
constexpr std::size_t kPointsAhead = 32;
// Points in one piece of work.
constexpr std::size_t kTreePointGrain = 65536;

/// Turns a kd-tree into the nodes of the reverse photon map, and cuts it into subtrees.
class Converter {
 public:
  Converter(const KdNodes& tree, std::span<const KdPoint> points, std::vector<ReverseNode>& nodes,
            std::vector<ReverseSubtree>& subtrees)
      : tree_(tree), points_(points), nodes_(nodes), subtrees_(subtrees) {}

  void run() {
    nodes_.reserve(tree_.nodes.size());
    node(0, 0, static_cast<std::uint32_t>(points_.size()), tree_.bounds, false);
  }

 private:
  /// Appends the subtree of node `from`, which holds `count` points from `first` on.
  void node(std::uint32_t from, std::uint32_t first, std::uint32_t count, const Box3& cell, bool in_subtree) {
    const KdNode source = tree_.nodes[from];
    if (source.is_leaf()) {
      leaf(first, count, cell, in_subtree);
      return;
    }
    const std::size_t subtree = open(first, count, in_subtree);
    const std::uint32_t right = from + source.right_offset();
    const std::uint32_t left_count = first_point(right) - first;
    Box3 left_cell = cell, right_cell = cell;
    left_cell.max[source.axis()] = source.split;
    right_cell.min[source.axis()] = source.split;
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    node(from + 1, first, left_count, left_cell, in_subtree || subtree != kNone);
    nodes_[self] = ReverseNode::inner(source.axis(), source.split, static_cast<std::uint32_t>(nodes_.size()));
    node(right, first + left_count, count - left_count, right_cell, in_subtree || subtree != kNone);
    close(subtree);
  }

  /// A leaf. If more points coincide than it can count, a tree of leaves with its planes through them.
  void leaf(std::uint32_t first, std::uint32_t count, const Box3& cell, bool in_subtree) {
    const std::size_t subtree = open(first, count, in_subtree);
    if (count <= ReverseNode::kMaxCount) {
      const float diagonal = std::min(length(cell.diagonal()), std::numeric_limits<float>::max() / 2);
      nodes_.push_back(ReverseNode::leaf(first, count, diagonal));
    } else {
      const std::uint32_t half = count / 2;
      const std::size_t self = nodes_.size();
      nodes_.emplace_back();
      leaf(first, half, cell, in_subtree || subtree != kNone);
      nodes_[self] = ReverseNode::inner(0, points_[first].position.x, static_cast<std::uint32_t>(nodes_.size()));
      leaf(first + half, count - half, cell, in_subtree || subtree != kNone);
    }
    close(subtree);
  }

  std::uint32_t first_point(std::uint32_t from) const {
    while (!tree_.nodes[from].is_leaf()) ++from;
    return tree_.nodes[from].first();
  }

  static constexpr std::size_t kNone = ~std::size_t{0};

  /// Begins a subtree at the next node unless one is open, if the node is small enough or a leaf.
  std::size_t open(std::uint32_t first, std::uint32_t count, bool in_subtree) {
    if (in_subtree || count > ReverseTree::kSubtreePoints) return kNone;
    subtrees_.push_back({static_cast<std::uint32_t>(nodes_.size()), 0, first, count});
    return subtrees_.size() - 1;
  }
  void close(std::size_t subtree) {
    if (subtree != kNone)
      subtrees_[subtree].node_count = static_cast<std::uint32_t>(nodes_.size()) - subtrees_[subtree].root;
  }

  const KdNodes& tree_;
  std::span<const KdPoint> points_;
  std::vector<ReverseNode>& nodes_;
  std::vector<ReverseSubtree>& subtrees_;
};

/// The first elements of an array, which grows if it is too small.
template <typename T>
std::span<T> take(LargeArray<T>& memory, std::size_t count) {
  if (memory.size() < count) {
    memory = LargeArray<T>();
    memory = LargeArray<T>(count);
  }
  return memory.span().first(count);
}

/// The chosen points with finite positions, with their targets as indices.
std::span<KdPoint> finite_points(const QueryPoints& points, std::span<const std::uint32_t> chosen,
                                 ReverseMemory& memory) {
  std::vector<std::size_t> starts((chosen.size() + kTreePointGrain - 1) / kTreePointGrain + 1, 0);
  parallel_for(0, chosen.size(), kTreePointGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      starts[first / kTreePointGrain + 1] += is_finite(points.position[chosen[i]]);
  });
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  const std::span<KdPoint> found = take(memory.points, starts.back());
  parallel_for(0, chosen.size(), kTreePointGrain, [&](std::size_t first, std::size_t last) {
    std::size_t to = starts[first / kTreePointGrain];
    for (std::size_t i = first; i < last; ++i) {
      const Vec3 position = points.position[chosen[i]];
      if (is_finite(position)) found[to++] = {position, chosen[i]};
    }
  });
  return found;
}

/// Prefetches a point's data, which is scattered in memory in the order of the rays.
void prefetch_point(std::span<const KdPoint> sorted, std::size_t i, const QueryPoints& points) {
  if (i >= sorted.size()) return;
  __builtin_prefetch(&points.normal[sorted[i].index]);
  __builtin_prefetch(&points.bsdf[sorted[i].index]);
}

/// Writes one leaf of A_R.
void fill_leaf(const ReverseNode& leaf, std::span<const KdPoint> sorted, const QueryPoints& points, float* to) {
  const std::size_t n = leaf.count();
  to += std::size_t{leaf.first()} * kReverseFields;
  for (std::size_t i = 0; i < n; ++i) {
    prefetch_point(sorted, leaf.first() + i + kPointsAhead, points);
    const KdPoint& point = sorted[leaf.first() + i];
    const Vec3 normal = points.normal[point.index];
    const float fields[6] = {point.position.x, point.position.y, point.position.z, normal.x, normal.y, normal.z};
    for (std::size_t f = 0; f < 6; ++f) to[f * n + i] = fields[f];
    std::memcpy(to + 6 * n + i, &point.index, sizeof point.index);
    std::memcpy(to + 7 * n + i, &points.bsdf[point.index], sizeof(float));
  }
}

ReverseLeafBounds measure_leaf(const float* points, std::size_t n) {
  ReverseLeafBounds bounds;
  bool equal = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float *places = points + axis * n, *normals = points + (3 + axis) * n;
    bounds.min[axis] = bounds.max[axis] = places[0];
    for (std::size_t i = 0; i < n; ++i) {
      bounds.min[axis] = std::min(bounds.min[axis], places[i]);
      bounds.max[axis] = std::max(bounds.max[axis], places[i]);
      equal &= normals[i] == normals[0];
    }
  }
  const auto normal = [&](std::size_t i) { return Vec3{points[3 * n + i], points[4 * n + i], points[5 * n + i]}; };
  Vec3 middle = normal(0);
  float spread_squared = 0;
  if (!equal) {
    Vec3 sum{0, 0, 0};
    for (std::size_t i = 0; i < n; ++i) sum += normal(i);
    if (length(sum) > 0) middle = normalize(sum);
    for (std::size_t i = 0; i < n; ++i) spread_squared = std::max(spread_squared, length_squared(normal(i) - middle));
  }
  for (int axis = 0; axis < 3; ++axis) bounds.normal[axis] = middle[axis];
  // With a margin for the rounding of dot products.
  bounds.spread = std::sqrt(spread_squared) * 1.0001f + 1e-6f;
  return bounds;
}

}  // namespace

ReverseTree::ReverseTree(const QueryPoints& points, std::span<const std::uint32_t> chosen, std::uint32_t leaf_size,
                         ReverseMemory* memory) {
  if (chosen.size() >= ReverseNode::kMaxNodes / 2) throw Error("a reverse photon map holds fewer than 2^27 points");
  ReverseMemory& used = memory ? *memory : own_;
  const std::span<KdPoint> sorted = finite_points(points, chosen, used);
  size_ = static_cast<std::uint32_t>(sorted.size());
  points_ = take(used.fields, size_ * kReverseFields + kReversePadding);
  if (size_ > 0) {
    // A_R is filled when the tree is complete; until then its memory, which is twice as large, serves the build.
    const std::span<KdPoint> scratch(reinterpret_cast<KdPoint*>(points_.data()), size_);
    const KdNodes tree = build_kd_tree(sorted, scratch, std::clamp(leaf_size, 1u, ReverseNode::kMaxCount));
    Converter(tree, sorted, nodes_, subtrees_).run();
  }
  std::fill_n(points_.data() + size_ * kReverseFields, kReversePadding, 0.0f);
  parallel_for_each(subtrees_.size(), kSubtreeGrain, [&](std::size_t s) {
    const ReverseSubtree& subtree = subtrees_[s];
    for (std::uint32_t i = 0; i < subtree.node_count; ++i) {
      const ReverseNode& node = nodes_[subtree.root + i];
      if (node.is_leaf()) fill_leaf(node, sorted, points, points_.data());
    }
  });
}

Box3 ReverseTree::measure(const ReverseSubtree& subtree, const float* points,
                          std::vector<ReverseLeafBounds>& bounds) const {
  bounds.resize(subtree.node_count);
  Box3 box;
  for (std::uint32_t i = 0; i < subtree.node_count; ++i) {
    const ReverseNode& node = nodes_[subtree.root + i];
    if (!node.is_leaf()) continue;
    ReverseLeafBounds& leaf = bounds[i];
    leaf = measure_leaf(points + std::size_t{node.first() - subtree.first_point} * kReverseFields, node.count());
    box.grow({{leaf.min[0], leaf.min[1], leaf.min[2]}, {leaf.max[0], leaf.max[1], leaf.max[2]}});
  }
  return box;
}

}  // namespace glowworm
