// Every pair of segment and volume photon, or piece of a beam, in double precision.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "density/volume_radii.h"
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

/// Henyey-Greenstein, sr^-1. @param cosine of the angle of deflection
inline double henyey_greenstein(double g, double cosine) {
  return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

inline bool counts(const VolumeSegments& segments, std::size_t i) {
  return segments.length[i] > 0 && is_finite(segments.origin[i]) && is_finite(segments.direction[i]);
}

/// Adds weight T p flux.
inline void add_scattered(Radiance& sum, const VolumeSegments& segments, std::size_t i, double t, Vec3 travel,
                          double weight, RGB flux) {
  const SegmentMedium& medium = segments.medium[i];
  const double p = henyey_greenstein(medium.g, -inner(vector(travel), vector(segments.direction[i])));
  for (int c = 0; c < 3; ++c) sum[c] += weight * std::exp(-double{medium.sigma_t[c]} * t) * p * double{flux[c]};
}

inline std::vector<Radiance> brute_points(const VolumePhotons& photons, const std::vector<float>& radii,
                                          const VolumeSegments& segments) {
  std::vector<Radiance> found(segments.size(), Radiance{});
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!counts(segments, i)) continue;
    const Vector d = vector(segments.direction[i]);
    for (std::size_t j = 0; j < photons.size(); ++j) {
      if (photons.medium[j] != segments.medium[i].index) continue;
      const Vector way = plus(vector(photons.position[j]), -1, vector(segments.origin[i]));
      const double t = inner(way, d), r2 = double{radii[j]} * radii[j];
      const Vector away = plus(way, -t, d);
      const double u = inner(away, away) / r2;
      if (t < 0 || t > segments.length[i] || u >= 1) continue;
      add_scattered(found[i], segments, i, t, photons.direction[j], 2 / (std::numbers::pi * r2) * (1 - u),
                    photons.flux[j]);
    }
  }
  return found;
}

/// The integral of the kernel over the part of the segment's line in the tube of a piece, and the middle of that part.
inline double tube_integral(const Vector& origin, const Vector& d, double length, const Vector& begin,
                            const Vector& beam, double beam_length, double radius, double& middle) {
  const Vector way = plus(origin, -1, begin);
  const double s = inner(way, beam), c = inner(d, beam);
  const Vector w = plus(way, -s, beam), x = plus(d, -c, beam);
  const double xx = inner(x, x), wx = inner(w, x);
  double low = 0, high = length;
  if (xx > 1e-20) {
    const double at = -wx / xx, u2 = inner(plus(w, at, x), plus(w, at, x)), r2 = radius * radius;
    if (u2 >= r2) return 0;
    low = std::max(low, at - std::sqrt((r2 - u2) / xx));
    high = std::min(high, at + std::sqrt((r2 - u2) / xx));
  } else if (inner(w, w) >= radius * radius) {
    return 0;
  }
  if (c != 0) {
    low = std::max(low, std::min(-s / c, (beam_length - s) / c));
    high = std::min(high, std::max(-s / c, (beam_length - s) / c));
  } else if (s < 0 || s >= beam_length) {
    return 0;
  }
  if (!(low < high)) return 0;
  middle = (low + high) / 2;
  // Simpson's rule is exact for a quadratic function.
  const auto kernel = [&](double t) {
    const Vector p = plus(w, t, x);
    return 2 / (std::numbers::pi * radius * radius) * (1 - inner(p, p) / (radius * radius));
  };
  return (high - low) / 6 * (kernel(low) + 4 * kernel(middle) + kernel(high));
}

inline std::vector<Radiance> brute_beams(const VolumeBeams& beams, const BeamPieces& pieces,
                                         const VolumeSegments& segments) {
  std::vector<Radiance> found(segments.size(), Radiance{});
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!counts(segments, i)) continue;
    for (std::size_t j = 0; j < beams.size(); ++j) {
      if (beams.medium[j] != segments.medium[i].index) continue;
      const Vector beam = vector(beams.direction[j]);
      const std::uint32_t count = pieces.first[j + 1] - pieces.first[j];
      const double length = double{beams.length[j]} / count;
      for (std::uint32_t n = 0; n < count; ++n) {
        double middle = 0;
        const double weight = tube_integral(vector(segments.origin[i]), vector(segments.direction[i]),
                                            segments.length[i], plus(vector(beams.origin[j]), length * n, beam), beam,
                                            length, pieces.radii[pieces.first[j] + n], middle);
        if (weight > 0)
          add_scattered(found[i], segments, i, middle, beams.direction[j], weight,
                        beams.flux[j] * segments.medium[i].sigma_s);
      }
    }
  }
  return found;
}

}  // namespace glowworm::density_tests
