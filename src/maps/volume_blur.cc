#include "maps/volume_blur.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bsdf/phase.h"
#include "core/parallel.h"
#include "kernels/volume.h"
#include "maps/medium_parts.h"
#include "points/photon_batch.h"

namespace glowworm {

namespace {

/// Beams along which a medium is measured, and points that they meet.
constexpr std::size_t kMostBeams = 256, kMostPoints = 65'536;
/// The factor whose blur is measured, and the limit of those that are chosen.
constexpr float kWider = 2;
/// Where radii are wide beside the free path, light at the borders of a medium is blurred to places from which more of
/// it, or less, gets out. This is an error of the mean, which no number of rays averages out. A radius changes the
/// transmittance by (sigma_t r)^2 / 6 to second order: by no more than this where radii grow.
constexpr double kMostShift = 0.005;

/// The elements of each medium.
std::vector<std::vector<std::uint32_t>> elements_of_media(std::span<const std::uint32_t> medium, std::size_t media) {
  std::vector<std::vector<std::uint32_t>> out(media);
  for (std::uint32_t i = 0; i < medium.size(); ++i) out[medium[i]].push_back(i);
  return out;
}

/// Some of the elements, evenly.
std::vector<std::uint32_t> some_of(std::span<const std::uint32_t> all, std::size_t most) {
  const std::size_t step = (all.size() + most - 1) / std::max<std::size_t>(most, 1);
  std::vector<std::uint32_t> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

/// Light along a line, by radii and by wider ones.
struct LineLight {
  double own = 0, wide = 0;          ///< sums
  double noise = 0, difference = 0;  ///< sums of squares: of the terms of `wide`, and of what the wider radii change

  /// With the own radii, estimated by the wider ones; relative to the square of the sum.
  double variance() const { return double{kWider} * kWider * noise / (wide * wide); }
  /// The square of what the wider radii blur, relative to the sum; right in the mean, so it may be negative.
  double blur() const { return ((wide - own) * (wide - own) - difference) / (wide * wide); }
};

/// The square distances of the mirror images of a point across its walls from a line, beyond that of the point.
struct Folds {
  std::array<double, kWallsOfKernel> further{};
  double gap = 0;      ///< the sum of the distances to the walls, metres
  double across = 0;   ///< how far the foot is towards the first wall, metres
  bool before = true;  ///< whether the line's foot lies before all walls
  bool facing = false;

  /// @param foot from the point to its foot on the line
  Folds(const std::array<Vec3, kWallsOfKernel>& walls, Vec3 direction, Vec3 foot) {
    double lengths = 1;
    for (std::size_t i = 0; i < kWallsOfKernel; ++i) {
      const double from = 1 - dot(walls[i], foot), slope = dot(walls[i], direction);
      const double squared = std::max(double{dot(walls[i], walls[i])} - slope * slope, 1e-30);
      further[i] = 4 * from / squared;
      before &= from > 0;
      gap += 1 / std::sqrt(squared);
      if (i == 0) across = dot(walls[i], foot) / std::sqrt(squared);
      lengths *= std::sqrt(squared);
    }
    facing = dot(walls[0], walls[1]) - dot(walls[0], direction) * dot(walls[1], direction) < kFacing * lengths;
  }
  /// The kernel with a radius, at a square distance.
  double kernel(double squared, double radius) const {
    const auto image = [&](double beyond) { return std::max(1 - (squared + beyond) / (radius * radius), 0.0); };
    if (facing && gap < double{kNarrowGap} * radius)
      return 4 * std::pow(image(-across * across), 1.5) * radius / (3 * gap);
    return image(0) + image(further[0]) + image(further[1]) + image(further[0] + further[1]);
  }
};

/// Sums the points along a beam, but for those at its ends, which the beam itself leads to.
LineLight light_along(const VolumeBeams& beams, std::uint32_t beam, float g, const VolumePhotons& points,
                      const PhotonKernels& kernels) {
  constexpr float kEnd = 1e-3f;
  const Vec3 origin = beams.origin[beam], direction = beams.direction[beam];
  const float length = beams.length[beam];
  LineLight out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 way = origin - points.position[i];
    const float t = -dot(way, direction);
    const Vec3 across = way + direction * t;
    const float wide = kWider * kernels.radii[i], squared = dot(across, across);
    if (!(squared < wide * wide) || t < kEnd * length || t > (1 - kEnd) * length) continue;
    const Folds folds(kernels.walls[i], direction, across);
    if (!folds.before) continue;
    const double own = kernels.radii[i];
    const double flux =
        double{luminance(points.flux[i])} * double{henyey_greenstein(-dot(direction, points.direction[i]), g)};
    const double of_own = flux / (own * own) * folds.kernel(squared, own);
    const double of_wide = flux / (double{wide} * wide) * folds.kernel(squared, wide);
    out.own += of_own;
    out.wide += of_wide;
    out.noise += of_wide * of_wide;
    out.difference += (of_wide - of_own) * (of_wide - of_own);
  }
  return out;
}

/// @param share of the medium's points that were summed
float best_factor(std::span<const LineLight> lines, double share) {
  // Lines are weighted by the inverse of their variance: dark places carry little information.
  double weights = 0, blur = 0, count = 0;
  for (const LineLight& line : lines) {
    if (!(line.wide > 0)) continue;
    weights += 1 / line.variance();
    blur += line.blur() / line.variance();
    ++count;
  }
  if (!(count > 0)) return 1;
  constexpr double kGrowth = kWider * kWider - 1;
  const double variance = share * count / weights, squared_blur = blur / weights / (kGrowth * kGrowth);
  if (!(squared_blur > 0)) return kWider;
  return static_cast<float>(
      std::clamp(std::pow(variance / (2 * squared_blur), 1.0 / 6), 1 / double{kWider}, double{kWider}));
}

/// How far radii may grow. @param points of a medium
float most_factor(const Medium& medium, const VolumePhotons& points, const PhotonKernels& kernels) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const MediumPoint here = medium_point(medium, points.position[i]);
    sum += double{kernels.radii[i]} * double{max_component(here.sigma_a + here.sigma_s)};
  }
  const double thickness = sum / static_cast<double>(points.size());
  return thickness > 0 ? std::max(1.0f, static_cast<float>(std::sqrt(6 * kMostShift) / thickness)) : kWider;
}

}  // namespace

std::vector<float> best_radius_factors(const Tracer& tracer, const MediaPhotons& photons,
                                       const PhotonKernels& kernels) {
  const std::span<const Medium> media = tracer.scene().media();
  std::vector<float> out(media.size(), 1.0f);
  const auto beams_of = elements_of_media(photons.beams.medium, media.size()),
             points_of = elements_of_media(photons.points.medium, media.size());
  for (std::uint32_t m = 0; m < media.size(); ++m) {
    const std::vector<std::uint32_t> lines = some_of(beams_of[m], kMostBeams),
                                     some = some_of(points_of[m], kMostPoints);
    if (some.empty() || lines.empty()) continue;
    VolumePhotons points = photons.points.permuted(some);
    PhotonKernels with_walls = kernels.permuted(some);
    correct_photons(tracer, kWider, points, with_walls);
    std::vector<LineLight> light(lines.size());
    parallel_for_each(lines.size(), 1, [&](std::size_t i) {
      light[i] = light_along(photons.beams, lines[i], media[m].g, points, with_walls);
    });
    const double share = static_cast<double>(some.size()) / static_cast<double>(points_of[m].size());
    out[m] = std::min(best_factor(light, share), most_factor(media[m], points, with_walls));
  }
  return out;
}

}  // namespace glowworm
