#include "density/grouped_map.h"

#include <numeric>

#include "core/parallel.h"
#include "density/shading.h"

namespace glowworm {

namespace {

/// Points in the order of their targets: target t has order[first[t]] to order[first[t + 1] - 1].
struct PointsOfTargets {
  std::vector<std::uint32_t> first, order;

  PointsOfTargets(const QueryPoints& points, std::size_t targets) : first(targets + 1), order(points.size()) {
    for (const std::uint32_t target : points.gather_point) ++first[target + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < points.size(); ++i)
      order[next[points.gather_point[i]]++] = static_cast<std::uint32_t>(i);
  }
};

/// Looks up one point after another. Holds the memory of one thread.
class GroupWorker {
 public:
  GroupWorker(const BlockedIndex& index, std::span<const std::uint32_t> groups, const QueryPoints& points,
              std::span<std::vector<RGB>> light, float factor)
      : index_(index), tree_(index.tree()), groups_(groups), points_(points), light_(light), factor_(factor) {}

  void add(std::uint32_t point) {
    const Vec3 p = points_.position[point], n = points_.normal[point];
    const float position[3] = {p.x, p.y, p.z}, normal[3] = {n.x, n.y, n.z};
    blocked_find(tree_, position, normal, scratch_, found_, counts);
    const bool is_lambertian = points_.bsdf[point] == kLambertianQuery;
    const RGB weight = points_.weight[point] * factor_,
              factor = is_lambertian ? weight * points_.reflectance[point] : weight;
    for (const BlockedPhoton& photon : found_) {
      const PhotonBlock& block = tree_.blocks[photon.place / kBlockWidth];
      const std::size_t lane = photon.place % kBlockWidth;
      RGB radiance = RGB(block.r[lane], block.g[lane], block.b[lane]) * photon.profile;
      if (!is_lambertian) radiance = shade(point, photon.place, radiance);
      light_[groups_[photon.place]][points_.gather_point[point]] += factor * radiance;
    }
  }

  BlockedCounts counts;

 private:
  /// @param radiance of a photon by a Lambertian surface of reflectance 1
  RGB shade(std::uint32_t point, std::uint32_t place, RGB radiance) {
    gathered_.clear();
    gathered_.push_back(index_.directions()[place], radiance * kPi);
    return shader_.shade(points_.bsdfs[points_.bsdf[point]], gathered_);
  }

  const BlockedIndex& index_;
  BlockTree tree_;
  std::span<const std::uint32_t> groups_;  // by place
  const QueryPoints& points_;
  std::span<std::vector<RGB>> light_;
  float factor_;
  BlockedScratch scratch_;
  std::vector<BlockedPhoton> found_;
  GatheredPhotons gathered_;
  BatchShader shader_;
};

}  // namespace

GroupedMap::GroupedMap(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
                       std::span<const std::uint32_t> group_of) {
  std::vector<std::uint32_t> photon_of_place;
  index_ = BlockedIndex(photons, flux, policy, &photon_of_place);
  group_of_place_.reserve(photon_of_place.size());
  for (const std::uint32_t photon : photon_of_place) group_of_place_.push_back(group_of[photon]);
}

void GroupedMap::add(const QueryPoints& points, std::span<std::vector<RGB>> light, Statistics& statistics,
                     float factor) const {
  const PhaseTimer timer(statistics, Phase::density);
  statistics.add(Counter::query_points, points.size());
  if (index_.size() == 0 || light.empty()) return;
  const PointsOfTargets of(points, light.front().size());
  const std::size_t targets = light.front().size();
  parallel_for(0, targets, even_grain(targets), [&](std::size_t first, std::size_t last) {
    GroupWorker worker(index_, group_of_place_, points, light, factor);
    for (std::size_t i = of.first[first]; i < of.first[last]; ++i) worker.add(of.order[i]);
    statistics.add(Counter::shader_operations, worker.counts.evaluated);
    statistics.add(Counter::pairs_tested, worker.counts.tested);
  });
}

std::uint64_t GroupedMap::bytes(std::size_t photons) {
  return BlockedIndex::bytes(photons) + photons * sizeof(std::uint32_t);
}

}  // namespace glowworm
