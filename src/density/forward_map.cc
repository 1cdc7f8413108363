// Builds the photon map of [SF07].
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "density/forward.h"
#include "density/kd_tree.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

// One thread builds subtrees below this number of photons.
constexpr std::size_t kParallelPhotons = 8192;
// From this number of photons on, a histogram narrows down the median first.
constexpr std::size_t kHistogramCount = 512;
constexpr std::size_t kBins = 256;
// Prefetch distance, in photons.
constexpr std::size_t kPrefetchDistance = 16;

/// Builds the tree: its nodes, and for each of them the index of its photon.
class TreeBuilder {
 public:
  TreeBuilder(LargeArray<ForwardNode>& nodes, LargeArray<std::uint32_t>& order) : nodes_(nodes), order_(order) {}

  /// Builds the subtree of the points, whose root becomes node `at`.
  /// @param scratch as large as the points
  void subtree(KdPoint* points, KdPoint* scratch, std::size_t count, std::size_t at) {
    if (count == 1) {
      set_node(at, points->index, 0, ForwardNode::kLeaf, 0);
      return;
    }
    Box3 box;
    for (std::size_t i = 0; i < count; ++i) box.grow(points[i].position);
    const int axis = box.longest_axis();
    const std::size_t left = count / 2, right = count - left - 1;
    const float low = box.min[axis], scale = static_cast<float>(kBins) / (box.max[axis] - low);
    if (count >= kHistogramCount && std::isfinite(scale)) {
      along(axis, [&](auto coordinate) { select_by_histogram(points, scratch, left, count, coordinate, low, scale); });
      std::swap(points, scratch);
    } else {
      along(axis, [&](auto coordinate) { select(points, left, count, coordinate); });
    }
    const std::size_t right_at = right > 0 ? at + 1 + left : 0;
    set_node(at, points[left].index, points[left].position[axis], static_cast<std::uint32_t>(axis), right_at);
    const auto build_left = [&] { subtree(points, scratch, left, at + 1); };
    const auto build_right = [&] {
      if (right > 0) subtree(points + left + 1, scratch + left + 1, right, right_at);
    };
    if (count > kParallelPhotons) {
      parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
  }

 private:
  /// Calls `use` with a function that reads the coordinate along the axis, which is known at compile time.
  template <class Use>
  static void along(int axis, const Use& use) {
    switch (axis) {
      case 0:
        return use([](const KdPoint& p) { return p.position.x; });
      case 1:
        return use([](const KdPoint& p) { return p.position.y; });
      default:
        return use([](const KdPoint& p) { return p.position.z; });
    }
  }

  template <class Coordinate>
  static void select(KdPoint* points, std::size_t nth, std::size_t count, const Coordinate& coordinate) {
    std::nth_element(points, points + nth, points + count,
                     [coordinate](const KdPoint& a, const KdPoint& b) { return coordinate(a) < coordinate(b); });
  }

  /// Moves the points to `to` so that the nth element is where sorting along the axis would put it, smaller ones before
  /// it and larger ones after it. Bins of equal width along the axis narrow the nth down to a few points. Every point
  /// is then copied once, without a branch on the data, and only those few are searched.
  /// @param low, scale start of the bins, and bins per metre
  template <class Coordinate>
  static void select_by_histogram(const KdPoint* points, KdPoint* to, std::size_t nth, std::size_t count,
                                  const Coordinate& coordinate, float low, float scale) {
    // Rounding is monotone: a larger coordinate never falls into a lower bin.
    const auto bin = [&](const KdPoint& p) {
      return std::min(static_cast<std::size_t>((coordinate(p) - low) * scale), kBins - 1);
    };
    std::array<std::uint32_t, kBins> counts{};
    for (std::size_t i = 0; i < count; ++i) ++counts[bin(points[i])];
    std::size_t before = 0, middle = 0;
    while (before + counts[middle] <= nth) before += counts[middle++];
    const std::size_t inside = counts[middle];
    std::size_t next[3] = {0, before, before + inside};
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t b = bin(points[i]);
      to[next[(b >= middle) + (b > middle)]++] = points[i];
    }
    select(to + before, nth - before, inside, coordinate);
  }

  void set_node(std::size_t at, std::uint32_t photon, float split, std::uint32_t axis, std::size_t right) {
    nodes_[at] = {(std::bit_cast<std::uint32_t>(split) & ~ForwardNode::kAxisMask) | axis,
                  static_cast<std::uint32_t>(right)};
    order_[at] = photon;
  }

  LargeArray<ForwardNode>& nodes_;
  LargeArray<std::uint32_t>& order_;
};

