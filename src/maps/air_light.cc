#include "maps/air_light.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/make_parts.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "transport/medium.h"

namespace glowworm {

namespace {

/// Points that are looked up together: they fit the second-level cache, and their photons a few megabytes.
constexpr std::size_t kPointsAtOnce = 4096;
/// The largest radius over the one of evenly spread photons, as for photons on surfaces.
constexpr float kMostOfEven = 4;
/// Places of a disc that tell which part of it a point sees.
constexpr std::size_t kPlaces = 64;

/// A photon that passes a point.
struct NearPhoton {
  float radius_squared = 0, distance = 0;
  std::uint32_t segment = 0;
};
struct Crossing {
  std::uint32_t point = 0;
  NearPhoton photon;
};

/// Evenly spread places of the unit disc (Vogel, "A better way to construct the sunflower head", 1979).
const std::array<Vec2, kPlaces>& even_places() {
  static const std::array<Vec2, kPlaces> places = [] {
    std::array<Vec2, kPlaces> out;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const double radius = std::sqrt((static_cast<double>(i) + 0.5) / kPlaces);
      const double angle = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
      out[i] = {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle))};
    }
    return out;
  }();
  return places;
}

/// The kernel of a part of a disc around its middle, over the share of it that a point sees.
class DiscKernel {
 public:
  /// @param squared radius of the disc, m^2 @param part of its area @param hidden for each of even_places()
  DiscKernel(KernelShape shape, float squared, float part, std::span<const std::uint8_t> hidden)
      : shape_(shape), squared_(squared * part) {
    double all = 0, seen = 0;
    for (std::size_t p = 0; p < kPlaces; ++p) {
      const Vec2 place = even_places()[p];
      const float w = weight((place.x * place.x + place.y * place.y) / part);
      all += w;
      if (!hidden[p]) seen += w;
    }
    // A point that sees a photon sees a part of the disc, if a small one.
    factor_ = static_cast<float>(all / std::max(seen, all / kPlaces)) / squared_;
  }
  /// m^-2. @param squared distance from the middle, m^2
  float at(float squared) const { return weight(squared / squared_) * factor_; }

 private:
  float weight(float share) const { return share < 1 ? kernel(shape_, share) : 0; }

  KernelShape shape_;
  float squared_, factor_ = 0;
};

/// Estimates for a few points.
class Lookup {
 public:
  Lookup(const Tracer& tracer, const AirLight& light, std::span<const AirPoint> points)
      : tracer_(tracer),
        light_(light),
        points_(points),
        radius_(points.size(), light.most_radius),
        near_(points.size()) {}

  /// Finds the nearest photons of each point, and its radius. Each step takes twice the photons of the one before, and
  /// the radii that these have left: so no point ever holds many more photons than it needs.
  void find_photons() {
    const std::size_t enough = 2 * (std::size_t{light_.nearest} + 1);
    for (std::size_t stride = std::bit_floor(std::max<std::size_t>(light_.segments.size() / enough, 1));; stride /= 2) {
      find_crossings(stride);
      parallel_for_each(points_.size(), even_grain(points_.size()), [&](std::size_t i) { keep_nearest(i); });
      if (stride == 1) return;
    }
  }

  void add(SlotRadiance& radiance, std::vector<RGB>& part, Statistics& statistics) const {
    parallel_for(0, points_.size(), even_grain(points_.size()), [&](std::size_t first, std::size_t last) {
      std::uint64_t rays = 0;
      for (std::size_t i = first; i < last; ++i) rays += add(i, radiance, part);
      statistics.add(Counter::occlusion_rays, rays);
    });
  }

 private:
  void find_crossings(std::size_t stride) {
    std::vector<Disc> discs;
    for (std::size_t i = 0; i < points_.size(); ++i)
      discs.push_back({points_[i].position, points_[i].normal, radius_[i]});
    const DiscTree tree(std::move(discs));
    for (std::vector<NearPhoton>& near : near_) near.clear();
    const std::size_t count = (light_.segments.size() + stride - 1) / stride;
    const std::size_t grain = even_grain(count);
    const auto find = [&](std::size_t chunk, std::vector<Crossing>& found) {
      found.clear();
      for (std::size_t i = chunk * grain; i < std::min((chunk + 1) * grain, count); ++i) {
        const auto number = static_cast<std::uint32_t>(i * stride);
        const PhotonSegment& segment = light_.segments[number];
        tree.for_crossed(segment.origin, segment.direction, segment.length, [&](const DiscCrossing& c) {
          found.push_back({c.disc, {c.radius_squared, c.distance, number}});
          return true;
        });
      }
    };
    make_parts<std::vector<Crossing>>((count + grain - 1) / grain, find, [&](const std::vector<Crossing>& found) {
      for (const Crossing& crossing : found) near_[crossing.point].push_back(crossing.photon);
    });
  }

