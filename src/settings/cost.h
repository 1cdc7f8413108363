// What work costs. Renders with a time limit, their schedules and interactive sessions plan by it.
#pragma once
#include <cstdint>

namespace glowworm {

/// Seconds of a unit of work.
struct Cost {
  double pixel_s = 0;   ///< of a camera sample, without its gather rays
  double ray_s = 0;     ///< of a gather ray, with the lookup at its end
  double photon_s = 0;  ///< of a photon, with its part of the map

  /// Seconds of a camera sample with this number of gather rays.
  double sample_s(double gather) const { return pixel_s + gather * ray_s; }
};

/// On one core of 2020, at most; newer ones are two or three times as fast.
inline constexpr Cost kUsualCost{1e-6, 2e-6, 25e-6};
/// A machine of which other programs take the most part needs this multiple of kUsualCost, at most.
inline constexpr double kMostSlowdown = 10;

/// Fewest photons that are chosen for a picture.
inline constexpr std::uint64_t kLeastPhotons = 1000;

/// A number rounded down to two digits, at least 1: it is a choice, not a measurement.
std::uint64_t two_digits(double value);

}  // namespace glowworm
