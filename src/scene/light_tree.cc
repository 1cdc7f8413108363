#include "scene/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame.h"

namespace glowworm {

namespace {

constexpr int kBuckets = 12;
/// Below this depth nodes are split in halves by number, so that every path fits into 64 bits.
constexpr int kDepthOfHalving = 24;
constexpr std::uint8_t kNotThere = 255;
/// Levels that irradiance() descends if the point is among the lights.
constexpr int kIrradianceLevels = 5;
/// A sum of two to the power of that many values is finite.
constexpr float kMaxImportance = std::numeric_limits<float>::max() / (1 << (kIrradianceLevels + 1));
/// Minimum area of a cluster, relative to the box around all lights: point lights have no area.
constexpr double kMinArea = 1e-12;

float safe_acos(float x) { return std::acos(std::clamp(x, -1.0f, 1.0f)); }

/// An angle in [0, pi]. Differences of angles need no inverse trigonometric function (pbrt-v4, section 12.6.3).
struct Angle {
  float cosine, sine;
  static Angle of_cosine(float c) { return {c, std::sqrt(std::max(1 - c * c, 0.0f))}; }
  /// This angle minus another one, but at least 0.
  Angle minus(Angle other) const {
    if (cosine >= other.cosine) return {1, 0};
    return {cosine * other.cosine + sine * other.sine, std::max(sine * other.cosine - cosine * other.sine, 0.0f)};
  }
};
/// 1/1000, a margin for rounding.
constexpr Angle kMargin{0.9999995f, 0.001f};

struct Cone {
  Vec3 axis;
  float cosine;
};

/// The smallest cone that contains both.
Cone merge_cones(Cone a, Cone b) {
  float angle_a = safe_acos(a.cosine), angle_b = safe_acos(b.cosine);
  if (angle_b > angle_a) {
    std::swap(a, b);
    std::swap(angle_a, angle_b);
  }
  const float between = safe_acos(dot(a.axis, b.axis));
  if (std::min(between + angle_b, kPi) <= angle_a) return a;
  const float angle = (angle_a + between + angle_b) / 2;
  if (angle >= kPi) return {a.axis, -1};
  // Rotated from a's axis towards b's.
  const Vec3 across = b.axis - a.axis * dot(a.axis, b.axis);
  if (!(length_squared(across) > 1e-12f)) return {a.axis, -1};
  const float turn = angle - angle_a;
  return {normalize(a.axis * std::cos(turn) + normalize(across) * std::sin(turn)), std::cos(angle)};
}

/// The measure of directions in which lights emit (Conty Estevez and Kulla 2018, section 4.4, M_Omega).
double orientation_measure(const LightBounds& b) {
  const double normals = safe_acos(b.cos_normals), emission = safe_acos(b.cos_emission);
  const double widest = std::min(normals + emission, M_PI);
  return 2 * M_PI * (1 - std::cos(normals)) + M_PI / 2 *
                                                  (2 * widest * std::sin(normals) - std::cos(normals - 2 * widest) -
                                                   2 * normals * std::sin(normals) + std::cos(normals));
}

double surface_area(const Box3& box) {
  const Vec3 d = box.diagonal();
  return 2 * (static_cast<double>(d.x) * d.y + static_cast<double>(d.y) * d.z + static_cast<double>(d.z) * d.x);
}

}  // namespace

LightBounds merge(const LightBounds& a, const LightBounds& b) {
  if (!(a.intensity > 0)) return b;
  if (!(b.intensity > 0)) return a;
  LightBounds out = a;
  out.box.grow(b.box);
  const Cone cone = merge_cones({a.axis, a.cos_normals}, {b.axis, b.cos_normals});
  out.axis = cone.axis;
  out.cos_normals = cone.cosine;
  out.cos_emission = std::min(a.cos_emission, b.cos_emission);
  out.two_sided = a.two_sided || b.two_sided;
  out.intensity = a.intensity + b.intensity;
  return out;
}

float light_importance(const LightBounds& lights, Vec3 position) {
  const Vec3 offset = position - lights.box.center();
  const float squared = length_squared(offset), radius_squared = length_squared(lights.box.diagonal()) / 4;
  // At a point light itself, the largest value that stays finite when summed over many lights.
  const auto over_squares = [&](float intensity) {
    return std::min(intensity / std::max(squared, radius_squared), kMaxImportance);
  };
  // Inside the sphere around the lights, light may come from any direction.
  if (squared <= radius_squared || lights.cos_normals <= -1) return over_squares(lights.intensity);
  float cos_axis = dot(lights.axis, offset) / std::sqrt(squared);
  if (lights.two_sided) cos_axis = std::abs(cos_axis);
  const float share = std::min(radius_squared / squared, 1.0f);
  const Angle subtended{std::sqrt(1 - share), std::sqrt(share)};
  // With a margin, because a light that rounding makes black would never be chosen.
  const Angle off =
      Angle::of_cosine(cos_axis).minus(Angle::of_cosine(lights.cos_normals)).minus(subtended).minus(kMargin);
  if (off.cosine < lights.cos_emission) return 0;
  // Light that is emitted to angles beyond 90 degrees does not follow Lambert's cosine.
  return over_squares(lights.cos_emission < 0 ? lights.intensity : lights.intensity * off.cosine);
}

class LightTree::Builder {
 public:
  Builder(LightTree& tree, std::span<const LightBounds> lights) : tree_(tree), lights_(lights) {
    tree_.way_.assign(lights.size(), 0);
    tree_.depth_.assign(lights.size(), kNotThere);
    for (std::uint32_t i = 0; i < lights.size(); ++i)
      if (lights[i].intensity > 0) order_.push_back(i);
    if (order_.empty()) return;
    Box3 all;
    for (const std::uint32_t light : order_) all.grow(lights[light].box);
    least_area_ = kMinArea * length_squared(all.diagonal());
    tree_.nodes_.emplace_back();
    build(0, 0, order_.size(), 0, 0);
  }

