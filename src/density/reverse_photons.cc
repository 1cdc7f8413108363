#include "density/reverse_photons.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "density/kd_tree.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

// Leaf size of the tree that orders the photons: searches from one leaf visit the same nodes in any order.
constexpr std::uint32_t kOrderLeafSize = 8;
constexpr std::uint32_t kClustersInGroup = 32;
/// The radius with a margin for the rounding of bounds.
float padded(float radius, Vec3 p) {
  const float magnitude = std::max(std::abs(p.x), std::max(std::abs(p.y), std::abs(p.z)));
  return radius * 1.000001f + magnitude * 5e-7f;
}

/// Whether a cluster's sphere overlaps a box.
bool reaches(const ReverseCluster& cluster, const Box3& box) {
  float distance_squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float outside =
        std::max(0.0f, std::max(box.min[axis] - cluster.center[axis], cluster.center[axis] - box.max[axis]));
    distance_squared += outside * outside;
  }
  return distance_squared <= cluster.radius * cluster.radius * 1.00001f;
}

bool overlap(const Box3& a, const Box3& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] || b.min[axis] > a.max[axis]) return false;
  }
  return true;
}

}  // namespace

ReversePhotonArray::ReversePhotonArray(const PhotonBatch& photons, std::span<const RGB> fluxes,
                                       const RadiusPolicy& policy, std::uint32_t cluster_size)
    : min_normal_cosine_(policy.min_normal_cosine), kernel_(policy.kernel) {
  const auto radius_of = [&](std::uint32_t i) {
    return policy.kind == RadiusKind::per_photon ? policy.radii[i] : policy.radius;
  };
  std::vector<Vec3> positions;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < photons.size(); ++i) {
    const float radius = radius_of(i);
    if (!is_finite(photons.position[i]) || !std::isfinite(1 / (radius * radius))) continue;
    positions.push_back(photons.position[i]);
    indices.push_back(i);
  }
  const KdTree tree = build_kd_tree(positions, kOrderLeafSize);
  const std::size_t count = positions.size();
  const double norm = kernel_norm(policy.kernel) / std::numbers::pi;
  for (auto& field : fields_) field.assign(count + kReversePadding, 0.0f);
  direction_.resize(count);
  std::vector<float> radii(count);
  parallel_for_each(count, 4096, [&](std::size_t i) {
    const std::uint32_t index = indices[tree.points[i].index];
    const Vec3 p = photons.position[index], normal = photons.normal[index];
    const double h = radius_of(index);
    const RGB flux = fluxes[index];
    const double scale = norm / (h * h);
    const float values[kFields] = {p.x,
                                   p.y,
                                   p.z,
                                   static_cast<float>(1 / (h * h)),
                                   normal.x,
                                   normal.y,
                                   normal.z,
                                   static_cast<float>(flux.r * scale),
                                   static_cast<float>(flux.g * scale),
                                   static_cast<float>(flux.b * scale)};
    for (int f = 0; f < kFields; ++f) fields_[f][i] = values[f];
    direction_[i] = photons.direction[index];
    radii[i] = radius_of(index);
  });
  make_clusters(radii, std::clamp(cluster_size, 1u, ReverseCluster::kMaxCount));
}

void ReversePhotonArray::make_clusters(const std::vector<float>& radii, std::uint32_t cluster_size) {
  const auto count = static_cast<std::uint32_t>(size());
  for (std::uint32_t first = 0; first < count;) {
    // Photons join while they are within the largest radius: a wider cluster would visit leaves for few of its photons.
    Box3 box;
    box.grow(position(first));
    float widest = radii[first];
    std::uint32_t last = first + 1;
    for (; last < count && last - first < cluster_size; ++last) {
      Box3 grown = box;
      grown.grow(position(last));
      const float limit = std::max(widest, radii[last]);
      if (length_squared(grown.diagonal()) > 4 * limit * limit) break;
      box = grown;
      widest = limit;
    }
    clusters_.push_back(make_cluster(first, last, radii));
    first = last;
  }
  for (std::uint32_t first = 0; first < clusters_.size(); first += kClustersInGroup) {
    Group group{first, std::min(first + kClustersInGroup, static_cast<std::uint32_t>(clusters_.size())), Box3()};
    for (std::uint32_t i = group.first; i < group.last; ++i) {
      const ReverseCluster& c = clusters_[i];
      group.bounds.grow(Box3{{c.min[0], c.min[1], c.min[2]}, {c.max[0], c.max[1], c.max[2]}});
    }
    groups_.push_back(group);
  }
}

ReverseCluster ReversePhotonArray::make_cluster(std::uint32_t first, std::uint32_t last,
                                                const std::vector<float>& radii) const {
  ReverseCluster cluster;
  cluster.first = first;
  cluster.count = last - first;
  Box3 centers, reach;
  for (std::uint32_t i = first; i < last; ++i) {
    const Vec3 p = position(i);
    const float r = padded(radii[i], p);
    centers.grow(p);
    reach.grow(p - Vec3{r, r, r});
    reach.grow(p + Vec3{r, r, r});
  }
  const Vec3 center = cluster.count == 1 ? position(first) : centers.center();
  for (std::uint32_t i = first; i < last; ++i) {
    const Vec3 p = position(i);
    cluster.radius = std::max(cluster.radius, padded(length(p - center) + padded(radii[i], p), p));
  }
  for (int axis = 0; axis < 3; ++axis) {
    cluster.center[axis] = center[axis];
    cluster.min[axis] = reach.min[axis];
    cluster.max[axis] = reach.max[axis];
  }
  return cluster;
}

void ReversePhotonArray::visit(const Box3& box, const std::function<void(const ReverseCluster&)>& work) const {
  for (const Group& group : groups_) {
    if (!overlap(group.bounds, box)) continue;
    for (std::uint32_t c = group.first; c < group.last; ++c) {
      if (reaches(clusters_[c], box)) work(clusters_[c]);
    }
  }
}

ReversePhotons ReversePhotonArray::view() const {
  ReversePhotons view;
  view.x = fields_[kX].data();
  view.y = fields_[kY].data();
  view.z = fields_[kZ].data();
  view.inverse_radius_squared = fields_[kInverse].data();
  view.normal_x = fields_[kNormalX].data();
  view.normal_y = fields_[kNormalY].data();
  view.normal_z = fields_[kNormalZ].data();
  view.r = fields_[kRed].data();
  view.g = fields_[kGreen].data();
  view.b = fields_[kBlue].data();
  view.min_normal_cosine = min_normal_cosine_;
  view.kernel = kernel_;
  return view;
}

RGB ReversePhotonArray::flux(std::uint32_t place) const {
  return RGB(fields_[kRed][place], fields_[kGreen][place], fields_[kBlue][place]) * kPi;
}

std::uint64_t ReversePhotonArray::bytes(std::size_t photons) {
  const std::uint64_t finished = kFields * sizeof(float) + sizeof(Vec3);
  const std::uint64_t building = 2 * sizeof(KdPoint) + sizeof(Vec3) + sizeof(std::uint32_t) + sizeof(float);
  return photons * (finished + building);
}

}  // namespace glowworm
