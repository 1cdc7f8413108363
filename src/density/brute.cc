// The engine without an index: every photon against every query point.
#include <algorithm>

#include "core/parallel.h"
#include "density/engines.h"
#include "density/shading.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

double distance_squared(Vec3 a, Vec3 b) {
  const double x = double(a.x) - b.x, y = double(a.y) - b.y, z = double(a.z) - b.z;
  return x * x + y * y + z * z;
}

/// A photon in the support of its kernel.
struct Pair {
  double distance_squared;
  double radius_squared;
  std::uint32_t photon;
};

class BruteEngine final : public DensityEngine {
 public:
  std::string name() const override { return "brute"; }

  std::uint64_t index_bytes(std::size_t photons) const override {
    return photons * (bytes_each<PhotonBatch>() + sizeof(float));
  }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    PhaseTimer timer(statistics, Phase::build_photon_map);
    check_policy(photons, policy);
    photons_ = photons;
    photons_.flux.assign(flux.begin(), flux.end());
    policy_ = policy;
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    PhaseTimer timer(statistics, Phase::density);
    parallel_for(0, points.size(), 16, [&](std::size_t first, std::size_t last) {
      std::vector<Pair> pairs;
      GatheredPhotons gathered;
      BatchShader shader;
      std::uint64_t operations = 0;
      for (std::size_t i = first; i < last; ++i) {
        find_pairs(points.position[i], points.normal[i], pairs);
        operations += pairs.size();
        radiance[i] += points.bsdf[i] == kLambertianQuery
                           ? lambertian(points.reflectance[i], pairs)
                           : other(points.bsdfs[points.bsdf[i]], pairs, gathered, shader);
      }
      statistics.add(Counter::shader_operations, operations);
    });
    statistics.add(Counter::query_points, points.size());
    statistics.add(Counter::pairs_tested, static_cast<std::uint64_t>(points.size()) * photons_.size());
  }

 private:
  void find_pairs(Vec3 x, Vec3 normal, std::vector<Pair>& pairs) const {
    pairs.clear();
    for (std::uint32_t j = 0; j < photons_.size(); ++j) {
      if (!(dot(photons_.normal[j], normal) > policy_.min_normal_cosine)) continue;
      if (const PhotonCuts* cuts = cuts_of(policy_.cuts, j); cuts && !cuts->keep(x - photons_.position[j])) continue;
      const double d2 = distance_squared(x, photons_.position[j]);
      if (policy_.kind == RadiusKind::nearest) {
        const double limit = policy_.max_radius;
        if (limit == 0 || d2 < limit * limit) pairs.push_back({d2, 0, j});
      } else {
        const double h = policy_.kind == RadiusKind::fixed ? policy_.radius : policy_.radii[j];
        if (d2 < h * h) pairs.push_back({d2, h * h, j});
      }
    }
    if (policy_.kind == RadiusKind::nearest) keep_nearest(pairs);
  }

  /// Keeps the k nearest, nearest first, with the distance of the last as their radius; if there are fewer than k, with
  /// the maximal radius. Photons at equal distance keep the order of the batch.
  void keep_nearest(std::vector<Pair>& pairs) const {
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return a.distance_squared != b.distance_squared ? a.distance_squared < b.distance_squared : a.photon < b.photon;
    });
    const bool full = pairs.size() >= policy_.k;
    if (full) pairs.resize(policy_.k);
    if (pairs.empty()) return;
    const double limit = double(policy_.max_radius) * policy_.max_radius;
    const double r2 = !full && limit > 0 ? limit : pairs.back().distance_squared;
    if (r2 == 0) pairs.clear();  // infinite density: nothing sensible can be added
    for (Pair& pair : pairs) pair.radius_squared = r2;
  }

  double weight(const Pair& pair) const {
    return kernel(policy_.kernel, pair.distance_squared / pair.radius_squared) / pair.radius_squared;
  }

  RGB lambertian(RGB reflectance, const std::vector<Pair>& pairs) const {
    double sum[3] = {0, 0, 0};
    for (const Pair& pair : pairs) {
      const double w = weight(pair) / std::numbers::pi;
      const RGB& flux = photons_.flux[pair.photon];
      for (int c = 0; c < 3; ++c) sum[c] += w * flux[c];
    }
    return {float(sum[0] * reflectance.r), float(sum[1] * reflectance.g), float(sum[2] * reflectance.b)};
  }

  RGB other(const QueryBsdf& query, const std::vector<Pair>& pairs, GatheredPhotons& gathered,
            BatchShader& shader) const {
    gathered.clear();
    for (const Pair& pair : pairs) {
      gathered.push_back(photons_.direction[pair.photon], photons_.flux[pair.photon] * float(weight(pair)));
    }
    return shader.shade(query, gathered);
  }

  PhotonBatch photons_;
  RadiusPolicy policy_;
};

}  // namespace

std::unique_ptr<DensityEngine> make_brute_engine() { return std::make_unique<BruteEngine>(); }

}  // namespace glowworm
