// sample() against pdf() and evaluate(), for every kind.
#include <gtest/gtest.h>

#include "bsdf/cases.h"
#include "core/random.h"
#include "support/chi_squared.h"

namespace glowworm {
namespace {

const Lobes kMasks[] = {kAllLobes, kBroad, kGlossy, kSpecular, kDiffuseReflection, kSpecular | kDiffuseReflection};

/// Masks of different effect on a BSDF.
std::vector<Lobes> masks_of(const Bsdf& bsdf) {
  std::vector<Lobes> out;
  for (const Lobes mask : kMasks) {
    const Lobes effective = mask & lobes(bsdf);
    if (effective && std::find(out.begin(), out.end(), effective) == out.end()) out.push_back(effective);
  }
  return out;
}

BsdfSample draw(const Bsdf& bsdf, Vec3 wo, Lobes mask, std::uint32_t sequence, std::uint32_t index,
                Transport transport = Transport::radiance) {
  Sampler sampler(SamplerKind::independent, 7, sequence, index);
  const float u_lobe = sampler.next1();
  return sample(bsdf, wo, u_lobe, sampler.next2(), mask, transport);
}

/// With fixed seeds; the level holds for all tests together (Sidak's correction).
void expect_samples_follow_density(const std::vector<BsdfCase>& cases, int samples) {
  struct Run {
    const BsdfCase* c;
    Vec3 wo;
    Lobes mask;
  };
  std::vector<Run> runs;
  for (const BsdfCase& c : cases)
    for (const Vec3 wo : viewers())
      for (const Lobes mask : masks_of(c.bsdf)) runs.push_back({&c, wo, mask});
  const double level = 1 - std::pow(1 - 0.01, 1.0 / static_cast<double>(runs.size()));
  std::uint32_t sequence = 0;
  for (const auto& [c, wo, mask] : runs) {
    ++sequence;
    const ChiSquaredResult result = chi_squared_sphere(
        [&, &bsdf = c->bsdf, wo = wo, mask = mask](int i) -> std::optional<Vec3> {
          const BsdfSample s = draw(bsdf, wo, mask, sequence, i);
          return s.valid && !s.delta ? std::optional(s.wi) : std::nullopt;
        },
        [&bsdf = c->bsdf, wo = wo, mask = mask](Vec3 wi) { return pdf(bsdf, wo, wi, mask); }, samples);
    EXPECT_GT(result.p_value, level) << c->name << ", wo.z " << wo.z << ", lobes " << int{mask} << ": chi-squared "
                                     << result.statistic << " with " << result.degrees << " degrees of freedom";
    EXPECT_LT(result.integral, 1 + 1e-3) << c->name << ", wo.z " << wo.z << ", lobes " << int{mask};
  }
}

TEST(SlowBsdfSampling, FollowsItsDensity) { expect_samples_follow_density(bsdf_cases(), 20000); }

TEST(BsdfSampling, FollowsItsDensityForOneOfEachShape) {
  std::vector<BsdfCase> few;
  Bsdf pane = metallic_roughness({0.9f, 0.8f, 0.7f}, 0.2f, 0.3f);
  pane.transmission_weight = 0.7f;
  few.push_back({"glTF glass", pane});
  pane.thin = true;
  few.push_back({"glTF pane", pane});
  few.push_back({"glass", glass(0.3f)});
  few.push_back({"coated silver", coated_silver(0.3f, 0)});
  few.push_back({"coated diffuse", coated_diffuse({0.8f, 0.4f, 0.05f}, 0.2f)});
  Bsdf cloth = metallic_roughness({0.9f, 0.8f, 0.7f}, 0, 0.4f);
  cloth.sheen = {1, 0.8f, 0.5f};
  cloth.sheen_alpha = 0.3f;
  cloth.diffuse_transmission = 0.5f;
  cloth.transmission = RGB(0.5f);
  few.push_back({"glTF cloth", cloth});
  Bsdf coat = metallic_roughness(RGB(0.5f), 0, 0.4f);
  coat.coat = 1;
  coat.coat_alpha = 0.2f;
  coat.coat_normal = normalize({0.3f, 0.1f, 0.9f});
  few.push_back({"glTF coat of another normal", coat});
  expect_samples_follow_density(few, 10000);
}

TEST(BsdfSampling, WeightIsValueTimesCosineOverDensity) {
  std::uint32_t sequence = 1000;
  for (const BsdfCase& c : bsdf_cases()) {
    for (const Vec3 wo : viewers()) {
      for (const Lobes mask : masks_of(c.bsdf)) {
        ++sequence;
        for (std::uint32_t i = 0; i < 200; ++i) {
          const BsdfSample s = draw(c.bsdf, wo, mask, sequence, i);
          if (!s.valid) continue;
          EXPECT_TRUE(s.lobe & mask) << c.name;
          EXPECT_EQ(s.lobe & (s.lobe - 1), 0) << c.name;
          EXPECT_NEAR(length(s.wi), 1, 1e-5f) << c.name;
          if (s.delta) {
            EXPECT_GT(s.pdf, 0);
            EXPECT_LE(s.pdf, 1 + 1e-6f);
            continue;
          }
          const float density = pdf(c.bsdf, wo, s.wi, mask);
          const RGB expected = evaluate(c.bsdf, wo, s.wi, mask) * (std::abs(s.wi.z) / density);
          EXPECT_NEAR(s.pdf, density, 1e-3f * density) << c.name;
          for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(s.weight[k], expected[k], 2e-3f * expected[k] + 1e-6f) << c.name << ", wo.z " << wo.z;
        }
      }
    }
  }
}

// Flux scattered from wo to wi is radiance scattered from wo to wi of the reversed path.
TEST(BsdfSampling, CarriesFluxByTheReversedFunction) {
  std::uint32_t sequence = 5000;
  for (const BsdfCase& c : bsdf_cases()) {
    for (const Vec3 wo : viewers()) {
      ++sequence;
      for (std::uint32_t i = 0; i < 100; ++i) {
        const BsdfSample s = draw(c.bsdf, wo, kBroad, sequence, i, Transport::flux);
        if (!s.valid) continue;
        const RGB expected = evaluate(c.bsdf, s.wi, wo, kBroad) * (std::abs(s.wi.z) / pdf(c.bsdf, wo, s.wi, kBroad));
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(s.weight[k], expected[k], 5e-3f * expected[k] + 1e-6f) << c.name << ", wo.z " << wo.z;
      }
    }
  }
}

}  // namespace
}  // namespace glowworm