/// Reorders the photons' data by node.
void fill_photons(const PhotonBatch& photons, std::span<const RGB> fluxes, const RadiusPolicy& policy,
                  const LargeArray<std::uint32_t>& order, ForwardMap& map) {
  const bool own = policy.kind == RadiusKind::per_photon;
  const float norm = static_cast<float>(kernel_norm(policy.kernel)) * kInversePi;
  const std::size_t count = order.size();
  parallel_for_each(count, kParallelPhotons, [&](std::size_t at) {
    // Photons are in memory in the order of tracing, which is random in space.
    const std::uint32_t soon = order[std::min(at + kPrefetchDistance, count - 1)];
    __builtin_prefetch(&photons.position[soon]);
    __builtin_prefetch(&fluxes[soon]);
    __builtin_prefetch(&photons.normal[soon]);
    __builtin_prefetch(&photons.direction[soon]);
    const std::uint32_t index = order[at];
    const float radius = own ? policy.radii[index] : policy.radius;
    const float inverse = 1 / (radius * radius);
    const bool counts = std::isfinite(inverse);
    const Vec3 position = photons.position[index], normal = photons.normal[index];
    const RGB flux = fluxes[index] * (counts ? inverse * norm : 0.0f);
    map.hot[at] = {position.x, position.y, position.z, counts ? inverse : std::numeric_limits<float>::infinity()};
    map.cold[at] = {{flux.r, flux.g, flux.b}, {normal.x, normal.y, normal.z}};
    map.direction[at] = photons.direction[index];
    if (own) map.reach[at] = {radius, 0, 0};
  });
}

/// Split positions lose their lowest two bits to the axis: an error of up to three units in the last place.
float split_slack(const Box3& bounds) {
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max({largest, std::abs(bounds.min[axis]), std::abs(bounds.max[axis])});
  }
  return std::max(largest * 0x1p-21f, std::numeric_limits<float>::min());
}

float widened(float radius, float slack) { return radius * 1.000001f + slack; }

/// Adds the slack to the radii of the nodes' photons, and computes the reach of the subtrees.
void find_reach(const LargeArray<ForwardNode>& nodes, LargeArray<ForwardReach>& reach, float slack) {
  const auto largest = [&](std::size_t at) { return std::max({reach[at].own, reach[at].left, reach[at].right}); };
  // Children follow their parents.
  for (std::size_t at = reach.size(); at-- > 0;) {
    reach[at].own = widened(reach[at].own, slack);
    if ((nodes[at].split & ForwardNode::kAxisMask) == ForwardNode::kLeaf) continue;
    reach[at].left = largest(at + 1);
    if (nodes[at].right != 0) reach[at].right = largest(nodes[at].right);
  }
}

}  // namespace

ForwardTree ForwardMap::tree(const RadiusPolicy& policy) const {
  ForwardTree tree;
  tree.nodes = nodes.data();
  tree.hot = hot.data();
  tree.cold = cold.data();
  tree.reach = reach.size() == 0 ? nullptr : reach.data();
  tree.fixed_reach = fixed_reach;
  tree.count = static_cast<std::uint32_t>(nodes.size());
  tree.min_normal_cosine = policy.min_normal_cosine;
  tree.kernel = policy.kernel;
  return tree;
}

ForwardMap build_forward_map(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy) {
  const std::size_t count = photons.size();
  if (count >= std::numeric_limits<std::uint32_t>::max()) throw Error("a photon map holds fewer than 2^32 photons");
  ForwardMap map;
  map.bounds = photons.bounds();
  if (count == 0) return map;
  map.nodes = LargeArray<ForwardNode>(count);
  map.hot = LargeArray<ForwardHot>(count);
  map.cold = LargeArray<ForwardCold>(count);
  map.direction = LargeArray<Vec3>(count);
  if (policy.kind == RadiusKind::per_photon) map.reach = LargeArray<ForwardReach>(count);
  LargeArray<KdPoint> points(count), scratch(count);
  parallel_for_each(count, kParallelPhotons, [&](std::size_t i) {
    points[i] = {photons.position[i], static_cast<std::uint32_t>(i)};
  });
  LargeArray<std::uint32_t> order(count);
  TreeBuilder(map.nodes, order).subtree(points.data(), scratch.data(), count, 0);
  fill_photons(photons, flux, policy, order, map);
  const float slack = split_slack(map.bounds);
  map.fixed_reach = widened(policy.radius, slack);
  find_reach(map.nodes, map.reach, slack);
  return map;
}

}  // namespace glowworm