  /// Keeps the k nearest photons, within the distance of the next.
  void keep_nearest(std::size_t i) {
    std::vector<NearPhoton>& near = near_[i];
    if (near.size() <= light_.nearest) return;
    const auto next = near.begin() + light_.nearest;
    std::nth_element(near.begin(), next, near.end(), [](const NearPhoton& a, const NearPhoton& b) {
      return a.radius_squared != b.radius_squared ? a.radius_squared < b.radius_squared : a.segment < b.segment;
    });
    radius_[i] = std::sqrt(next->radius_squared);
    near.erase(next, near.end());
  }

  /// Adds the light of a point; returns the number of rays.
  std::size_t add(std::size_t i, SlotRadiance& radiance, std::vector<RGB>& part) const {
    const AirPoint& point = points_[i];
    const float radius = radius_[i] * light_.radius_scale, squared = radius * radius;
    std::vector<NearPhoton> near;
    std::vector<Ray> rays;
    for (const NearPhoton& photon : near_[i]) {
      if (!(photon.radius_squared < squared)) continue;
      const PhotonSegment& segment = light_.segments[photon.segment];
      near.push_back(photon);
      rays.push_back({point.position, 0, segment.origin + segment.direction * photon.distance - point.position, 1});
    }
    if (near.empty()) return 0;
    const Frame frame = Frame::from_normal(point.normal);
    for (const Vec2 place : even_places())
      rays.push_back({point.position, 0, (frame.s * place.x + frame.t * place.y) * radius, 1});
    std::vector<std::uint8_t> hidden(rays.size());
    tracer_.occluded(rays, hidden);
    const std::span<const std::uint8_t> hidden_places = std::span(hidden).subspan(near.size());
    const DiscKernel whole(light_.kernel, squared, 1, hidden_places), half(light_.kernel, squared, 0.5f, hidden_places);
    for (std::size_t n = 0; n < near.size(); ++n) {
      if (hidden[n]) continue;
      const PhotonSegment& segment = light_.segments[near[n].segment];
      const RGB left = transmittance(segment.absorption, near[n].distance);
      const float of_whole = whole.at(near[n].radius_squared),
                  weight = light_.extrapolates ? 2 * half.at(near[n].radius_squared) - of_whole : of_whole;
      radiance.add(part, point.slot, segment.flux * left * weight, segment.light);
    }
    return rays.size();
  }

  const Tracer& tracer_;
  const AirLight& light_;
  std::span<const AirPoint> points_;
  std::vector<float> radius_;                  // of each point
  std::vector<std::vector<NearPhoton>> near_;  // photons of each point
};

}  // namespace

AirPoint air_point(const Scene& scene, const PointGrid& grid, std::size_t cell, std::uint32_t slot) {
  const SurfacePoint point = white_point(scene, grid, cell);
  return {offset_origin(point.position, point.geometric_normal, point.offset), point.geometric_normal, slot};
}

std::vector<AirPoint> air_points(const GatherPoints& points) {
  std::vector<AirPoint> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    out.push_back(
        {offset_origin(points.position[i], points.normal[i], points.offset[i]), points.normal[i], points.slot[i]});
  return out;
}

DiscTree air_discs(const Scene& scene, const PointGrid& grid, float radius) {
  std::vector<Disc> discs;
  for (std::size_t cell = 0; cell < grid.normal.size(); ++cell) {
    if (!grid.has(cell)) continue;
    const AirPoint point = air_point(scene, grid, cell, 0);
    discs.push_back({point.position, point.normal, radius});
  }
  return DiscTree(std::move(discs));
}

float most_air_radius(const Scene& scene, std::uint64_t photons, std::uint32_t nearest) {
  return kMostOfEven * scene.radius() *
         static_cast<float>(
             std::sqrt(static_cast<double>(nearest) / static_cast<double>(std::max<std::uint64_t>(photons, 1))));
}

double even_air_photons(std::size_t discs, std::uint32_t nearest) {
  return double{kMostOfEven} * kMostOfEven * nearest * static_cast<double>(discs);
}

void add_air_light(const Tracer& tracer, const AirLight& light, std::span<const AirPoint> points,
                   SlotRadiance& radiance, std::vector<RGB>& part, Statistics& statistics) {
  if (light.segments.empty()) return;
  for (std::size_t first = 0; first < points.size(); first += kPointsAtOnce) {
    Lookup lookup(tracer, light, points.subspan(first, std::min(kPointsAtOnce, points.size() - first)));
    lookup.find_photons();
    lookup.add(radiance, part, statistics);
  }
}

}  // namespace glowworm