 private:
  float middle(std::uint32_t light, int axis) const { return lights_[light].box.center()[axis]; }

  void build(std::uint32_t n, std::size_t first, std::size_t last, std::uint64_t way, int depth) {
    LightBounds bounds;
    Box3 centers;
    for (std::size_t i = first; i < last; ++i) {
      bounds = merge(bounds, lights_[order_[i]]);
      centers.grow(lights_[order_[i]].box.center());
    }
    tree_.nodes_[n].bounds = bounds;
    if (last - first == 1) {
      tree_.nodes_[n].light = order_[first];
      tree_.way_[order_[first]] = way;
      tree_.depth_[order_[first]] = static_cast<std::uint8_t>(depth);
      return;
    }
    const std::size_t half = split(bounds, centers, first, last, depth);
    const auto child = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_[n].child = child;
    tree_.nodes_.resize(child + 2);
    build(child, first, half, way, depth + 1);
    build(child + 1, half, last, way | (std::uint64_t{1} << depth), depth + 1);
  }

  /// Reorders the lights so that the left child's come first. Returns the first index of the right child.
  std::size_t split(const LightBounds& bounds, const Box3& centers, std::size_t first, std::size_t last, int depth) {
    double best = std::numeric_limits<double>::infinity();
    int best_axis = -1, best_bucket = 0;
    const Vec3 extent = bounds.box.diagonal();
    const float longest = std::max({extent.x, extent.y, extent.z});
    for (int axis = 0; axis < 3 && depth < kDepthOfHalving; ++axis) {
      if (!(centers.max[axis] > centers.min[axis])) continue;
      std::array<LightBounds, kBuckets> buckets{};
      for (std::size_t i = first; i < last; ++i) {
        LightBounds& bucket = buckets[static_cast<std::size_t>(bucket_of(order_[i], axis, centers))];
        bucket = merge(bucket, lights_[order_[i]]);
      }
      std::array<double, kBuckets> right_cost{};
      LightBounds right;
      for (int b = kBuckets - 1; b > 0; --b) {
        right = merge(right, buckets[static_cast<std::size_t>(b)]);
        right_cost[static_cast<std::size_t>(b)] = cost(right);
      }
      LightBounds left;
      for (int b = 1; b < kBuckets; ++b) {
        left = merge(left, buckets[static_cast<std::size_t>(b - 1)]);
        const double both = (cost(left) + right_cost[static_cast<std::size_t>(b)]) * (longest / extent[axis]);
        if (both >= best || !(left.intensity > 0) || !(right_cost[static_cast<std::size_t>(b)] > 0)) continue;
        best = both;
        best_axis = axis;
        best_bucket = b;
      }
    }
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first),
               end = order_.begin() + static_cast<std::ptrdiff_t>(last);
    if (best_axis >= 0) {
      const auto half = std::partition(
          begin, end, [&](std::uint32_t light) { return bucket_of(light, best_axis, centers) < best_bucket; });
      if (half != begin && half != end) return static_cast<std::size_t>(half - order_.begin());
    }
    return halve(centers, first, last);
  }

