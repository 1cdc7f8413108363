#include "maps/boundary_clusters.h"

#include <algorithm>
#include <cmath>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "density/kd_tree.h"

namespace glowworm {

namespace {

void set_rounding(BoundaryCluster& c) {
  const float rounding = position_rounding(c.center);
  c.flatness = kFlatness * c.reach + rounding;
  c.step = rounding / (c.high - c.low);
}

class Clusterer {
 public:
  Clusterer(const PhotonBatch& photons, std::span<const float> radii) : photons_(photons), radii_(radii) {}

  /// Divides the photons of a leaf, which are reordered.
  void cut(std::span<std::uint32_t> photons, std::uint32_t first, std::vector<BoundaryCluster>& out) const {
    std::size_t begin = 0;
    while (begin < photons.size()) {
      const Vec3 normal = photons_.normal[photons[begin]];
      const auto rest = photons.subspan(begin);
      // A cluster has normals near that of its first photon.
      const auto end = std::stable_partition(rest.begin(), rest.end(),
                                             [&](std::uint32_t p) { return dot(photons_.normal[p], normal) > 0.9f; });
      // A photon without a normal does not match itself either.
      const std::size_t count = std::max<std::size_t>(1, static_cast<std::size_t>(end - rest.begin()));
      const BoundaryCluster whole = measure(rest.first(count), first + static_cast<std::uint32_t>(begin));
      if (whole.wideness <= kWidestCluster) {
        out.push_back(whole);
      } else {
        for (std::size_t i = 0; i < count; ++i)
          out.push_back(measure(rest.subspan(i, 1), first + static_cast<std::uint32_t>(begin + i)));
      }
      begin += count;
    }
  }

 private:
  BoundaryCluster measure(std::span<const std::uint32_t> photons, std::uint32_t first) const {
    BoundaryCluster c;
    c.first = first;
    c.count = static_cast<std::uint32_t>(photons.size());
    const Vec3 origin = photons_.position[photons[0]];
    Vec3 offset, normal;
    for (const std::uint32_t p : photons) {
      offset += photons_.position[p] - origin;
      normal += photons_.normal[p];
    }
    c.center = origin + offset / static_cast<float>(c.count);
    c.normal = length(normal) > 0 ? normalize(normal) : Vec3{0, 0, 1};
    float squares = 0, deviation = 0, cosine = 1;
    c.low = std::numeric_limits<float>::infinity();
    c.high = -c.low;
    for (const std::uint32_t p : photons) {
      const Vec3 d = photons_.position[p] - c.center;
      const float height = dot(d, c.normal), r = radii_[p];
      c.reach = std::max(c.reach, length(d - c.normal * height) + r);
      c.low = std::min(c.low, height - r);
      c.high = std::max(c.high, height + r);
      squares += r * r;
      deviation = std::max(deviation, std::abs(height));
      cosine = std::min(cosine, dot(photons_.normal[p], c.normal));
    }
    c.wideness = c.reach * c.reach * static_cast<float>(c.count) / squares;
    set_rounding(c);
    c.flat = deviation <= c.flatness && cosine >= 1 - kFlatness;
    return c;
  }

  const PhotonBatch& photons_;
  std::span<const float> radii_;
};

}  // namespace

BoundaryCluster lone_cluster(Vec3 position, Vec3 normal, float radius) {
  BoundaryCluster c;
  c.center = position;
  c.normal = normal;
  c.reach = c.high = radius;
  c.low = -radius;
  c.flat = true;
  c.count = 1;
  set_rounding(c);
  return c;
}

BoundaryClusters make_boundary_clusters(const PhotonBatch& photons, std::span<const float> radii) {
  BoundaryClusters result;
  // With the default k, a leaf is about as wide as a photon's disc.
  const KdTree tree = build_kd_tree(photons.position, 48);
  result.photons.resize(photons.size());
  for (std::size_t i = 0; i < result.photons.size(); ++i) result.photons[i] = tree.points[i].index;
  std::vector<KdNode> leaves;
  for (const KdNode& node : tree.nodes)
    if (node.is_leaf()) leaves.push_back(node);
  const std::size_t grain = even_grain(leaves.size());
  std::vector<std::vector<BoundaryCluster>> found((leaves.size() + grain - 1) / grain);
  const Clusterer clusterer(photons, radii);
  parallel_for(0, leaves.size(), grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      clusterer.cut(std::span(result.photons).subspan(leaves[i].first(), leaves[i].count), leaves[i].first(),
                    found[first / grain]);
  });
  for (const auto& some : found) result.clusters.insert(result.clusters.end(), some.begin(), some.end());
  return result;
}

}  // namespace glowworm
