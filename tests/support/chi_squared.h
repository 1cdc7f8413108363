// Pearson's chi-squared test of a sampling routine over the sphere against its density.
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// Probability that a chi-squared variable with this many degrees of freedom is at least `statistic`: the regularised
/// upper incomplete gamma function Q(degrees / 2, statistic / 2), by its series or its continued fraction (Abramowitz
/// and Stegun, "Handbook of Mathematical Functions", 6.5.29 and 6.5.31).
inline double chi_squared_tail(double statistic, int degrees) {
  const double a = 0.5 * degrees, x = 0.5 * statistic;
  if (x <= 0 || degrees <= 0) return 1;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 10000 && term > sum * 1e-15; ++n) sum += term *= x / (a + n);
    return std::clamp(1 - front * sum, 0.0, 1.0);
  }
  // Lentz's method from the top.
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int n = 1; n < 10000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    const double factor = c * d;
    h *= factor;
    if (std::abs(factor - 1) < 1e-15) break;
  }
  return std::clamp(front * h, 0.0, 1.0);
}

struct ChiSquaredResult {
  double statistic = 0;
  int degrees = 0;
  double p_value = 1;   ///< chance of a statistic as large, if the density is that of the samples
  double integral = 0;  ///< of the density over the sphere
};

/// Gauss's 3 x 3 points.
template <class F>
double gauss_rectangle(const F& f, double x0, double x1, double y0, double y1) {
  static constexpr double kNodes[3] = {-0.774596669241483377, 0, 0.774596669241483377};
  static constexpr double kWeights[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      sum += kWeights[i] * kWeights[j] *
             f(0.5 * (x0 + x1) + 0.5 * (x1 - x0) * kNodes[i], 0.5 * (y0 + y1) + 0.5 * (y1 - y0) * kNodes[j]);
  return sum * 0.25 * (x1 - x0) * (y1 - y0);
}

/// Integrates f over a rectangle, cutting it into four where the whole and the parts disagree.
/// @param whole gauss_rectangle() of the rectangle
template <class F>
double integrate_rectangle(const F& f, double x0, double x1, double y0, double y1, double tolerance, int least_depth,
                           int most_depth, double whole) {
  const double mx = 0.5 * (x0 + x1), my = 0.5 * (y0 + y1);
  const double a = gauss_rectangle(f, x0, mx, y0, my), b = gauss_rectangle(f, mx, x1, y0, my);
  const double c = gauss_rectangle(f, x0, mx, my, y1), d = gauss_rectangle(f, mx, x1, my, y1);
  const double parts = a + b + c + d;
  if (least_depth <= 0 && (most_depth <= 0 || std::abs(whole - parts) < tolerance)) return parts;
  const auto part = [&](double ax, double bx, double ay, double by, double value) {
    return integrate_rectangle(f, ax, bx, ay, by, tolerance, least_depth - 1, most_depth - 1, value);
  };
  return part(x0, mx, y0, my, a) + part(mx, x1, y0, my, b) + part(x0, mx, my, y1, c) + part(mx, x1, my, y1, d);
}

/// @param sample_direction (index) -> std::optional<Vec3>: the sample of that index, or nothing where it was lost; a
///                         density may integrate to less than 1, and the rest must be the share of lost samples
/// @param density (Vec3) -> per steradian
template <class SampleDirection, class Density>
ChiSquaredResult chi_squared_sphere(const SampleDirection& sample_direction, const Density& density, int samples,
                                    int cosine_bins = 16, int angle_bins = 16) {
  const std::size_t bins = static_cast<std::size_t>(cosine_bins) * angle_bins;
  std::vector<double> observed(bins + 1, 0.0), expected(bins + 1, 0.0);
  for (int n = 0; n < samples; ++n) {
    const std::optional<Vec3> w = sample_direction(n);
    if (!w) {
      ++observed[bins];
      continue;
    }
    const double turn = (std::atan2(w->y, w->x) + kPi) / (2 * kPi);
    const int i = std::clamp(static_cast<int>((0.5 * w->z + 0.5) * cosine_bins), 0, cosine_bins - 1);
    const int j = std::clamp(static_cast<int>(turn * angle_bins), 0, angle_bins - 1);
    ++observed[i * angle_bins + j];
  }
  ChiSquaredResult result;
  const double pi = std::acos(-1.0);
  for (int i = 0; i < cosine_bins; ++i) {
    // By distances from the nearer pole, over which narrow lobes around a pole are as wide as elsewhere.
    const double z0 = 2.0 * i / cosine_bins - 1, z1 = 2.0 * (i + 1) / cosine_bins - 1, pole = z0 + z1 < 0 ? -1 : 1;
    const auto in_distance = [&](double distance, double phi) {
      const double square = distance * distance, r = distance * std::sqrt(std::max(0.0, 2 - square));
      return 2 * distance *
             density(Vec3{static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                          static_cast<float>(pole * (1 - square))});
    };
    const double near = std::sqrt(std::min(1 - pole * z0, 1 - pole * z1));
    const double far = std::sqrt(std::max(1 - pole * z0, 1 - pole * z1));
    for (int j = 0; j < angle_bins; ++j) {
      const double phi0 = 2 * pi * j / angle_bins - pi, phi1 = 2 * pi * (j + 1) / angle_bins - pi;
      const double share = integrate_rectangle(in_distance, near, far, phi0, phi1, 1e-5, 0, 12,
                                               gauss_rectangle(in_distance, near, far, phi0, phi1));
      expected[i * angle_bins + j] = share * samples;
      result.integral += share;
    }
  }
  expected[bins] = std::max(0.0, 1 - result.integral) * samples;

  // Bins where little is expected are put together until ten samples are, so that the statistic is near chi-squared.
  std::vector<std::size_t> order(bins + 1);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return expected[a] < expected[b]; });
  double pooled_observed = 0, pooled_expected = 0;
  int cells = 0;
  for (std::size_t n = 0; n < order.size(); ++n) {
    pooled_observed += observed[order[n]];
    pooled_expected += expected[order[n]];
    if (pooled_expected < 10 && n + 1 < order.size()) continue;
    // Nothing expected and something seen must fail, so the divisor is kept from zero and no more.
    const double difference = pooled_observed - pooled_expected;
    result.statistic += difference * difference / std::max(pooled_expected, 1.0);
    pooled_observed = pooled_expected = 0;
    ++cells;
  }
  result.degrees = cells - 1;
  result.p_value = chi_squared_tail(result.statistic, result.degrees);
  return result;
}

}  // namespace glowworm
