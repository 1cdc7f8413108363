#include "density/query_radii.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace glowworm {

QueryRadii::QueryRadii(const PhotonBatch& photons, const RadiusPolicy& policy)
    : kind_(policy.kind), kernel_(policy.kernel), min_normal_cosine_(policy.min_normal_cosine) {
  if (kind_ == RadiusKind::fixed) {
    radius_ = policy.radius;
    return;
  }
  places_.build(photons.position, photons.normal, policy.cuts);
  if (kind_ == RadiusKind::nearest) {
    sought_ = policy.k;
    radius_ = policy.max_radius;
    return;
  }
  radii_.resize(photons.size());
  for (std::uint32_t i = 0; i < radii_.size(); ++i) {
    radii_[i] = policy.radii[places_.index(i)];
    radius_ = std::max(radius_, radii_[i]);
  }
}

std::uint64_t QueryRadii::bytes(std::size_t photons) {
  // A node for each point, at most.
  return photons * (sizeof(KdPoint) + sizeof(KdNode) + sizeof(Vec3) + sizeof(float));
}

float QueryRadii::radius_at(Vec3 x, Vec3 normal, std::span<std::uint64_t> found) const {
  const float limit = radius_ > 0 ? radius_ * radius_ : std::numeric_limits<float>::infinity();
  std::uint64_t tested = 0;
  const std::size_t count = places_.nearest(x, normal, min_normal_cosine_, found.size(), limit, found, tested);
  if (count == 0) return 0;
  if (kind_ == RadiusKind::per_photon) return radii_[PhotonPlaces::unpack(found[0]).place];
  // The farthest comes first if all were found; else the estimate's radius is the limit.
  return count == sought_ || !(radius_ > 0) ? std::sqrt(PhotonPlaces::unpack(found[0]).distance_squared) : radius_;
}

std::vector<float> QueryRadii::at(std::span<const Vec3> position, std::span<const Vec3> normal,
                                  std::span<const RGB> light) const {
  std::vector<float> out(position.size(), kind_ == RadiusKind::fixed ? radius_ : 0.0f);
  if (kind_ == RadiusKind::fixed) return out;
  parallel_for(0, out.size(), even_grain(out.size()), [&](std::size_t first, std::size_t last) {
    std::vector<std::uint64_t> found(std::min<std::size_t>(sought_, places_.size()));
    for (std::size_t i = first; i < last; ++i)
      if (!is_black(light[i])) out[i] = radius_at(position[i], normal[i], found);
  });
  return out;
}

}  // namespace glowworm