  std::size_t halve(const Box3& centers, std::size_t first, std::size_t last) {
    const Vec3 d = centers.diagonal();
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
    const std::size_t half = (first + last) / 2;
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(first),
                     order_.begin() + static_cast<std::ptrdiff_t>(half),
                     order_.begin() + static_cast<std::ptrdiff_t>(last), [&](std::uint32_t a, std::uint32_t b) {
                       const float x = middle(a, axis), y = middle(b, axis);
                       return x != y ? x < y : a < b;
                     });
    return half;
  }

  int bucket_of(std::uint32_t light, int axis, const Box3& centers) const {
    const float at = (middle(light, axis) - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    return std::clamp(static_cast<int>(at * kBuckets), 0, kBuckets - 1);
  }

  /// Conty Estevez and Kulla 2018, equation 2, without the node's own measures, which are equal for all splits.
  double cost(const LightBounds& b) const {
    if (!(b.intensity > 0)) return 0;
    return b.intensity * orientation_measure(b) * std::max(surface_area(b.box), least_area_);
  }

  LightTree& tree_;
  std::span<const LightBounds> lights_;
  std::vector<std::uint32_t> order_;
  double least_area_ = 0;
};

LightTree::LightTree(std::span<const LightBounds> lights) { const Builder builder(*this, lights); }

LightTree::Choice LightTree::choose(Vec3 position, float u, Descent& descent) const {
  if (nodes_.empty()) return {0, 0, 0};
  const Node* node = &nodes_[0];
  float probability = 1;
  if (!node->child && light_importance(node->bounds, position) == 0) return {0, 0, 0};
  for (int level = 0; node->child; ++level) {
    Descent::Level& found = descent.level[static_cast<std::size_t>(level)];
    if (level >= descent.known || found.child != node->child) {
      const float left = light_importance(nodes_[node->child].bounds, position);
      const float right = light_importance(nodes_[node->child + 1].bounds, position);
      if (!(left + right > 0)) return {0, 0, 0};
      found = {node->child, left / (left + right)};
      descent.known = level + 1;
    }
    const float share = found.share;
    if (u < share) {
      u = std::min(u / share, kBelowOne);
      probability *= share;
      node = &nodes_[node->child];
    } else {
      u = std::min((u - share) / (1 - share), kBelowOne);
      probability *= 1 - share;
      node = &nodes_[node->child + 1];
    }
  }
  return {node->light, probability, u};
}

float LightTree::probability(Vec3 position, std::uint32_t light) const {
  if (depth_[light] == kNotThere) return 0;
  const Node* node = &nodes_[0];
  if (!node->child) return light_importance(node->bounds, position) > 0 ? 1.0f : 0.0f;
  float probability = 1;
  for (int level = 0; level < depth_[light]; ++level) {
    const float left = light_importance(nodes_[node->child].bounds, position);
    const float right = light_importance(nodes_[node->child + 1].bounds, position);
    if (!(left + right > 0)) return 0;
    const float share = left / (left + right);
    const bool to_right = (way_[light] >> level) & 1;
    probability *= to_right ? 1 - share : share;
    node = &nodes_[node->child + (to_right ? 1 : 0)];
  }
  return probability;
}

float LightTree::irradiance(Vec3 position) const {
  return nodes_.empty() ? 0.0f : irradiance(position, 0, kIrradianceLevels);
}

float LightTree::irradiance(Vec3 position, std::uint32_t n, int levels) const {
  const Node& node = nodes_[n];
  const bool among =
      length_squared(position - node.bounds.box.center()) < 4 * length_squared(node.bounds.box.diagonal());
  if (!node.child || levels == 0 || !among) return light_importance(node.bounds, position);
  return irradiance(position, node.child, levels - 1) + irradiance(position, node.child + 1, levels - 1);
}

}  // namespace glowworm
