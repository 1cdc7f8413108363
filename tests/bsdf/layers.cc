// Coated surfaces against a random walk of light between the two boundaries.
#include <gtest/gtest.h>

#include <array>

#include "bsdf/cases.h"
#include "core/random.h"
#include "core/warp.h"

namespace glowworm {
namespace {

constexpr int kBins = 5;  // of equal projected solid angle, all around

/// Share of the flux from one direction that leaves by way of the base, by the squared cosine it leaves at.
struct Outgoing {
  std::array<double, kBins> share{};
  double total = 0;
  void add(Vec3 w, double flux) {
    const int bin = std::min(kBins - 1, static_cast<int>(kBins * w.z * w.z));
    share[bin] += flux;
    total += flux;
  }
};

/// The layers as they are built: a dielectric boundary above a base, absorbing on each passage by its depth. What the
/// boundary reflects at once is left out.
Outgoing walk(const Bsdf& boundary, const Bsdf& base, float depth, int bounces, Vec3 from, int paths) {
  Outgoing out;
  for (int path = 0; path < paths; ++path) {
    Sampler sampler(SamplerKind::independent, 21, 4, path);
    const auto scatter = [&sampler](const Bsdf& bsdf, Vec3 w) {
      const float u_lobe = sampler.next1();
      return sample(bsdf, w, u_lobe, sampler.next2(), kAllLobes, Transport::flux);
    };
    double flux = 1.0 / paths;
    BsdfSample s = scatter(boundary, from);
    if (!s.valid || s.wi.z > 0) continue;
    flux *= s.weight.r;
    for (int bounce = 0; bounce < bounces; ++bounce) {
      flux *= std::exp(-depth / -s.wi.z);
      s = scatter(base, -s.wi);
      if (!s.valid) break;
      flux *= s.weight.r * std::exp(-depth / s.wi.z);
      s = scatter(boundary, -s.wi);
      if (!s.valid) break;
      flux *= s.weight.r;
      if (s.wi.z > 0) {
        out.add(s.wi, flux);
        break;
      }
    }
  }
  return out;
}

/// The same by sampling the coated BSDF's lobe of the base.
Outgoing model(const Bsdf& coated, Lobes mask, Vec3 from, int samples) {
  Outgoing out;
  for (int i = 0; i < samples; ++i) {
    Sampler sampler(SamplerKind::independent, 22, 5, i);
    const float u_lobe = sampler.next1();
    const BsdfSample s = sample(coated, from, u_lobe, sampler.next2(), mask, Transport::flux);
    if (s.valid) out.add(s.wi, s.weight.r / static_cast<double>(samples));
  }
  return out;
}

TEST(SlowBsdfLayers, DiffuseBaseUnderACoatMatchesTheRandomWalk) {
  constexpr int kPaths = 100000, kBounces = 5;
  for (const float albedo : {0.3f, 0.9f}) {
    for (const float alpha : {0.0f, 0.1f, 0.3f, 0.7f}) {
      for (const float depth : {0.0f, 0.01f, 0.1f}) {
        for (const float z : {0.9f, 0.4f}) {
          const Vec3 from{std::sqrt(1 - z * z), 0, z};
          Bsdf base, coated = coated_diffuse(RGB(albedo), alpha, depth);
          base.diffuse = RGB(albedo);
          coated.coat_bounces = kBounces;
          const Outgoing walked = walk(glass(alpha), base, depth, kBounces, from, kPaths);
          const Outgoing modelled = model(coated, kDiffuseReflection, from, kPaths);
          // Four standard errors of both; 1% for the tables; and what is approximated: the absorption of a rough coat.
          const double systematic = 0.01 + 1.5 * depth * alpha;
          EXPECT_NEAR(modelled.total, walked.total,
                      systematic * walked.total + 4 * std::sqrt(2 * walked.total / kPaths))
              << "albedo " << albedo << ", alpha " << alpha << ", depth " << depth << ", z " << z;
          for (int bin = 0; bin < kBins; ++bin)
            EXPECT_NEAR(modelled.share[bin], walked.share[bin],
                        2 * systematic * walked.share[bin] + 4 * std::sqrt(2 * walked.share[bin] / kPaths))
                << "albedo " << albedo << ", alpha " << alpha << ", depth " << depth << ", z " << z << ", bin " << bin;
        }
      }
    }
  }
}

TEST(BsdfLayers, SmoothCoatOverMirrorIsExact) {
  const Bsdf coated = coated_silver(0, 0, 0.05f);
  Bsdf base = silver(0);
  base.eta = base.eta / 1.5f;
  base.k = base.k / 1.5f;
  for (const float z : {1.0f, 0.7f, 0.2f}) {
    const Vec3 from{std::sqrt(1 - z * z), 0, z};
    const Outgoing walked = walk(glass(0), base, 0.05f, 1000, from, 200000);
    // The walk leaves out what the boundary reflects at once.
    const float at_once = sample(glass(0), from, 0, {0, 0}, kAllLobes, Transport::flux).pdf;
    EXPECT_NEAR(albedo(coated, from, kAllLobes).r, walked.total + at_once, 4 * std::sqrt(0.25 / 200000)) << z;
  }
}

// The model of a rough metal under a coat is approximate: within 5% of the arriving flux in each bin, 8% in the whole.
TEST(BsdfLayers, MetalUnderACoatIsNearTheRandomWalk) {
  constexpr int kPaths = 20000;
  for (const float base_alpha : {0.1f, 0.3f, 0.6f}) {
    for (const float coat_alpha : {0.0f, 0.1f, 0.3f}) {
      for (const float z : {0.9f, 0.5f}) {
        const Vec3 from{std::sqrt(1 - z * z), 0, z};
        Bsdf base = silver(base_alpha), coated = coated_silver(base_alpha, coat_alpha);
        base.eta = base.eta / 1.5f;
        base.k = base.k / 1.5f;
        const Outgoing walked = walk(glass(coat_alpha), base, 0, 1000, from, kPaths);
        const Outgoing modelled = model(coated, kAllLobes, from, kPaths);
        // Both lobes may be of one kind, so that the coat's own reflection is taken off by that of glass.
        Bsdf dull = coated;
        dull.use_reflectance = true;
        dull.specular = RGB(0.0f);
        dull.kind = BsdfKind::coated_diffuse;
        dull.alpha_x = dull.alpha_y = coat_alpha;
        const Outgoing reflected = model(dull, kAllLobes, from, kPaths);
        for (int bin = 0; bin < kBins; ++bin) {
          EXPECT_NEAR(modelled.share[bin] - reflected.share[bin], walked.share[bin], 0.05)
              << "base " << base_alpha << ", coat " << coat_alpha << ", z " << z << ", bin " << bin;
        }
        EXPECT_NEAR(modelled.total - reflected.total, walked.total, 0.08)
            << "base " << base_alpha << ", coat " << coat_alpha << ", z " << z;
      }
    }
  }
}

}  // namespace
}  // namespace glowworm
