// The statistical tests: they match closed forms and reject wrong samplers.
#include "support/goodness_of_fit.h"

#include <cmath>

#include "core/random.h"
#include "core/warp.h"

namespace glowworm {
namespace {

TEST(ChiSquaredTail, EvenDegreesAreAPoissonSum) {
  // Q(k, x) = e^-x sum of x^i / i! for i < k (Abramowitz and Stegun 26.4.21).
  for (const int k : {1, 2, 5, 20, 100})
    for (const double x : {0.01, 0.5, 1.0, 4.0, 19.0, 21.0, 99.0, 130.0}) {
      double term = std::exp(-x), sum = term;
      for (int i = 1; i < k; ++i) sum += term *= x / i;
      EXPECT_NEAR(chi_squared_tail(2 * x, 2 * k), sum, 1e-11) << "k " << k << " x " << x;
    }
}

TEST(ChiSquaredTail, OneDegreeIsTheNormalTail) {
  for (const double z : {0.1, 0.7, 1.0, 1.96, 3.0, 6.0})
    EXPECT_NEAR(chi_squared_tail(z * z, 1) / std::erfc(z / std::sqrt(2.0)), 1, 1e-9) << z;
}

TEST(ChiSquaredTail, DegreesRiseByTheRecurrence) {
  // Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1) (DLMF 8.8.6), across the switch from series to fraction.
  for (const int degrees : {1, 3, 9, 51, 255})
    for (const double share : {0.3, 0.9, 1.0, 1.1, 2.0}) {
      const double a = 0.5 * degrees, x = share * a;
      const double step = std::exp(a * std::log(x) - x - std::lgamma(a + 1));
      EXPECT_NEAR(chi_squared_tail(2 * x, degrees + 2), chi_squared_tail(2 * x, degrees) + step, 1e-11);
    }
}

TEST(ChiSquaredCounts, AcceptsFairDiceAndRejectsLoadedOnes) {
  const auto p_value = [](float bias) {
    std::vector<double> observed(6), expected(6, 10000);
    for (std::uint32_t i = 0; i < 60000; ++i) {
      const float u = to_unit_float(hash_combine(17, i));
      ++observed[u < bias ? 0 : static_cast<int>(to_unit_float(hash_combine(18, i)) * 6)];
    }
    return chi_squared_counts(observed, expected).p_value;
  };
  EXPECT_GT(p_value(0), kFamilySignificance);
  EXPECT_LT(p_value(0.02f), 1e-6);
}

TEST(ChiSquaredCounts, RejectsTheImpossible) {
  const std::vector<double> expected = {500, 500, 0};
  EXPECT_EQ(chi_squared_counts(std::vector<double>{500, 499, 1}, expected).p_value, 0);
  EXPECT_EQ(chi_squared_counts(std::vector<double>{500, 500, 0}, expected).p_value, 1);
}

TEST(ChiSquaredSphere, RejectsACosineTakenForUniform) {
  const auto cosine = [](int i) -> std::optional<Vec3> {
    return square_to_cosine_hemisphere({to_unit_float(hash_combine(1, i)), to_unit_float(hash_combine(2, i))});
  };
  EXPECT_LT(chi_squared_sphere(
                cosine, [](Vec3 w) { return w.z > 0 ? kInversePi / 2 : 0.0f; }, 20000)
                .p_value,
            1e-12);
}

TEST(ZTest, AcceptsTheMeanAndRejectsAnother) {
  RunningMean uniform;
  for (std::uint32_t i = 0; i < 40000; ++i) uniform.add(to_unit_float(hash_combine(5, i)));
  EXPECT_GT(uniform.z_test(0.5), kFamilySignificance);
  EXPECT_LT(uniform.z_test(0.51), 1e-6);
  // The variance of the uniform distribution is 1/12; its estimate from n numbers errs by 1/sqrt(n) or so.
  EXPECT_NEAR(uniform.standard_error() * std::sqrt(40000.0 * 12), 1, 0.02);
}

}  // namespace
}  // namespace glowworm
