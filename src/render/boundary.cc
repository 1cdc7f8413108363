#include "render/boundary.h"

#include <algorithm>
#include <cmath>

#include "core/frame.h"
#include "core/parallel.h"
#include "core/random.h"
#include "kernels/kernel_shape.h"
#include "render/boundary_clusters.h"

namespace glowworm {

namespace {

/// Lines per area of a photon's disc: first lines to detect a deviation, and all lines where there is one.
constexpr float kFirstLines = 8, kAllLines = 32;
constexpr std::size_t kClustersPerChunk = 64;
/// A cluster is plain if the first lines give all its photons a mass within this distance of 1.
constexpr float kTolerance = 0.02f;
/// Share of a line that is skipped behind a surface, in addition to rounding, so that the surface is not hit again.
/// There is no limit on the number of surfaces: without all slats of a blind, the mass would be too small.
constexpr float kStep = 1e-3f;
/// Surfaces nearly parallel to a line are ignored; they have no photon's normal.
constexpr float kMinCosine = 0.25f;
/// Share of the cosine within which a place lies in a cluster's plane.
constexpr float kFlatness = 1e-4f;
/// Bounds of the mass: beyond them, a few lines are not significant.
constexpr float kMinMass = 0.125f, kMaxMass = 4;

/// A line along the cluster's normal through a point of its disc, from above its photons to below them.
struct Line {
  Ray ray;
  std::uint32_t cluster;     ///< of the chunk
  std::uint32_t number;      ///< within it
  int depth = 0;             ///< solids entered minus solids left since the photon; places inside a solid are invisible
  std::uint32_t places = 0;  ///< found on it
  float step = kStep;        ///< share of the line, or of the path to it, that is skipped behind a surface
  bool plain = true;         ///< all its places lie in the cluster's plane

  /// Takes the line through a surface.
  void cross(bool front) { depth += front ? 1 : -1; }
};

/// A place on a line where query points may lie.
struct Place {
  Vec3 position, normal;
  float area;          ///< of surface over area of disc
  std::uint32_t line;  ///< of the cluster
};

class Chunk {
 public:
  Chunk(const Tracer& tracer, const PhotonBatch& photons, std::span<const float> radii, KernelShape kernel,
        const BoundaryClusters& all, std::size_t first, std::size_t last)
      : tracer_(tracer),
        photons_(photons),
        radii_(radii),
        kernel_(kernel),
        clusters_(std::span(all.clusters).subspan(first, last - first)),
        members_(all.photons),
        lines_(clusters_.size()),
        places_(clusters_.size()) {}

  /// @param min_cosine as in RadiusPolicy
  void measure(float min_cosine, std::span<float> factors) {
    std::vector<std::uint32_t> unsure;
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) unsure.push_back(c);
    trace(unsure, kFirstLines);
    std::erase_if(unsure, [&](std::uint32_t c) { return is_plain(c, min_cosine); });
    trace(unsure, kAllLines);
    for (const std::uint32_t c : unsure)
      for (const std::uint32_t p : members(c)) factors[p] = 1 / std::clamp(mass(c, p, min_cosine), kMinMass, kMaxMass);
  }

 private:
  std::span<const std::uint32_t> members(std::uint32_t c) const {
    return members_.subspan(clusters_[c].first, clusters_[c].count);
  }

  bool is_plain(std::uint32_t c, float min_cosine) const {
    for (const std::uint32_t p : members(c))
      if (std::abs(mass(c, p, min_cosine) - 1) > kTolerance) return false;
    return true;
  }

  Line make_line(std::uint32_t c, std::uint32_t number) const {
    const BoundaryCluster& cluster = clusters_[c];
    Sampler sampler(SamplerKind::sobol, kBoundaryStream, members(c)[0], number);
    const Vec2 u = sampler.next2();
    const float angle = 2 * kPi * u.x, distance = cluster.reach * std::sqrt(u.y);
    const Frame frame = Frame::from_normal(cluster.normal);
    const Vec3 start = cluster.center + (frame.s * std::cos(angle) + frame.t * std::sin(angle)) * distance +
                       cluster.normal * cluster.high;
    Line line;
    line.cluster = c;
    line.number = number;
    // The path from a photon has at least half the length.
    line.step = kStep + 2 * cluster.step;
    line.ray = {start, 0, cluster.normal * (cluster.low - cluster.high), 1};
    return line;
  }

  /// Adds lines to the clusters `which`, up to `density` of them to the area of a photon's disc.
  void trace(const std::vector<std::uint32_t>& which, float density) {
    batch_.clear();
    for (const std::uint32_t c : which) {
      const auto wanted = static_cast<std::uint32_t>(std::ceil(density * clusters_[c].wideness));
      for (auto n = static_cast<std::uint32_t>(lines_[c].size()); n < wanted; ++n) batch_.push_back(make_line(c, n));
    }
    find_depths();
    found_.clear();
    walk([](const Line& line) { return line.ray; }, [&](std::uint32_t j, const Hit& hit) { meet(j, hit); });
    for (const Line& line : batch_) lines_[line.cluster].push_back(line);
    for (Place place : found_) {
      const Line& line = batch_[place.line];
      place.line = line.number;
      places_[line.cluster].push_back(place);
    }
  }

