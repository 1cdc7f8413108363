#include "density/photon_sample.h"

#include <algorithm>
#include <array>

#include "core/parallel.h"
#include "core/random.h"
#include "density/kd_tree.h"
#include "density/shading.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

std::vector<std::uint32_t> one_of_each_run(std::size_t count, std::size_t run) {
  std::vector<std::uint32_t> out;
  for (std::size_t first = 0; first + run <= count; first += run) {
    const auto at = static_cast<std::uint32_t>(first);
    out.push_back(at + hash32(at) % static_cast<std::uint32_t>(run));
  }
  return out;
}

namespace {

constexpr std::size_t kSampleGrain = 512;
constexpr std::uint32_t kLeafSize = 8;

/// The places of query points of both sets, the first set first.
std::vector<Vec3> places_of(const QueryPoints& first, const QueryPoints& second) {
  std::vector<Vec3> out(first.position.begin(), first.position.end());
  out.insert(out.end(), second.position.begin(), second.position.end());
  return out;
}

/// What single photons add to the targets.
class PhotonShares {
 public:
  PhotonShares(const PhotonSample& sample, const QueryPoints& first, const QueryPoints& second, const KdTree& tree,
               std::size_t targets)
      : sample_(sample),
        sets_{&first, &second},
        tree_(tree),
        sums_{std::vector<RGB>(targets), std::vector<RGB>(targets)} {}

  /// Adds the products of a photon's shares to the targets.
  void add_products(std::uint32_t photon, std::vector<RGB>& products) {
    const float radius =
        sample_.policy.kind == RadiusKind::fixed ? sample_.policy.radius : sample_.policy.radii[photon];
    cuts_ = cuts_of(sample_.policy.cuts, photon);
    visit(0, photon, radius * radius);
    for (const std::uint32_t target : reached_) {
      products[target] += sums_[0][target] * sums_[1][target];
      sums_[0][target] = sums_[1][target] = RGB();
    }
    reached_.clear();
  }

 private:
  void visit(std::size_t at, std::uint32_t photon, float radius_squared) {
    const KdNode& node = tree_.nodes[at];
    const Vec3 place = sample_.photons.position[photon];
    if (node.is_leaf()) {
      for (std::uint32_t i = node.first(); i < node.first() + node.count; ++i)
        if (length_squared(tree_.points[i].position - place) < radius_squared)
          add_share(tree_.points[i], photon, radius_squared);
      return;
    }
    const float beyond = place[node.axis()] - node.split;
    const bool is_left = beyond <= 0, reaches_both = beyond * beyond < radius_squared;
    if (is_left || reaches_both) visit(at + 1, photon, radius_squared);
    if (!is_left || reaches_both) visit(at + node.right_offset(), photon, radius_squared);
  }

  void add_share(const KdPoint& point, std::uint32_t photon, float radius_squared) {
    const std::size_t set = point.index < sets_[0]->size() ? 0 : 1;
    const QueryPoints& queries = *sets_[set];
    const std::size_t query = point.index - (set == 0 ? 0 : sets_[0]->size());
    const Vec3 way = point.position - sample_.photons.position[photon];
    if (!(dot(sample_.photons.normal[photon], queries.normal[query]) > sample_.policy.min_normal_cosine)) return;
    if (cuts_ && !cuts_->keep(way)) return;
    const double weight =
        kernel(sample_.policy.kernel, double{length_squared(way)} / double{radius_squared}) / double{radius_squared};
    const std::uint32_t target = queries.gather_point[query];
    reached_.push_back(target);
    sums_[set][target] += queries.weight[query] *
                          radiance(queries, query, photon, sample_.photons.flux[photon] * static_cast<float>(weight));
  }

  RGB radiance(const QueryPoints& queries, std::size_t query, std::uint32_t photon, RGB irradiance) {
    if (queries.bsdf[query] == kLambertianQuery) return queries.reflectance[query] * irradiance / kPi;
    gathered_.clear();
    gathered_.push_back(sample_.photons.direction[photon], irradiance);
    return shader_.shade(queries.bsdfs[queries.bsdf[query]], gathered_);
  }

  const PhotonSample& sample_;
  std::array<const QueryPoints*, 2> sets_;
  const KdTree& tree_;
  std::array<std::vector<RGB>, 2> sums_;  ///< by target; black between photons
  std::vector<std::uint32_t> reached_;
  const PhotonCuts* cuts_ = nullptr;
  GatheredPhotons gathered_;
  BatchShader shader_;
};

}  // namespace

PhotonSample sample_of(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& whole,
                       const std::vector<std::uint32_t>& indices) {
  PhotonSample out{photons.permuted(indices), whole};
  out.photons.flux = permuted(flux, indices);
  out.policy.order = {};
  out.policy.radii.clear();
  out.policy.cuts.clear();
  for (std::uint32_t i = 0; i < indices.size(); ++i) {
    if (!whole.radii.empty()) out.policy.radii.push_back(whole.radii[indices[i]]);
    if (const PhotonCuts* c = cuts_of(whole.cuts, indices[i])) out.policy.cuts.push_back({i, c->cuts});
  }
  return out;
}

std::vector<RGB> variance_by_photons(const PhotonSample& sample, const QueryPoints& first, const QueryPoints& second,
                                     std::size_t targets) {
  std::vector<RGB> out(targets);
  const KdTree tree = build_kd_tree(places_of(first, second), kLeafSize);
  if (tree.nodes.empty()) return out;
  const std::size_t photons = sample.photons.size();
  std::vector<std::vector<RGB>> products((photons + kSampleGrain - 1) / kSampleGrain);
  parallel_for(0, products.size(), 1, [&](std::size_t begin, std::size_t end) {
    PhotonShares shares(sample, first, second, tree, targets);
    for (std::size_t part = begin; part < end; ++part) {
      products[part].resize(targets);
      for (std::size_t i = part * kSampleGrain; i < std::min((part + 1) * kSampleGrain, photons); ++i)
        shares.add_products(static_cast<std::uint32_t>(i), products[part]);
    }
  });
  for (const std::vector<RGB>& part : products)
    for (std::size_t target = 0; target < targets; ++target) out[target] += part[target] * sample.each;
  return out;
}

}  // namespace glowworm
