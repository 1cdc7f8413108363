// Scattering under shading normals that differ from the geometric normal.
#include "bsdf/shaded_surface.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bsdf/cases.h"
#include "core/random.h"
#include "core/warp.h"

namespace glowworm {
namespace {

/// Mean of random numbers, and how sure it is.
struct Estimate {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double variance() const { return std::max(0.0, squares / count - mean() * mean()) / count; }
};

void expect_equal(const Estimate& a, const Estimate& b, const std::string& what) {
  EXPECT_NEAR(a.mean(), b.mean(), 5 * std::sqrt(a.variance() + b.variance()) + 0.003 * std::abs(b.mean())) << what;
}

/// A surface whose shading normal leans by so many degrees.
struct Leaning {
  Vec3 normal = normalize({0.3f, -0.5f, 0.7f});
  Frame frame;
  explicit Leaning(float degrees) {
    const Frame own = Frame::from_normal(normal);
    const float angle = degrees * kPi / 180;
    frame =
        Frame::from_normal(normalize(own.to_world({0.8f * std::sin(angle), 0.6f * std::sin(angle), std::cos(angle)})));
  }
  ShadedSurface with(const Bsdf& bsdf) const { return {bsdf, frame, normal}; }
};

constexpr float kAngles[] = {0, 10, 40, 75};

/// A direction on either side of the surface, by the cosine to its own normal.
Vec3 by_cosine(const Leaning& surface, Sampler& sampler) {
  const Vec3 w = Frame::from_normal(surface.normal).to_world(square_to_cosine_hemisphere(sampler.next2()));
  return sampler.next1() < 0.5f ? w : -w;
}

/// What light is asked for, and what comes.
float asked(Vec3 w) { return 1 + dot(w, {0.5f, 0.6f, -0.3f}); }
float coming(Vec3 w) { return 1 + dot(w, {-0.4f, 0.1f, 0.8f}); }

TEST(SlowShadedSurface, PassesTheTransmittanceOfPanesStraightOn) {
  int panes = 0;
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    for (const BsdfCase& c : bsdf_cases()) {
      const ShadedSurface surface = leaning.with(c.bsdf);
      for (std::uint32_t d = 0; d < 8; ++d) {
        Sampler sampler(SamplerKind::independent, 3, d, 0);
        const Vec3 wo = by_cosine(leaning, sampler);
        RGB by_paths, by_photons;
        constexpr int kSamples = 500;
        for (int i = 0; i < kSamples; ++i) {
          const float u_lobe = (static_cast<float>(i) + 0.5f) / kSamples;
          const Vec2 u = sampler.next2();
          if (const ScatteredRay s = surface.sample(wo, u_lobe, u, kAllLobes); s.valid && s.is_null) {
            EXPECT_LT(length(s.direction + wo), 1e-5f);
            by_paths += s.weight / kSamples;
          }
          float u_mirror = sampler.next1();
          const ArrivedPhoton arrived = surface.arrive(wo, u_mirror);
          if (!(arrived.factor > 0) || !(arrived.back == wo)) continue;
          const ScatteredRay s = surface.scatter_photon(arrived.back, u_lobe, u, u_mirror);
          if (!s.valid || !s.is_null) continue;
          EXPECT_LT(length(s.direction + wo), 1e-5f);
          by_photons += s.weight * (arrived.factor / kSamples);
        }
        const RGB expected = surface.straight_transmittance(wo);
        panes += !is_black(expected);
        const std::string what = c.name + fmt::format(", {} degrees, direction {}", degrees, d);
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(by_paths[k], expected[k], 0.002f) << what;
          // The share that keeps its direction is left to chance where normals differ.
          EXPECT_NEAR(by_photons[k], expected[k], degrees == 0 ? 0.002f : 0.15f * expected[k] + 1e-6f) << what;
        }
      }
    }
  }
  EXPECT_GT(panes, 30);
}

TEST(ShadedSurface, SamplesLeaveOnTheirSideWithTheDensityOfPdf) {
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    for (const BsdfCase& c : bsdf_cases()) {
      const ShadedSurface surface = leaning.with(c.bsdf);
      for (std::uint32_t i = 0; i < 200; ++i) {
        Sampler sampler(SamplerKind::independent, 2, 3, i);
        const Vec3 wo = by_cosine(leaning, sampler);
        const float u_lobe = sampler.next1();
        const ScatteredRay s = surface.sample(wo, u_lobe, sampler.next2(), kAllLobes);
        if (!s.valid) continue;
        EXPECT_NEAR(length(s.direction), 1, 1e-4f);
        EXPECT_GT(dot(s.direction, s.side), -1e-6f) << c.name;
        EXPECT_NEAR(std::abs(dot(s.side, leaning.normal)), 1, 1e-5f);
        // Reflected light comes from the viewer's side by both normals.
        const Vec3 view = surface.local_view(wo);
        EXPECT_GT(view.z * dot(wo, leaning.normal), 0);
        if (c.bsdf.kind == BsdfKind::conductor) {
          EXPECT_GT(dot(s.side, wo), 0);
        }
        if (s.delta || std::abs(dot(s.direction, s.side)) < 1e-3f) continue;
        EXPECT_NEAR(surface.pdf(wo, s.direction, kAllLobes) / s.pdf, 1, 0.02f) << c.name << " at " << degrees;
      }
    }
  }
}

