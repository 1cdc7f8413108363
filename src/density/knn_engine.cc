// Each query point searches the photon map: for its nearest photons, which is normal photon mapping, or for those
// within a radius.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "density/engines.h"
#include "density/knn.h"
#include "density/reorder.h"
#include "density/shading.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

// Neighbours on the Hilbert curve that one thread looks up in turn: fewer if there are few, because their costs differ.
constexpr std::size_t kMaxGrain = 512, kMinGrain = 16, kPieces = 64;

/// Memory of a piece of query points during lookup.
struct Scratch {
  std::vector<std::uint64_t> heap;
  std::vector<FoundPhoton> found;
  GatheredPhotons gathered;
  BatchShader shader;
  std::uint64_t tested = 0, operations = 0;

  // The last query point: its k nearest photons also bound the search of a neighbour with the same normal.
  Vec3 last_position, last_normal;
  float last_radius = std::numeric_limits<float>::infinity();
};

class KnnEngine final : public DensityEngine {
 public:
  std::string name() const override { return "knn"; }

  std::uint64_t index_bytes(std::size_t photons) const override {
    return photons * (2 * sizeof(KdPoint) + 3 * sizeof(Vec3) + 3 * sizeof(float));
  }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    PhaseTimer timer(statistics, Phase::build_photon_map);
    check_policy(photons, policy);
    if (policy.kind == RadiusKind::per_photon)
      throw Error("the knn density engine cannot take a radius for each photon");
    policy_ = policy;
    policy_.radii = {};
    policy_.cuts = {};
    map_.build(photons, flux, policy.cuts);
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    std::vector<std::uint32_t> order;
    {
      PhaseTimer timer(statistics, Phase::reorder);
      order = hilbert_order(points.position, map_.tree().bounds, map_.size(), ReorderSettings());
    }
    PhaseTimer timer(statistics, Phase::density);
    const std::size_t grain = std::clamp(order.size() / kPieces, kMinGrain, kMaxGrain);
    parallel_for(0, order.size(), grain, [&](std::size_t first, std::size_t last) {
      Scratch scratch;
      scratch.heap.resize(std::min<std::size_t>(policy_.k, map_.size()));
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t point = order[i];
        const float scale = find(points.position[point], points.normal[point], scratch);
        scratch.operations += scratch.found.size();
        radiance[point] += points.bsdf[point] == kLambertianQuery
                               ? lambertian(points.reflectance[point], scale, scratch)
                               : other(points.bsdfs[points.bsdf[point]], scale, scratch);
      }
      statistics.add(Counter::pairs_tested, scratch.tested);
      statistics.add(Counter::shader_operations, scratch.operations);
    });
    statistics.add(Counter::query_points, points.size());
  }

 private:
  /// Finds the photons of a query point. Returns their 1 / r^2.
  float find(Vec3 x, Vec3 normal, Scratch& scratch) const {
    if (policy_.kind == RadiusKind::nearest) return find_nearest(x, normal, scratch);
    map_.within(x, normal, policy_.min_normal_cosine, policy_.radius, scratch.found, scratch.tested);
    return 1 / (policy_.radius * policy_.radius);
  }

  float find_nearest(Vec3 x, Vec3 normal, Scratch& scratch) const {
    scratch.found.clear();
    const bool limited = policy_.max_radius > 0;
    const float limit = limited ? policy_.max_radius * policy_.max_radius : std::numeric_limits<float>::infinity();
    float first_limit = limit;
    if (normal == scratch.last_normal) {
      // The sphere around the last point's photons, from this point, with a margin for rounding.
      const float reach = (scratch.last_radius + length(x - scratch.last_position)) * 1.0001f;
      first_limit = std::min(limit, reach * reach);
    }
    const auto nearest = [&](float within) {
      return map_.nearest(x, normal, policy_.min_normal_cosine, policy_.k, within, scratch.heap, scratch.tested);
    };
    std::size_t count = nearest(first_limit);
    // Some of the last point's photons may lie behind a wall from here.
    if (count < policy_.k && first_limit < limit) count = nearest(limit);
    // The order of the heap depends on the previous point; sums go over the photons from near to far.
    std::sort(scratch.heap.begin(), scratch.heap.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count; ++i) scratch.found.push_back(PhotonMap::unpack(scratch.heap[i]));
    scratch.last_radius = std::numeric_limits<float>::infinity();
    if (count == 0) return 0;
    float r2 = scratch.found.back().distance_squared;
    if (count == policy_.k) {
      scratch.last_position = x;
      scratch.last_normal = normal;
      scratch.last_radius = std::sqrt(r2);
    } else if (limited) {
      r2 = limit;
    }
    // All photons lie at the point itself: infinite density, nothing sensible can be added.
    if (r2 == 0) scratch.found.clear();
    return r2 > 0 ? 1 / r2 : 0;
  }

  /// 1 / r^2 K(|x - y| / r) of a photon.
  float weight(const FoundPhoton& photon, float scale) const {
    return scale * kernel(policy_.kernel, std::min(photon.distance_squared * scale, 1.0f));
  }

  RGB lambertian(RGB reflectance, float scale, const Scratch& scratch) const {
    double r = 0, g = 0, b = 0;
    for (const FoundPhoton& photon : scratch.found) {
      const float w = weight(photon, scale);
      const RGB flux = map_.flux(photon.place);
      r += double(w * flux.r);
      g += double(w * flux.g);
      b += double(w * flux.b);
    }
    return reflectance * RGB(float(r), float(g), float(b)) * kInversePi;
  }

  RGB other(const QueryBsdf& query, float scale, Scratch& scratch) const {
    scratch.gathered.clear();
    for (const FoundPhoton& photon : scratch.found) {
      scratch.gathered.push_back(map_.direction(photon.place), map_.flux(photon.place) * weight(photon, scale));
    }
    return scratch.shader.shade(query, scratch.gathered);
  }

  RadiusPolicy policy_;
  PhotonMap map_;
};

}  // namespace

std::unique_ptr<DensityEngine> make_knn_engine() { return std::make_unique<KnnEngine>(); }

}  // namespace glowworm
