// Forward SIMD photon mapping [SF07]: query points are reordered and walk the photon tree in packets.
#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/parallel.h"
#include "density/engines.h"
#include "density/forward.h"
#include "density/shading.h"
#include "kernels/simd.h"

namespace glowworm {

namespace {

// Query points that one thread looks up in turn; a multiple of every packet width.
constexpr std::size_t kPacketGrain = 1024;

/// Query points of a piece in the layout of the kernels.
class PacketQueries {
 public:
  explicit PacketQueries(std::size_t capacity) {
    for (auto& array : arrays_) array.reserve(capacity + kForwardMaxLanes);
  }
  void push_back(std::uint32_t point, Vec3 position, Vec3 normal) {
    points_.push_back(point);
    for (int axis = 0; axis < 3; ++axis) {
      arrays_[axis].push_back(position[axis]);
      arrays_[axis + 3].push_back(normal[axis]);
    }
  }
  /// The points pushed so far; valid until the next push.
  ForwardQueries view() {
    for (auto& array : arrays_) array.resize(points_.size() + kForwardMaxLanes, 0.0f);
    return {arrays_[0].data(), arrays_[1].data(), arrays_[2].data(), arrays_[3].data(),
            arrays_[4].data(), arrays_[5].data(), points_.size()};
  }
  std::size_t size() const { return points_.size(); }
  std::uint32_t point(std::size_t i) const { return points_[i]; }

 private:
  std::vector<std::uint32_t> points_;
  std::array<std::vector<float>, 6> arrays_;
};

class ForwardEngine final : public DensityEngine {
 public:
  explicit ForwardEngine(const ForwardOptions& options) : options_(options) {
    for (const int lanes : {0, 1, 4, 8, 16}) {
      if (options.lanes == lanes) return;
    }
    throw Error("packets hold 1, 4, 8 or 16 query points");
  }

  std::string name() const override { return "forward"; }

  std::uint64_t index_bytes(std::size_t photons) const override {
    return photons * (sizeof(ForwardNode) + sizeof(ForwardHot) + sizeof(ForwardCold) + sizeof(Vec3) +
                      sizeof(ForwardReach) + sizeof(std::uint32_t) + sizeof(Vec3));
  }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    PhaseTimer timer(statistics, Phase::build_photon_map);
    check_policy(photons, policy, "forward");
    map_ = build_forward_map(photons, flux, policy);
    policy_ = policy;
    policy_.radii = {};
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    std::vector<std::uint32_t> order;
    {
      PhaseTimer timer(statistics, Phase::reorder);
      order = hilbert_order(points.position, map_.bounds, map_.nodes.size(), options_.reorder);
    }
    PhaseTimer timer(statistics, Phase::density);
    const int lanes = options_.lanes > 0 ? options_.lanes : forward_lanes();
    const ForwardTree tree = map_.tree(policy_);
    parallel_for(0, order.size(), kPacketGrain, [&](std::size_t first, std::size_t last) {
      PacketQueries lambertian(last - first), others(0);
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t point = order[i];
        PacketQueries& queries = points.bsdf[point] == kLambertianQuery ? lambertian : others;
        queries.push_back(point, points.position[point], points.normal[point]);
      }
      ForwardCounts counts;
      add_lambertian(tree, lanes, points, lambertian, radiance, counts);
      add_others(tree, lanes, points, others, radiance, counts);
      statistics.add(Counter::packet_steps, counts.shadings);
      statistics.add(Counter::packet_active_lanes, counts.active);
      statistics.add(Counter::pairs_tested, counts.active);
      statistics.add(Counter::shader_operations, counts.operations);
    });
    statistics.add(Counter::query_points, points.size());
  }

 private:
  static void add_lambertian(const ForwardTree& tree, int lanes, const QueryPoints& points, PacketQueries& queries,
                             std::span<RGB> radiance, ForwardCounts& counts) {
    if (queries.size() == 0) return;
    std::array<std::vector<float>, 3> sums;
    for (auto& sum : sums) sum.assign(queries.size() + kForwardMaxLanes, 0.0f);
    forward_gather(tree, queries.view(), lanes, sums[0].data(), sums[1].data(), sums[2].data(), counts);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const std::uint32_t point = queries.point(i);
      radiance[point] += points.reflectance[point] * RGB(sums[0][i], sums[1][i], sums[2][i]);
    }
  }

  /// Collects the photons of one packet, then shades them in one batch for each of its points: the search runs on all
  /// lanes whatever the materials, and no material is evaluated pair by pair.
  void add_others(const ForwardTree& tree, int lanes, const QueryPoints& points, PacketQueries& queries,
                  std::span<RGB> radiance, ForwardCounts& counts) const {
    if (queries.size() == 0) return;
    const ForwardQueries view = queries.view();
    std::vector<ForwardPair> pairs;
    std::array<GatheredPhotons, kForwardMaxLanes> gathered;
    BatchShader shader;
    for (std::size_t first = 0; first < queries.size(); first += static_cast<std::size_t>(lanes)) {
      pairs.clear();
      forward_collect(tree, view, first, lanes, pairs, counts);
      for (GatheredPhotons& photons : gathered) photons.clear();
      for (const ForwardPair& pair : pairs) {
        const float* flux = map_.cold[pair.photon].flux;
        // The map's flux includes the 1 / pi of Lambertian surfaces.
        const RGB weighted = RGB(flux[0], flux[1], flux[2]) * (kPi * pair.profile);
        gathered[pair.query - first].push_back(map_.direction[pair.photon], weighted);
      }
      const std::size_t count = std::min(queries.size() - first, static_cast<std::size_t>(lanes));
      for (std::size_t lane = 0; lane < count; ++lane) {
        const std::uint32_t point = queries.point(first + lane);
        radiance[point] += shader.shade(points.bsdfs[points.bsdf[point]], gathered[lane]);
      }
    }
  }

  ForwardOptions options_;
  RadiusPolicy policy_;
  ForwardMap map_;
};

}  // namespace

int forward_lanes() { return std::clamp(simd_lanes(), 4, kForwardMaxLanes); }

std::unique_ptr<DensityEngine> make_forward_engine(const ForwardOptions& options) {
  return std::make_unique<ForwardEngine>(options);
}
std::unique_ptr<DensityEngine> make_forward_engine() { return make_forward_engine(ForwardOptions()); }

}  // namespace glowworm
