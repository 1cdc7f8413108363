#include "density/boundary.h"

#include <algorithm>
#include <cmath>
#include <utility>

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
/// Surfaces that a line is followed through.
constexpr int kMostHits = 6;
/// Bounds of the mass: beyond them a few lines say nothing.
constexpr float kSmallestMass = 0.125f, kLargestMass = 4;

/// A line along the photon's normal through a point of its disc, from one radius above to one below.
struct Line {
  Ray ray;
  float in_plane;        ///< distance of the point from the photon, in radii
  std::uint32_t photon;  ///< of the chunk
  bool inside = false;   ///< of a solid that the line has entered
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

  Line make_line(std::uint32_t i, std::uint32_t number, std::uint32_t count, std::uint32_t offset) const {
    const std::size_t photon = first_ + i;
    Sampler sampler(SamplerKind::independent, 0x626f756eu, static_cast<std::uint32_t>(photon), offset + number);
    const Vec2 u = sampler.next2();
    const float angle = 2 * kPi * (static_cast<float>(number) + u.x) / static_cast<float>(count);
    // Rings are taken in another order than angles, so that each quarter of the disc has near and far points.
    const float ring = (static_cast<float>(number * 5 % count) + u.y) / static_cast<float>(count);
    Line line;
    line.in_plane = sample_kernel_distance(policy_.kernel, ring);
    line.photon = i;
    const Frame frame = Frame::from_normal(photons_.normal[photon]);
    const float r = radius(i);
    const Vec3 across = (frame.s * std::cos(angle) + frame.t * std::sin(angle)) * (r * line.in_plane);
    line.ray = {photons_.position[photon] + across + frame.n * r, 0, frame.n * (-r), 2};
    return line;
  }

  void add_mass(const std::vector<std::uint32_t>& which, std::uint32_t offset, std::uint32_t count,
                std::vector<float>& mass) {
    std::vector<Line> lines;
    lines.reserve(which.size() * count);
    for (const std::uint32_t i : which)
      for (std::uint32_t n = 0; n < count; ++n) lines.push_back(make_line(i, n, count, offset));
    for (int hit = 0; hit < kMostHits && !lines.empty(); ++hit) {
      rays_.clear();
      for (const Line& line : lines) rays_.push_back(line.ray);
      hits_.resize(rays_.size());
      tracer_.intersect(rays_, hits_, RayOrder::incoherent);
      std::size_t kept = 0;
      for (std::size_t j = 0; j < lines.size(); ++j) {
        if (hits_[j].triangle == kNone) continue;
        mass[lines[j].photon] += mass_at(lines[j], hits_[j]);
        lines[j].ray.t_min = hits_[j].distance + 1e-3f;
        lines[kept++] = lines[j];
      }
      lines.resize(kept);
    }
  }

  /// What the surface at a hit adds: kernel there over the density of the line there.
  float mass_at(Line& line, const Hit& hit) const {
    const std::size_t photon = first_ + line.photon;
    float cosine = dot(tracer_.scene().geometry().normal(hit.triangle), photons_.normal[photon]);
    if (cosine < 0) {
      // The far side of a solid is lit by nobody; a single sheet may be wound either way.
      if (std::exchange(line.inside, false)) return 0;
      cosine = -cosine;
    } else {
      line.inside = true;
    }
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
