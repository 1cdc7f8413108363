#include "support/pair_cost.h"

#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "core/parallel.h"
#include "density/glossy.h"
#include "density/reverse.h"
#include "density/reverse_photons.h"
#include "density/reverse_tree.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr int kRuns = 3;
constexpr std::uint32_t kPoints = 96, kClusters = 20'000;

/// A surface of a model.
Bsdf surface_of(GlossyModel model) {
  Bsdf b;
  b.diffuse = RGB(0.5f);
  b.alpha_x = b.alpha_y = 0.3f;
  b.kind = model == GlossyModel::coated      ? BsdfKind::coated_diffuse
           : model == GlossyModel::conductor ? BsdfKind::conductor
                                             : BsdfKind::metallic_roughness;
  b.specular = RGB(1.0f);
  b.coat_thickness = 0.01f;
  if (model == GlossyModel::conductor) b.k = RGB(3.0f);
  return b;
}

/// One leaf, and one cluster of photons that reach all of it.
class Leaf {
 public:
  Leaf() {
    PhotonBatch batch;
    for (std::uint32_t i = 0; i < ReverseCluster::kMaxCount; ++i) {
      const float slant = 0.01f * static_cast<float>(i);
      batch.push_back({0.001f * static_cast<float>(i), 0, 0}, {std::sin(slant), 0, std::cos(slant)}, RGB(1.0f),
                      {0, 0, 1});
    }
    RadiusPolicy policy;
    policy.kind = RadiusKind::fixed;
    policy.radius = 10;
    policy.kernel = KernelShape::box;
    photons_ = ReversePhotonArray(batch, policy, ReverseCluster::kMaxCount);
    std::vector<std::uint32_t> all(kPoints);
    std::iota(all.begin(), all.end(), 0u);
    QueryPoints points;
    for (const std::uint32_t i : all)
      points.push_back({0, 0.001f * static_cast<float>(i), 0}, {0, 0, 1}, RGB(1.0f), RGB(1.0f), 0);
    tree_ = std::make_unique<const ReverseTree>(points, all, kPoints);
    tree_->measure(tree_->subtrees().front(), tree_->points().data(), bounds_);
  }

  /// Numbers of glossy points in place of the leaf's.
  ReverseGlossy glossy(GlossyModel model) {
    const float far = std::sqrt(0.5f);
    const QueryBsdf point{surface_of(model), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, far, far}};
    const GlossyNumbers numbers = preparer_.prepare(point, model);
    const std::size_t stride = reverse_glossy_stride(kPoints);
    fields_.resize(kGlossyFields * stride);
    for (std::size_t field = 0; field < kGlossyFields; ++field)
      std::fill_n(&fields_[field * stride], stride, numbers[field]);
    return {fields_.data(), leaf_.data(), preparer_.tables(), model};
  }

  using Kernel = std::function<void(const ReverseSubtreeView&, const ReversePhotons&, std::span<const ReverseCluster>,
                                    ReverseCounts&)>;

  double nanoseconds(const Kernel& kernel) const {
    std::atomic<std::uint64_t> tested;
    const Spread seconds = measure_seconds(kRuns, [&] {
      tested = 0;
      parallel_for(0, kClusters, kClusters / 16, [&](std::size_t first, std::size_t last) {
        std::vector<float> sums(kPoints * kReverseSums + kReversePadding);
        ReverseSubtreeView part;
        part.nodes = tree_->nodes().data();
        part.root = tree_->subtrees().front().root;
        part.points = tree_->points().data();
        part.sums = sums.data();
        part.bounds = bounds_.data();
        ReverseCounts counts;
        for (std::size_t i = first; i < last; ++i) kernel(part, photons_.view(), photons_.clusters(), counts);
        tested += counts.tested;
      });
    });
    return 1e9 * thread_count() * seconds.median / static_cast<double>(tested);
  }

 private:
  ReversePhotonArray photons_;
  std::unique_ptr<const ReverseTree> tree_;
  std::vector<ReverseLeafBounds> bounds_;
  GlossyPreparer preparer_;
  std::vector<float> fields_;
  std::vector<std::uint32_t> leaf_ = {0};
};

}  // namespace

double nanoseconds_of_a_test() { return Leaf().nanoseconds(reverse_count); }

double nanoseconds_of_a_sum(std::optional<GlossyModel> model) {
  Leaf leaf;
  if (!model) return leaf.nanoseconds(reverse_sum);
  const ReverseGlossy glossy = leaf.glossy(*model);
  return leaf.nanoseconds([&](const ReverseSubtreeView& part, const ReversePhotons& photons,
                              std::span<const ReverseCluster> clusters,
                              ReverseCounts& counts) { reverse_sum_glossy(part, photons, clusters, glossy, counts); });
}

}  // namespace glowworm::bench
