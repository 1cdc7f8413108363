#include "density/boundary.h"

#include <algorithm>
#include <cmath>

#include "core/frame.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/kernel.h"

namespace glowworm {

namespace {

/// Lines that look whether anything is amiss, and more that measure how much where something is.
constexpr std::uint32_t kFirstLines = 8, kMoreLines = 24;
constexpr std::size_t kPhotonsPerChunk = 512;
/// Masses this near to 1 are taken for 1.
constexpr float kTolerance = 0.02f;
/// Share of a line that is skipped behind a surface, so that it is not met again.
constexpr float kStep = 1e-3f;
/// Surfaces that a line is followed through.
constexpr int kMostHits = 6;
/// Bounds of the mass: beyond them a few lines say nothing.
constexpr float kSmallestMass = 0.125f, kLargestMass = 4;

/// A line along the photon's normal through a point of its disc, from one radius above to one below.
struct Line {
  Ray ray;
  float in_plane;        ///< distance of the point from the photon, in radii
  std::uint32_t photon;  ///< of the chunk
  int depth = 0;         ///< of solids entered less left since the photon; what lies within a solid nobody sees

  /// Takes the line through a surface.
  void cross(bool front) { depth += front ? 1 : -1; }
};

class Chunk {
 public:
  Chunk(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy, std::size_t first)
      : tracer_(tracer), photons_(photons), policy_(policy), first_(first) {}

  void measure(std::span<float> factors) {
    std::vector<std::uint32_t> all(factors.size()), unsure;
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    std::vector<float> mass(factors.size(), 0.0f);
    add_mass(all, 0, kFirstLines, mass);
    for (const std::uint32_t i : all)
      if (std::abs(mass[i] / kFirstLines - 1) > kTolerance) unsure.push_back(i);
    add_mass(unsure, kFirstLines, kMoreLines, mass);
    std::fill(factors.begin(), factors.end(), 1.0f);
    for (const std::uint32_t i : unsure)
      factors[i] = 1 / std::clamp(mass[i] / (kFirstLines + kMoreLines), kSmallestMass, kLargestMass);
  }

 private:
  float radius(std::uint32_t i) const {
    return policy_.kind == RadiusKind::fixed ? policy_.radius : policy_.radii[first_ + i];
  }

  Line make_line(std::uint32_t i, std::uint32_t number) const {
    const std::size_t photon = first_ + i;
    Sampler sampler(SamplerKind::sobol, 0x626f756eu, static_cast<std::uint32_t>(photon), number);
    const Vec2 u = sampler.next2();
    const float angle = 2 * kPi * u.x;
    Line line;
    line.in_plane = sample_kernel_distance(policy_.kernel, u.y);
    line.photon = i;
    const Frame frame = Frame::from_normal(photons_.normal[photon]);
    const float r = radius(i);
    const Vec3 across = (frame.s * std::cos(angle) + frame.t * std::sin(angle)) * (r * line.in_plane);
    line.ray = {photons_.position[photon] + across + frame.n * r, 0, frame.n * (-r), 2};
    return line;
  }

  void add_mass(const std::vector<std::uint32_t>& which, std::uint32_t offset, std::uint32_t count,
                std::vector<float>& mass) {
    lines_.clear();
    for (const std::uint32_t i : which)
      for (std::uint32_t n = 0; n < count; ++n) lines_.push_back(make_line(i, offset + n));
    find_depths();
    walk([](const Line& line) { return line.ray; },
         [&](Line& line, const Hit& hit) { mass[line.photon] += mass_at(line, hit); });
  }

  /// Counts the solids that the starts of the lines lie in, on the way to each from its photon, which lies in none: a
  /// floor goes on beneath what stands on it, and beyond the walls.
  void find_depths() {
    walk(
        [&](const Line& line) {
          const Vec3 photon = photons_.position[first_ + line.photon];
          return Ray{photon, kStep, line.ray.origin - photon, 1};
        },
        [&](Line& line, const Hit& hit) {
          const Vec3 way = line.ray.origin - photons_.position[first_ + line.photon];
          line.cross(dot(tracer_.scene().geometry().normal(hit.triangle), way) < 0);
        });
  }

  /// Follows a ray for each line through all that it meets.
  template <typename MakeRay, typename Meet>
  void walk(MakeRay&& make_ray, Meet&& meet) {
    active_.resize(lines_.size());
    rays_.clear();
    for (std::uint32_t j = 0; j < active_.size(); ++j) {
      active_[j] = j;
      rays_.push_back(make_ray(lines_[j]));
    }
    for (int hit = 0; hit < kMostHits && !active_.empty(); ++hit) {
      hits_.resize(rays_.size());
      tracer_.intersect(rays_, hits_, RayOrder::incoherent);
      std::size_t kept = 0;
      for (std::size_t j = 0; j < active_.size(); ++j) {
        if (hits_[j].triangle == kNone) continue;
        meet(lines_[active_[j]], hits_[j]);
        active_[kept] = active_[j];
        rays_[kept] = rays_[j];
        rays_[kept++].t_min = hits_[j].distance + kStep;
      }
      active_.resize(kept);
      rays_.resize(kept);
    }
  }

  /// What the surface at a hit adds: kernel there over the density of the line there.
  float mass_at(Line& line, const Hit& hit) const {
    const std::size_t photon = first_ + line.photon;
    float cosine = dot(tracer_.scene().geometry().normal(hit.triangle), photons_.normal[photon]);
    const bool buried = line.depth > 0;
    line.cross(cosine > 0);
    if (buried) return 0;
    // A single sheet may be wound either way.
    cosine = std::abs(cosine);
    if (cosine <= policy_.min_normal_cosine) return 0;
    const Vec3 place = line.ray.origin + line.ray.direction * hit.distance;
    const float distance = length(place - photons_.position[photon]) / radius(line.photon);
    if (distance >= 1) return 0;
    const float density = kernel_profile(policy_.kernel, line.in_plane * line.in_plane);
    return density > 0 ? kernel_profile(policy_.kernel, distance * distance) / (density * cosine) : 0;
  }

  const Tracer& tracer_;
  const PhotonBatch& photons_;
  const RadiusPolicy& policy_;
  std::size_t first_;
  std::vector<Line> lines_;
  std::vector<std::uint32_t> active_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace

float sample_kernel_distance(KernelShape kernel, float u) {
  switch (kernel) {
    case KernelShape::box:
      return std::sqrt(u);
    case KernelShape::epanechnikov:
      return std::sqrt(1 - std::sqrt(1 - u));
    case KernelShape::gaussian: {
      // Standard deviation 1/3 of the radius, cut at the radius.
      constexpr float inverse_variance = 9;
      const float cut = 1 - std::exp(-0.5f * inverse_variance);
      return std::sqrt(std::min(1.0f, -2 / inverse_variance * std::log(1 - u * cut)));
    }
    case KernelShape::cone: {
      // The distribution 3 d^2 - 2 d^3 inverted: the trigonometric root of the cubic.
      return 0.5f - std::sin(std::asin(1 - 2 * u) / 3);
    }
  }
  return 0;
}

std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy) {
  std::vector<float> factors(photons.size(), 1.0f);
  parallel_for(0, photons.size(), kPhotonsPerChunk, [&](std::size_t first, std::size_t last) {
    Chunk(tracer, photons, policy, first).measure(std::span(factors).subspan(first, last - first));
  });
  return factors;
}

}  // namespace glowworm