TEST(SlowShadedSurface, SamplesScatterWhatEvaluateSays) {
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    for (const BsdfCase& c : bsdf_cases()) {
      const ShadedSurface surface = leaning.with(c.bsdf);
      Estimate sampled, evaluated;
      for (std::uint32_t i = 0; i < 3000; ++i) {
        Sampler sampler(SamplerKind::sobol, 4, 1, i);
        const Vec2 u = sampler.next2();
        const Vec3 wo = by_cosine(leaning, sampler);
        const ScatteredRay s = surface.sample(wo, sampler.next1(), u, kAllLobes);
        const bool counts = s.valid && !s.delta;
        sampled.add(counts ? asked(wo) * coming(s.direction) * s.weight.g : 0.0f);
        // Half of the directions from everywhere, so that none is overlooked.
        const bool everywhere = i % 2 == 0;
        const Vec3 wi = everywhere ? square_to_sphere(u) : s.direction;
        const float density = 0.5f * (surface.pdf(wo, wi, kAllLobes) + kInversePi / 4);
        evaluated.add(everywhere || counts ? asked(wo) * coming(wi) * surface.evaluate(wo, wi, kAllLobes).g / density
                                           : 0.0f);
      }
      expect_equal(sampled, evaluated, c.name + " at " + std::to_string(degrees));
    }
  }
}

TEST(ShadedSurface, LosesNothing) {
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    for (const BsdfCase& c : bsdf_cases()) {
      for (std::uint32_t i = 0; i < 20; ++i) {
        Sampler sampler(SamplerKind::independent, 4, 1, i);
        const Vec3 wo = by_cosine(leaning, sampler), view = leaning.with(c.bsdf).local_view(wo);
        const float u_lobe = sampler.next1();
        const Vec2 u = sampler.next2();
        const ScatteredRay s = leaning.with(c.bsdf).sample(wo, u_lobe, u, kAllLobes);
        const BsdfSample of_bsdf = sample(c.bsdf, view, u_lobe, u, kAllLobes, Transport::radiance);
        EXPECT_EQ(s.valid, of_bsdf.valid);
        if (s.valid) {
          EXPECT_EQ(s.weight, of_bsdf.weight);
        }
      }
    }
  }
}

/// Light that arrives and is asked for comes to the same, whichever end it is followed from.
TEST(SlowShadedSurface, PhotonsScatterLikeCameraPaths) {
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    for (const BsdfCase& c : bsdf_cases()) {
      const ShadedSurface surface = leaning.with(c.bsdf);
      Estimate seen, sent;
      for (std::uint32_t i = 0; i < 6000; ++i) {
        Sampler sampler(SamplerKind::sobol, 8, 5, i);
        const Vec3 from = by_cosine(leaning, sampler);
        float u_lobe = sampler.next1(), u_mirror = sampler.next1();
        const Vec2 u = sampler.next2();
        const ScatteredRay s = surface.sample(from, u_lobe, u, kAllLobes);
        seen.add(s.valid ? asked(from) * coming(s.direction) * s.weight.g : 0.0f);
        const ArrivedPhoton photon = surface.arrive(from, u_lobe);
        const ScatteredRay p =
            photon.factor > 0 ? surface.scatter_photon(photon.back, u_lobe, u, u_mirror) : ScatteredRay();
        sent.add(p.valid ? coming(from) * asked(p.direction) * p.weight.g * photon.factor : 0.0f);
      }
      expect_equal(sent, seen, c.name + " at " + std::to_string(degrees));
    }
  }
}

TEST(ShadedSurface, PhotonsArriveAsIrradianceOfTheShadingNormal) {
  for (const float degrees : kAngles) {
    const Leaning leaning(degrees);
    const Bsdf bsdf;
    Estimate factor;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
      Sampler sampler(SamplerKind::sobol, 8, 5, i);
      float u = 0.5f;
      factor.add(leaning.with(bsdf).arrive(by_cosine(leaning, sampler), u).factor);
    }
    EXPECT_NEAR(factor.mean(), 1, 0.01) << degrees;
  }
}

}  // namespace
}  // namespace glowworm