  /// Counts the solids that contain the start of each line, along the path from a photon, which lies in none: a floor
  /// continues beneath objects on it and beyond the walls.
  void find_depths() {
    const auto way = [&](const Line& line) {
      const auto photons = members(line.cluster);
      const Vec3 photon = photons_.position[photons[line.number % photons.size()]];
      return Ray{photon, line.step, line.ray.origin - photon, 1};
    };
    walk(way, [&](std::uint32_t j, const Hit& hit) {
      batch_[j].cross(dot(tracer_.scene().diffuse_triangle(hit.triangle).normal, way(batch_[j]).direction) < 0);
    });
  }

  /// Traces a ray for each line of the batch through all its hits.
  template <typename MakeRay, typename Meet>
  void walk(MakeRay&& make_ray, Meet&& meet) {
    active_.resize(batch_.size());
    rays_.clear();
    for (std::uint32_t j = 0; j < active_.size(); ++j) {
      active_[j] = j;
      rays_.push_back(make_ray(batch_[j]));
    }
    while (!active_.empty()) {
      hits_.resize(rays_.size());
      tracer_.intersect(rays_, hits_, RayOrder::incoherent);
      std::size_t kept = 0;
      for (std::size_t j = 0; j < active_.size(); ++j) {
        if (hits_[j].triangle == kNone) continue;
        meet(active_[j], hits_[j]);
        active_[kept] = active_[j];
        Ray& ray = rays_[kept++];
        ray = rays_[j];
        ray.t_min = hits_[j].distance + batch_[active_[j]].step;
      }
      active_.resize(kept);
      rays_.resize(kept);
    }
  }

  /// Takes line j through a hit, which is a place unless it is inside a solid.
  void meet(std::uint32_t j, const Hit& hit) {
    Line& line = batch_[j];
    const BoundaryCluster& cluster = clusters_[line.cluster];
    Vec3 normal = tracer_.scene().diffuse_triangle(hit.triangle).normal;
    const float cosine = dot(normal, cluster.normal);
    const bool buried = line.depth > 0;
    line.cross(cosine > 0);
    if (buried || std::abs(cosine) < kMinCosine) return;
    // A single sheet may have either winding.
    if (cosine < 0) normal = -normal;
    const Vec3 position = line.ray.origin + line.ray.direction * hit.distance;
    const float height = dot(position - cluster.center, cluster.normal);
    ++line.places;
    line.plain &= std::abs(height) <= cluster.flatness && std::abs(cosine) >= 1 - kFlatness;
    found_.push_back({position, normal, 1 / std::abs(cosine), j});
  }

  /// The kernel's integral for a photon. The lines' result is compared with their result on an infinite plane, whose
  /// integral is 1, so noise arises only where there is a difference.
  float mass(std::uint32_t c, std::uint32_t photon, float min_cosine) const {
    const BoundaryCluster& cluster = clusters_[c];
    const std::vector<Line>& lines = lines_[c];
    const Vec3 p = photons_.position[photon], n = photons_.normal[photon];
    const float inverse = 1 / (radii_[photon] * radii_[photon]);
    const auto is_as_expected = [&](const Line& line) { return cluster.flat && line.plain && line.places == 1; };
    float difference = 0;
    for (const Place& place : places_[c]) {
      if (is_as_expected(lines[place.line]) || !(dot(place.normal, n) > min_cosine)) continue;
      const float d = length_squared(place.position - p) * inverse;
      if (d < 1) difference += kernel_profile(kernel_, d) * place.area;
    }
    const float cosine = dot(cluster.normal, n);
    if (!(cosine > 0)) return 1;
    for (const Line& line : lines) {
      if (is_as_expected(line)) continue;
      const Vec3 start = line.ray.origin - p;
      const float d = length_squared(start - cluster.normal * (dot(start, n) / cosine)) * inverse;
      if (d < 1) difference -= kernel_profile(kernel_, d) / cosine;
    }
    const float area = kPi * cluster.reach * cluster.reach / static_cast<float>(lines.size());
    return 1 + difference * area * inverse * static_cast<float>(kernel_norm(kernel_));
  }

  const Tracer& tracer_;
  const PhotonBatch& photons_;
  std::span<const float> radii_;
  KernelShape kernel_;
  std::span<const BoundaryCluster> clusters_;
  std::span<const std::uint32_t> members_;
  std::vector<std::vector<Line>> lines_;    ///< traced so far, by cluster
  std::vector<std::vector<Place>> places_;  ///< by cluster
  std::vector<Line> batch_;                 ///< being traced
  std::vector<Place> found_;
  std::vector<std::uint32_t> active_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace

std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy) {
  std::vector<float> factors(photons.size(), 1.0f);
  if (photons.size() == 0) return factors;
  std::vector<float> same;
  if (policy.kind == RadiusKind::fixed) same.assign(photons.size(), policy.radius);
  const std::span<const float> radii = same.empty() ? std::span(policy.radii) : std::span<const float>(same);
  const BoundaryClusters all = make_boundary_clusters(photons, radii);
  parallel_for(0, all.clusters.size(), kClustersPerChunk, [&](std::size_t first, std::size_t last) {
    Chunk(tracer, photons, radii, policy.kernel, all, first, last).measure(policy.min_normal_cosine, factors);
  });
  return factors;
}

}  // namespace glowworm
