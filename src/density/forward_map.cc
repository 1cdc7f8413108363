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
#include "density/kernel.h"

namespace glowworm {

namespace {

// Below this many photons a subtree is built by one thread.
constexpr std::size_t kParallelCount = 8192;
// From this many photons on the median is narrowed down by a histogram first.
constexpr std::size_t kHistogramCount = 512;
constexpr std::size_t kBins = 256;

class Builder {
 public:
  Builder(const PhotonBatch& photons, const RadiusPolicy& policy, ForwardMap& map)
      : photons_(photons),
        policy_(policy),
        map_(map),
        norm_(static_cast<float>(kernel_norm(policy.kernel)) * kInversePi) {
    // Split positions lose their lowest two bits to the axis: up to three units in the last place.
    float largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      largest = std::max({largest, std::abs(map.bounds.min[axis]), std::abs(map.bounds.max[axis])});
    }
    slack_ = std::max(largest * 0x1p-21f, std::numeric_limits<float>::min());
  }

  float reach_of(float radius) const { return radius * 1.000001f + slack_; }

  /// Builds the subtree of the points, whose root becomes node `at`. Returns its largest radius.
  /// @param scratch as much room as the points take
  float subtree(KdPoint* points, KdPoint* scratch, std::size_t count, std::size_t at) {
    if (count == 1) return set_node(at, *points, ForwardNode::kLeaf, 0, 0);
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
    const KdPoint median = points[left];
    const std::size_t right_at = right > 0 ? at + 1 + left : 0;
    float left_radius = 0, right_radius = 0;
    const auto build_left = [&] { left_radius = subtree(points, scratch, left, at + 1); };
    const auto build_right = [&] {
      if (right > 0) right_radius = subtree(points + left + 1, scratch + left + 1, right, right_at);
    };
    if (count > kParallelCount) {
      parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
    return set_node(at, median, static_cast<std::uint32_t>(axis), right_at, std::max(left_radius, right_radius));
  }

 private:
  /// Calls `use` with a function that reads the coordinate along the axis, known when that is compiled.
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

  /// Moves the points to `to` so that the nth stands where sorting along the axis would put it, smaller ones before
  /// it and greater ones behind. Bins of equal width along the axis tell which few points the nth is among; every
  /// point is then copied once, without a branch on the data, and only those few are searched.
  /// @param low, scale bins begin there, and there are so many to the metre
  template <class Coordinate>
  static void select_by_histogram(const KdPoint* points, KdPoint* to, std::size_t nth, std::size_t count,
                                  const Coordinate& coordinate, float low, float scale) {
    // Rounding is monotone: a greater coordinate never goes to a lower bin.
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

  /// Writes a node with its photon's data. Returns the largest radius of its subtree.
  float set_node(std::size_t at, const KdPoint& point, std::uint32_t axis, std::size_t right, float radius_below) {
    const float split = axis == ForwardNode::kLeaf ? 0 : point.position[static_cast<int>(axis)];
    map_.nodes[at] = {(std::bit_cast<std::uint32_t>(split) & ~ForwardNode::kAxisMask) | axis,
                      static_cast<std::uint32_t>(right)};
    const std::uint32_t index = point.index;
    const bool own = policy_.kind == RadiusKind::per_photon;
    const float radius = own ? policy_.radii[index] : policy_.radius;
    const float inverse = 1 / (radius * radius);
    const bool counts = std::isfinite(inverse);
    map_.hot[at] = {point.position.x, point.position.y, point.position.z,
                    counts ? inverse : std::numeric_limits<float>::infinity()};
    const RGB flux = photons_.flux[index] * (counts ? inverse * norm_ : 0.0f);
    const Vec3 normal = photons_.normal[index];
    map_.cold[at] = {{flux.r, flux.g, flux.b}, {normal.x, normal.y, normal.z}};
    map_.direction[at] = photons_.direction[index];
    const float largest = std::max(radius, radius_below);
    if (own) map_.reach[at] = reach_of(largest);
    return largest;
  }

  const PhotonBatch& photons_;
  const RadiusPolicy& policy_;
  ForwardMap& map_;
  float norm_;
  float slack_;
};

}  // namespace

ForwardTree ForwardMap::tree(const RadiusPolicy& policy) const {
  ForwardTree tree;
  tree.nodes = nodes.data();
  tree.hot = hot.data();
  tree.cold = cold.data();
  tree.reach = reach.empty() ? nullptr : reach.data();
  tree.fixed_reach = fixed_reach;
  tree.count = static_cast<std::uint32_t>(nodes.size());
  tree.min_normal_cosine = policy.min_normal_cosine;
  tree.kernel = static_cast<ForwardKernel>(policy.kernel);
  return tree;
}

ForwardMap build_forward_map(const PhotonBatch& photons, const RadiusPolicy& policy) {
  const std::size_t count = photons.size();
  if (count >= std::numeric_limits<std::uint32_t>::max()) throw Error("a photon map holds fewer than 2^32 photons");
  ForwardMap map;
  map.bounds = photons.bounds();
  map.nodes.resize(count);
  map.hot.resize(count);
  map.cold.resize(count);
  map.direction.resize(count);
  map.reach.resize(policy.kind == RadiusKind::per_photon ? count : 0);
  if (count == 0) return map;
  std::vector<KdPoint> points(count);
  for (std::size_t i = 0; i < count; ++i) points[i] = {photons.position[i], static_cast<std::uint32_t>(i)};
  Builder builder(photons, policy, map);
  map.fixed_reach = builder.reach_of(policy.radius);
  std::vector<KdPoint> scratch(count);
  builder.subtree(points.data(), scratch.data(), count, 0);
  return map;
}

}  // namespace glowworm
