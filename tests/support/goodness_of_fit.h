// Statistical tests of counts and of means, for samplers with fixed seeds.
//
// Every test gives a p-value: the chance of a deviation as large as the one seen, were the sampler right. A family of
// tests that may fail by chance once in 1 / kFamilySignificance choices of seeds divides that among its members
// (Bonferroni's correction): expect_fit(p, members).
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/random.h"
#include "core/vec.h"
#include "support/chi_squared.h"

namespace glowworm {

inline constexpr double kFamilySignificance = 0.01;

/// Expects that a test of a family of `members` did not reject.
inline void expect_fit(double p_value, int members, const char* what) {
  EXPECT_GT(p_value, kFamilySignificance / members) << what;
}

/// Pearson's test of counts against expected counts. Cells of small expectation are put together until each holds ten;
/// a count where nothing at all is expected makes the p-value 0.
inline ChiSquaredResult chi_squared_counts(std::span<const double> observed, std::span<const double> expected) {
  ChiSquaredResult result;
  std::vector<std::size_t> order(observed.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return expected[a] < expected[b]; });
  double pooled_observed = 0, pooled_expected = 0;
  int cells = 0;
  bool impossible = false;
  for (std::size_t n = 0; n < order.size(); ++n) {
    impossible = impossible || (expected[order[n]] == 0 && observed[order[n]] > 0);
    pooled_observed += observed[order[n]];
    pooled_expected += expected[order[n]];
    const bool last = n + 1 == order.size();
    if ((pooled_expected < 10 && !last) || pooled_expected == 0) continue;
    result.statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    pooled_observed = pooled_expected = 0;
    ++cells;
  }
  result.degrees = cells - 1;
  result.p_value = impossible ? 0 : chi_squared_tail(result.statistic, result.degrees);
  return result;
}

/// Tests points of the unit square against a density over it, on a grid of cells.
/// @param point (index) -> Vec2; @param density (Vec2) -> per unit of area, constant or smooth within each cell
template <class Point, class Density>
ChiSquaredResult chi_squared_square(const Point& point, const Density& density, int samples, int columns, int rows) {
  std::vector<double> observed(static_cast<std::size_t>(columns) * rows), expected(observed.size());
  for (int n = 0; n < samples; ++n) {
    const Vec2 p = point(n);
    const int x = std::clamp(static_cast<int>(p.x * columns), 0, columns - 1);
    const int y = std::clamp(static_cast<int>(p.y * rows), 0, rows - 1);
    ++observed[static_cast<std::size_t>(y) * columns + x];
  }
  ChiSquaredResult result;
  const auto at = [&](double x, double y) {
    return static_cast<double>(density(Vec2{static_cast<float>(x), static_cast<float>(y)}));
  };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const double x0 = x / static_cast<double>(columns), x1 = (x + 1.0) / columns;
      const double y0 = y / static_cast<double>(rows), y1 = (y + 1.0) / rows;
      const double share = integrate_rectangle(at, x0, x1, y0, y1, 1e-7, 0, 6, gauss_rectangle(at, x0, x1, y0, y1));
      expected[static_cast<std::size_t>(y) * columns + x] = share * samples;
      result.integral += share;
    }
  const double integral = result.integral;
  result = chi_squared_counts(observed, expected);
  result.integral = integral;
  return result;
}

/// As chi_squared_sphere(), for densities with jumps (edges of lights, texels): integrates by a jittered grid in each
/// cell, which costs the same whatever the density does. A cell that a jump crosses is wrong by some 1/steps^1.5 of
/// what it holds, far below the error of the counts.
template <class SampleDirection, class Density>
ChiSquaredResult chi_squared_sphere_of_jumps(const SampleDirection& sample_direction, const Density& density,
                                             int samples) {
  constexpr int cosine_bins = 12, angle_bins = 12, steps = 64, bins = cosine_bins * angle_bins;
  const double pi = std::acos(-1.0);
  std::vector<double> observed(bins + 1, 0.0), expected(bins + 1, 0.0);
  for (int n = 0; n < samples; ++n) {
    int bin = bins;
    if (const std::optional<Vec3> w = sample_direction(n)) {
      const double turn = (std::atan2(w->y, w->x) + pi) / (2 * pi);
      bin = std::clamp(static_cast<int>((0.5 * w->z + 0.5) * cosine_bins), 0, cosine_bins - 1) * angle_bins +
            std::clamp(static_cast<int>(turn * angle_bins), 0, angle_bins - 1);
    }
    ++observed[bin];
  }
  double integral = 0;
  for (int row = 0; row < cosine_bins * steps; ++row)
    for (int column = 0; column < angle_bins * steps; ++column) {
      const std::uint32_t key = hash_combine(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column));
      const double z = 2 * (row + to_unit_float(key)) / (cosine_bins * steps) - 1, r = std::sqrt(1 - z * z);
      const double phi = 2 * pi * (column + to_unit_float(hash32(key))) / (angle_bins * steps) - pi;
      const double share = 4 * pi / (bins * steps * steps) *
                           density(Vec3{static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                                        static_cast<float>(z)});
      expected[(row / steps) * angle_bins + column / steps] += share * samples;
      integral += share;
    }
  // A sliver that no point of the grid fell on is not impossible.
  for (int bin = 0; bin < bins; ++bin) expected[bin] = std::max(expected[bin], 0.01);
  expected[bins] = std::abs(1 - integral) < 1e-3 ? 0.0 : (1 - integral) * samples;
  // What is lost by chance where nothing should be is for the caller to see in `integral`, not for this test.
  if (expected[bins] == 0) expected[bins] = observed[bins];
  ChiSquaredResult result = chi_squared_counts(observed, expected);
  result.integral = integral;
  return result;
}

/// Mean and variance of numbers that come one by one (Welford's algorithm, Technometrics 4(3), 1962).
class RunningMean {
 public:
  void add(double x) {
    ++count_;
    const double before = x - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before * (x - mean_);
  }
  double mean() const { return mean_; }
  /// Standard error of the mean, by the sample's own variance.
  double standard_error() const {
    const double n = static_cast<double>(count_);
    return std::sqrt(squares_ / (n - 1) / n);
  }
  /// Two-sided p-value of the mean against `expected`. Rounding of single precision is no deviation, so a relative
  /// difference of 1e-6 is always granted: it matters where all numbers are equal.
  double z_test(double expected) const {
    const double difference = std::max(0.0, std::abs(mean_ - expected) - 1e-6 * std::abs(expected));
    if (difference == 0) return 1;
    const double error = standard_error();
    return error > 0 ? std::erfc(difference / error / std::sqrt(2.0)) : 0.0;
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

}  // namespace glowworm
