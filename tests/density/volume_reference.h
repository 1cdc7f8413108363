// Every pair of segment and volume photon, or piece of a beam, in double precision.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "density/volume_radii.h"
#include "kernels/volume.h"
#include "points/volume_photons.h"
#include "points/volume_segments.h"

namespace glowworm::density_tests {

using Vector = std::array<double, 3>;
using Radiance = std::array<double, 3>;

inline Vector vector(Vec3 v) { return {v.x, v.y, v.z}; }
inline double inner(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
/// a + s b
inline Vector plus(const Vector& a, double s, const Vector& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}

/// Random numbers, places in the unit cube, directions and colours, by index.
inline float hash_number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(hash32(i), which)); }
inline Vec3 hash_place(std::uint32_t i, std::uint32_t which) {
  return {hash_number(i, which), hash_number(i, which + 1), hash_number(i, which + 2)};
}
inline Vec3 hash_direction(std::uint32_t i, std::uint32_t which) {
  const float z = 2 * hash_number(i, which) - 1, phi = 2 * kPi * hash_number(i, which + 1), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline RGB hash_colour(std::uint32_t i, std::uint32_t which) {
  const Vec3 p = hash_place(i, which);
  return {p.x, p.y, p.z};
}

/// Henyey-Greenstein, sr^-1. @param cosine of the angle of deflection
inline double henyey_greenstein(double g, double cosine) {
  return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

inline bool segment_counts(const VolumeSegments& segments, std::size_t i) {
  return segments.length[i] > 0 && is_finite(segments.origin[i]) && is_finite(segments.direction[i]);
}

/// Adds weight T p flux. @param weight with T, of each channel
inline void add_scattered(Radiance& sum, const VolumeSegments& segments, std::size_t i, Vec3 travel,
                          const Radiance& weight, RGB flux) {
  const double p = henyey_greenstein(segments.medium[i].g, -inner(vector(travel), vector(segments.direction[i])));
  for (int c = 0; c < 3; ++c) sum[c] += weight[c] * p * double{flux[c]};
}

/// T at a distance, of each channel, times a weight.
inline Radiance transmitted(const SegmentMedium& medium, double t, double weight) {
  Radiance found;
  for (int c = 0; c < 3; ++c) found[c] = weight * std::exp(-double{medium.sigma_t[c]} * t);
  return found;
}

inline std::vector<Radiance> brute_points(const VolumePhotons& photons, const PhotonKernels& kernels,
                                          const VolumeSegments& segments) {
  std::vector<Radiance> found(segments.size(), Radiance{});
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!segment_counts(segments, i)) continue;
    const Vector d = vector(segments.direction[i]);
    for (std::size_t j = 0; j < photons.size(); ++j) {
      if (photons.medium[j] != segments.medium[i].index) continue;
      const Vector way = plus(vector(photons.position[j]), -1, vector(segments.origin[i]));
      const double t = inner(way, d), r2 = double{kernels.radii[j]} * kernels.radii[j];
      const Vector away = plus(way, -t, d);
      const double u = inner(away, away) / r2;
      if (t < 0 || t > segments.length[i] || u >= 1) continue;
      double weight = 1 - u;
      double further[kWallsOfKernel], gap = 0, x = 0;
      Vector across[kWallsOfKernel] = {};
      bool before = true;
      for (std::size_t n = 0; n < kWallsOfKernel; ++n) {
        further[n] = std::numeric_limits<double>::infinity();
        const Vector wall = vector(kernels.walls[j][n]);
        const double slope = std::sqrt(std::max(inner(wall, wall) - inner(wall, d) * inner(wall, d), 0.0));
        if (!(slope > 0)) continue;
        // The line where the wall cuts the disc, and the place, by the coordinate across the line.
        const double line = 1 / slope, at = -inner(wall, away) / slope;
        for (int axis = 0; axis < 3; ++axis) across[n][axis] = (wall[axis] - inner(wall, d) * d[axis]) / slope;
        gap += line / std::sqrt(r2);
        if (n == 0) x = at;
        before &= at < line;
        // Of the mirror image of the place.
        further[n] = ((2 * line - at) * (2 * line - at) - at * at) / r2;
      }
      if (!before) continue;
      for (const double image : {further[0], further[1], further[0] + further[1]})
        weight += std::max(0.0, 1 - u - image);
      if (gap < kNarrowGap && inner(across[0], across[1]) < kFacing)
        weight = 4 * std::pow(1 - u + x * x / r2, 1.5) / (3 * gap);
      add_scattered(found[i], segments, i, photons.direction[j],
                    transmitted(segments.medium[i], t, 2 / (std::numbers::pi * r2) * weight), photons.flux[j]);
    }
  }
  return found;
}

/// The integral of kernel times T over the part of a segment in the tube of a piece.
inline Radiance tube_integral(const VolumeSegments& segments, std::size_t i, const Vector& begin, const Vector& beam,
                              double beam_length, double radius) {
  const Vector d = vector(segments.direction[i]), way = plus(vector(segments.origin[i]), -1, begin);
  const double s = inner(way, beam), c = inner(d, beam), r2 = radius * radius;
  const Vector w = plus(way, -s, beam), x = plus(d, -c, beam);
  const double xx = inner(x, x), wx = inner(w, x);
  double low = 0, high = segments.length[i];
  if (xx > 1e-20) {
    const double at = -wx / xx, u2 = inner(plus(w, at, x), plus(w, at, x));
    if (u2 >= r2) return {};
    low = std::max(low, at - std::sqrt((r2 - u2) / xx));
    high = std::min(high, at + std::sqrt((r2 - u2) / xx));
  } else if (inner(w, w) >= r2) {
    return {};
  }
  if (c != 0) {
    low = std::max(low, std::min(-s / c, (beam_length - s) / c));
    high = std::min(high, std::max(-s / c, (beam_length - s) / c));
  } else if (s < 0 || s >= beam_length) {
    return {};
  }
  if (!(low < high)) return {};
  // Simpson's rule.
  constexpr int kSteps = 16;
  Radiance sum{};
  for (int n = 0; n <= kSteps; ++n) {
    const double t = low + (high - low) * n / kSteps;
    const Vector p = plus(w, t, x);
    const double weight = n == 0 || n == kSteps ? 1 : n % 2 == 1 ? 4 : 2;
    const Radiance part =
        transmitted(segments.medium[i], t, weight * 2 / (std::numbers::pi * r2) * std::max(0.0, 1 - inner(p, p) / r2));
    for (int channel = 0; channel < 3; ++channel) sum[channel] += (high - low) / (3 * kSteps) * part[channel];
  }
  return sum;
}

inline std::vector<Radiance> brute_beams(const VolumeBeams& beams, const BeamPieces& pieces,
                                         const VolumeSegments& segments) {
  std::vector<Radiance> found(segments.size(), Radiance{});
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!segment_counts(segments, i)) continue;
    for (std::size_t j = 0; j < beams.size(); ++j) {
      if (beams.medium[j] != segments.medium[i].index) continue;
      const Vector beam = vector(beams.direction[j]);
      for (std::uint32_t piece = pieces.first[j]; piece < pieces.first[j + 1]; ++piece) {
        const double begin = pieces.begin(j, piece);
        const Radiance weight = tube_integral(segments, i, plus(vector(beams.origin[j]), begin, beam), beam,
                                              pieces.end[piece] - begin, pieces.radii[piece]);
        add_scattered(found[i], segments, i, beams.direction[j], weight, beams.flux[j] * segments.medium[i].sigma_s);
      }
    }
  }
  return found;
}

}  // namespace glowworm::density_tests
