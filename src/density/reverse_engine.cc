// Reverse photon mapping [HHS05]: photons search for query points.
#include <algorithm>
#include <array>
#include <memory>
#include <mutex>

#include "core/error.h"
#include "core/parallel.h"
#include "density/engines.h"
#include "density/reverse.h"
#include "density/reverse_photons.h"
#include "density/shading.h"

namespace glowworm {

namespace {

// Query points of one tree at most.
constexpr std::size_t kTreePoints = std::size_t{1} << 26;
// Pairs with points that are not Lambertian are shaded in batches of this size.
constexpr std::size_t kMaxPairs = std::size_t{1} << 18;

/// Points of a part of a render by their kind of shading, as indices.
struct ShadingGroups {
  std::vector<std::uint32_t> lambertian, others;

  ShadingGroups(const QueryPoints& points, std::size_t first, std::size_t last) {
    lambertian.reserve(last - first);
    for (std::size_t i = first; i < last; ++i)
      (points.bsdf[i] == kLambertianQuery ? lambertian : others).push_back(static_cast<std::uint32_t>(i));
  }
};

/// Runs photons over one subtree after another. Holds the memory of one thread.
class SubtreeWorker {
 public:
  SubtreeWorker(const ReversePhotonArray& photons, const ReverseTree& tree, const QueryPoints& points)
      : photons_(photons), view_(photons.view()), tree_(tree), points_(points) {}

  /// All photons against the points of a subtree, in A_P order.
  /// @param fields its part of A_R
  /// @param sums   its part of A_W
  /// @param lambertian whether all points are; the photons of others are shaded point by point
  void work(const ReverseSubtree& subtree, const float* fields, float* sums, bool lambertian) {
    const Box3 box = tree_.measure(subtree, fields, bounds_);
    ReverseSubtreeView part;
    part.nodes = tree_.nodes().data();
    part.root = subtree.root;
    part.first_point = subtree.first_point;
    part.points = fields;
    part.sums = sums;
    part.bounds = bounds_.data();
    clusters_.clear();
    photons_.visit(box, [&](const ReverseCluster& cluster) { clusters_.push_back(cluster); });
    if (lambertian) return reverse_sum(part, view_, clusters_, counts);
    exact_.assign(subtree.point_count, {});
    // One by one, to bound the number of waiting pairs.
    for (const ReverseCluster& cluster : clusters_) {
      reverse_collect(part, view_, {&cluster, 1}, pairs_, counts);
      if (pairs_.size() >= kMaxPairs) shade_pairs(part, subtree);
    }
    shade_pairs(part, subtree);
    round_sums(part, subtree);
  }

  ReverseCounts counts;

 private:
  /// Shades the pairs found so far, each point's in one batch, adds the results to exact_, and removes the pairs.
  void shade_pairs(const ReverseSubtreeView& part, const ReverseSubtree& subtree) {
    std::stable_sort(pairs_.begin(), pairs_.end(),
                     [](const ReversePair& a, const ReversePair& b) { return a.point < b.point; });
    std::size_t pair = 0;
    for (std::uint32_t i = 0; i < subtree.node_count && pair < pairs_.size(); ++i) {
      const ReverseNode& node = part.nodes[subtree.root + i];
      if (!node.is_leaf()) continue;
      const std::size_t n = node.count(), first = node.first() - subtree.first_point;
      while (pair < pairs_.size() && pairs_[pair].point < node.first() + n) {
        const std::uint32_t point = pairs_[pair].point;
        gathered_.clear();
        for (; pair < pairs_.size() && pairs_[pair].point == point; ++pair) {
          const std::uint32_t photon = pairs_[pair].photon;
          gathered_.push_back(photons_.direction(photon), photons_.flux(photon) * pairs_[pair].profile);
        }
        const std::size_t lane = point - node.first();
        std::uint32_t bsdf;
        std::memcpy(&bsdf, part.points + first * kReverseFields + 7 * n + lane, sizeof bsdf);
        shader_.add(points_.bsdfs[bsdf], gathered_, exact_[first + lane]);
      }
    }
    pairs_.clear();
  }

  /// Moves the sums of shade_pairs() into A_W.
  void round_sums(const ReverseSubtreeView& part, const ReverseSubtree& subtree) const {
    for (std::uint32_t i = 0; i < subtree.node_count; ++i) {
      const ReverseNode& node = part.nodes[subtree.root + i];
      if (!node.is_leaf()) continue;
      const std::size_t n = node.count(), first = node.first() - subtree.first_point;
      for (std::size_t lane = 0; lane < n; ++lane)
        for (std::size_t c = 0; c < 3; ++c)
          part.sums[first * kReverseSums + c * n + lane] = static_cast<float>(exact_[first + lane][c]);
    }
  }

