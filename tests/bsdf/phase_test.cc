#include "bsdf/phase.h"

#include <gtest/gtest.h>

namespace glowworm {
namespace {

/// The directions of samples have the density of the function: each bin of the cosine holds its integral.
TEST(Phase, SamplesFollowTheFunction) {
  constexpr int kBins = 20, kSamples = 20000, kSteps = 2000;
  const Vec3 wo = normalize({0.3f, -0.5f, 0.8f});
  for (const float g : {-0.9f, -0.3f, 0.0f, 0.5f, 0.95f}) {
    double count[kBins] = {}, mean_cosine = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 wi = sample_henyey_greenstein(wo, g, {(static_cast<float>(i) + 0.5f) / kSamples, 0.37f});
      EXPECT_NEAR(length(wi), 1, 1e-5f);
      const float cosine = -dot(wo, wi);
      mean_cosine += cosine / kSamples;
      ++count[std::clamp(static_cast<int>((cosine + 1) / 2 * kBins), 0, kBins - 1)];
    }
    EXPECT_NEAR(mean_cosine, g, 1e-3) << g;
    for (int bin = 0; bin < kBins; ++bin) {
      double integral = 0;
      for (int s = 0; s < kSteps; ++s) {
        const float cosine = -1 + 2 * (static_cast<float>(bin) + (static_cast<float>(s) + 0.5f) / kSteps) / kBins;
        integral += double{henyey_greenstein(cosine, g)} * 2 * kPi * 2 / (kBins * kSteps);
      }
      EXPECT_NEAR(count[bin] / kSamples, integral, 2e-3 + 2e-3 * integral) << g << " " << bin;
    }
  }
}

TEST(Phase, IsotropicScatteringIsTheSameEverywhere) {
  for (const float cosine : {-1.0f, 0.2f, 1.0f}) EXPECT_FLOAT_EQ(henyey_greenstein(cosine, 0), kInversePi / 4);
}

}  // namespace
}  // namespace glowworm
