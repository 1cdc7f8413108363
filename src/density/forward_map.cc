// Builds the photon map of [SF07].
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "density/forward.h"
#include "density/kd_tree.h"
#include "density/kernel.h"

namespace glowworm {

namespace {

// Below this many photons a subtree is built by one thread.
constexpr std::size_t kParallelCount = 8192;

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
  float subtree(KdPoint* points, std::size_t count, std::size_t at) {
    if (count == 1) return set_node(at, *points, ForwardNode::kLeaf, 0, 0);
    Box3 box;
    for (std::size_t i = 0; i < count; ++i) box.grow(points[i].position);
    const int axis = box.longest_axis();
    const std::size_t left = count / 2, right = count - left - 1;
    select(points, left, count, axis);
    const KdPoint median = points[left];
    const std::size_t right_at = right > 0 ? at + 1 + left : 0;
    float left_radius = 0, right_radius = 0;
    const auto build_left = [&] { left_radius = subtree(points, left, at + 1); };
    const auto build_right = [&] {
      if (right > 0) right_radius = subtree(points + left + 1, right, right_at);
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
  static void select(KdPoint* points, std::size_t nth, std::size_t count, int axis) {
    const auto by = [&](auto coordinate) {
      std::nth_element(points, points + nth, points + count, [coordinate](const KdPoint& a, const KdPoint& b) {
        return coordinate(a.position) < coordinate(b.position);
      });
    };
    switch (axis) {
      case 0:
        return by([](const Vec3& p) { return p.x; });
      case 1:
        return by([](const Vec3& p) { return p.y; });
      default:
        return by([](const Vec3& p) { return p.z; });
    }
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
  builder.subtree(points.data(), count, 0);
  return map;
}

}  // namespace glowworm