  const ReversePhotonArray& photons_;
  ReversePhotons view_;
  const ReverseTree& tree_;
  const QueryPoints& points_;
  std::vector<ReverseLeafBounds> bounds_;
  std::vector<ReverseCluster> clusters_;  // those that reach the subtree
  std::vector<ReversePair> pairs_;
  std::vector<std::array<double, 3>> exact_;  // sums of the points that are shaded one by one, in A_R order
  GatheredPhotons gathered_;
  BatchShader shader_;
};

/// Completion: adds a subtree's part of A_W, in its order, to the radiance of the points.
void complete(const ReverseTree& tree, const ReverseSubtree& subtree, const float* fields, const float* sums,
              const QueryPoints& points, bool lambertian, std::span<RGB> radiance) {
  for (std::uint32_t i = 0; i < subtree.node_count; ++i) {
    const ReverseNode& node = tree.nodes()[subtree.root + i];
    if (!node.is_leaf()) continue;
    const std::size_t n = node.count(), first = node.first() - subtree.first_point;
    const float* targets = fields + first * kReverseFields + 6 * n;
    const float* sum = sums + first * kReverseSums;
    // Neighbours in space are scattered in memory, in the order of the rays.
    for (std::size_t lane = 0; lane < n; ++lane) {
      std::uint32_t target;
      std::memcpy(&target, targets + lane, sizeof target);
      __builtin_prefetch(&radiance[target], 1);
      __builtin_prefetch(&points.reflectance[target]);
    }
    for (std::size_t lane = 0; lane < n; ++lane) {
      std::uint32_t target;
      std::memcpy(&target, targets + lane, sizeof target);
      const RGB value(sum[lane], sum[n + lane], sum[2 * n + lane]);
      radiance[target] += lambertian ? value * points.reflectance[target] : value;
    }
  }
}

class ReverseEngine final : public DensityEngine {
 public:
  explicit ReverseEngine(const ReverseOptions& options) : options_(options) {
    if (options.leaf_size > ReverseNode::kMaxCount)
      throw Error("leaves of the reverse photon map hold 1 to 255 query points");
    if (options.cluster_size == 0 || options.cluster_size > ReverseCluster::kMaxCount)
      throw Error("1 to 64 photons are searched for at once");
  }

  std::string name() const override { return "reverse"; }

  std::uint64_t index_bytes(std::size_t photons) const override { return ReversePhotonArray::bytes(photons); }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    PhaseTimer timer(statistics, Phase::build_photon_map);
    check_policy(photons, policy, "reverse");
    photons_ = ReversePhotonArray();
    photons_ = ReversePhotonArray(photons, flux, policy, options_.cluster_size);
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    statistics.add(Counter::query_points, points.size());
    if (photons_.size() == 0) return;
    std::unique_ptr<ReverseMemory> memory = take_memory();
    for (std::size_t first = 0; first < points.size(); first += kTreePoints) {
      const ShadingGroups groups(points, first, std::min(first + kTreePoints, points.size()));
      estimate_some(points, groups.lambertian, true, radiance, *memory, statistics);
      estimate_some(points, groups.others, false, radiance, *memory, statistics);
    }
    const std::lock_guard lock(mutex_);
    idle_ = std::move(memory);
  }

 private:
  /// The memory of the last call, unless another call is using it.
  std::unique_ptr<ReverseMemory> take_memory() const {
    const std::lock_guard lock(mutex_);
    return idle_ ? std::move(idle_) : std::make_unique<ReverseMemory>();
  }

  void estimate_some(const QueryPoints& points, std::span<const std::uint32_t> chosen, bool lambertian,
                     std::span<RGB> radiance, ReverseMemory& memory, Statistics& statistics) const {
    if (chosen.empty()) return;
    std::unique_ptr<const ReverseTree> tree;
    {
      PhaseTimer timer(statistics, Phase::reorder);
      const std::uint32_t leaf_size =
          options_.leaf_size > 0 ? options_.leaf_size : reverse_leaf_size(chosen.size(), photons_.size());
      tree = std::make_unique<ReverseTree>(points, chosen, leaf_size, &memory);
    }
    PhaseTimer timer(statistics, Phase::density);
    // A subtree belongs to one thread, which runs the photons over it in order: one thread writes each entry of A_W, in
    // one order.
    parallel_for(0, tree->subtrees().size(), 1, [&](std::size_t first, std::size_t last) {
      SubtreeWorker worker(photons_, *tree, points);
      std::vector<float> sums;
      for (std::size_t s = first; s < last; ++s) {
        const ReverseSubtree& subtree = tree->subtrees()[s];
        const float* fields = tree->points().data() + std::size_t{subtree.first_point} * kReverseFields;
        sums.assign(subtree.point_count * kReverseSums + kReversePadding, 0.0f);
        worker.work(subtree, fields, sums.data(), lambertian);
        complete(*tree, subtree, fields, sums.data(), points, lambertian, radiance);
      }
      statistics.add(Counter::shader_operations, worker.counts.operations);
      statistics.add(Counter::pairs_tested, worker.counts.tested);
      statistics.add(Counter::packet_steps, worker.counts.steps);
      statistics.add(Counter::packet_active_lanes, worker.counts.operations);
    });
  }

  ReverseOptions options_;
  ReversePhotonArray photons_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<ReverseMemory> idle_;
};

}  // namespace

std::uint32_t reverse_leaf_size(std::size_t points, std::size_t photons) {
  constexpr double kLeafOverDensity = 30;
  constexpr double kMaxLeafSize = 128;
  const double density = static_cast<double>(points) / static_cast<double>(std::max<std::size_t>(photons, 1));
  return static_cast<std::uint32_t>(
      std::clamp(kLeafOverDensity * density, static_cast<double>(ReverseTree::kLeafSize), kMaxLeafSize));
}

std::unique_ptr<DensityEngine> make_reverse_engine(const ReverseOptions& options) {
  return std::make_unique<ReverseEngine>(options);
}
std::unique_ptr<DensityEngine> make_reverse_engine() { return make_reverse_engine(ReverseOptions()); }

}  // namespace glowworm
