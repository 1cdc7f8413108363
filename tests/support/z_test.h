// Whether two noisy pictures have the same mean.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/error.h"

namespace glowworm {

/// A picture of estimates: for each entry (pixel and channel) the mean and the variance of that mean.
struct EstimateSpan {
  std::span<const float> mean;
  std::span<const float> variance_of_mean;
};

/// The outcome of z_test.
struct ZTest {
  std::size_t entries = 0;
  std::size_t rejected = 0;  ///< number of entries with a p-value below `threshold`
  double smallest_p = 1;
  double threshold = 0;  ///< threshold for one entry that gives the requested significance for all together
  bool passed() const { return rejected == 0; }
};

/// Tests for each entry whether two unbiased estimates have the same mean. The test is two-sided; the difference of
/// means over the root of the summed variances is taken as standard normal. `significance` is the probability of a
/// false alarm over all entries together (Sidak's correction; for rendered pictures: Subr and Arvo, "Statistical
/// Hypothesis Testing for Assessing Monte Carlo Estimators", Pacific Graphics 2007). Entries without variance must
/// agree to a relative error of 1e-5. Throws Error if the spans differ in size.
inline ZTest z_test(const EstimateSpan& a, const EstimateSpan& b, double significance = 0.01) {
  const std::size_t n = a.mean.size();
  if (b.mean.size() != n || a.variance_of_mean.size() != n || b.variance_of_mean.size() != n) {
    throw Error("the estimates of a z-test differ in size");
  }
  ZTest result;
  result.entries = n;
  // 1 - (1 - significance)^(1/n), accurate even for millions of entries.
  result.threshold = n == 0 ? 0 : -std::expm1(std::log1p(-significance) / static_cast<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const double difference = std::abs(static_cast<double>(a.mean[i]) - static_cast<double>(b.mean[i]));
    const double variance = static_cast<double>(a.variance_of_mean[i]) + static_cast<double>(b.variance_of_mean[i]);
    double p;
    if (variance > 0) {
      p = std::erfc(difference / std::sqrt(2 * variance));
    } else {
      p = difference <= 1e-5 * std::max(std::abs(a.mean[i]), std::abs(b.mean[i])) ? 1 : 0;
    }
    // A NaN mean agrees with nothing.
    if (!(p >= result.threshold)) ++result.rejected;
    result.smallest_p = std::isnan(p) ? 0 : std::min(result.smallest_p, p);
  }
  return result;
}

}  // namespace glowworm
