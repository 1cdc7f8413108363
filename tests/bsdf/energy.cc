// Energy conservation, reciprocity and other properties of every kind of BSDF, for any parameters.
#include <gtest/gtest.h>

#include <array>

#include "bsdf/cases.h"
#include "core/random.h"
#include "core/warp.h"

namespace glowworm {
namespace {

struct Mean {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt(std::max(0.0, squares / count - mean() * mean()) / count); }
};

/// Share of the flux from wo that is scattered, by channel.
std::array<Mean, 3> sampled_albedo(const Bsdf& bsdf, Vec3 wo, Lobes mask, int samples) {
  std::array<Mean, 3> out;
  for (int i = 0; i < samples; ++i) {
    Sampler sampler(SamplerKind::independent, 11, 0, i);
    const float u_lobe = sampler.next1();
    const BsdfSample s = sample(bsdf, wo, u_lobe, sampler.next2(), mask, Transport::flux);
    for (int k = 0; k < 3; ++k) out[k].add(s.valid ? s.weight[k] : 0.0);
  }
  return out;
}

/// Squared index of the side that a direction is on.
float index_squared(const Bsdf& bsdf, Vec3 w) {
  const bool refracts = bsdf.kind == BsdfKind::dielectric || (bsdf.kind == BsdfKind::metallic_roughness && !bsdf.thin &&
                                                              bsdf.transmission_weight > 0 && bsdf.metallic < 1);
  return refracts && w.z < 0 ? bsdf.eta.r * bsdf.eta.r : 1.0f;
}

Vec3 random_direction(std::uint32_t index) {
  Sampler sampler(SamplerKind::independent, 3, 1, index);
  return square_to_sphere(sampler.next2());
}

TEST(BsdfEnergy, NeverScattersMoreThanArrives) {
  for (const BsdfCase& c : bsdf_cases()) {
    for (Vec3 wo : viewers()) {
      for (const float side : {1.0f, -1.0f}) {
        wo.z *= side;
        const auto albedo = sampled_albedo(c.bsdf, wo, kAllLobes, 4000);
        for (int k = 0; k < 3; ++k)
          EXPECT_LT(albedo[k].mean(), 1 + 1e-5 + 4 * albedo[k].error()) << c.name << ", wo.z " << wo.z;
      }
    }
  }
}

TEST(BsdfEnergy, IsConservedBySmoothGlassPanesAndWhitePaint) {
  Bsdf white, pane = glass(0);
  white.diffuse = {0.25f, 0.5f, 1};
  white.transmission = {0.75f, 0.5f, 0};
  pane.kind = BsdfKind::thin_dielectric;
  for (const Bsdf& bsdf : {white, glass(0), glass(0, 1 / 1.33f), pane}) {
    for (const Vec3 wo : viewers()) {
      const RGB exact = albedo(bsdf, wo, kAllLobes);
      const auto sampled = sampled_albedo(bsdf, wo, kAllLobes, 2000);
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(exact[k], 1, 1e-6);
        EXPECT_NEAR(sampled[k].mean(), 1, 1e-5 + 4 * sampled[k].error());
      }
    }
  }
}

// A furnace: under a smooth clearcoat of Schlick's term F, whose mean under the cosine is F0 + (1 - F0) / 21, a white
// base gives back (1 - F(wo)) (1 - mean F) beside the coat's own F(wo). The rest went between coat and base more than
// once.
TEST(BsdfEnergy, OfWhitePaintUnderClearcoatLosesOnlyInterreflection) {
  Bsdf paint = metallic_roughness(RGB(1.0f), 0, 0.5f);
  paint.specular_weight = 0;
  for (const float coat : {0.3f, 1.0f}) {
    paint.coat = coat;
    for (Vec3 wo : viewers()) {
      wo.z = std::abs(wo.z);
      const double f0 = 0.04, f = f0 + (1 - f0) * std::pow(1 - double(wo.z), 5), mean_f = f0 + (1 - f0) / 21;
      const double expected = coat * f + (1 - coat * f) * (1 - coat * mean_f);
      const auto sampled = sampled_albedo(paint, wo, kAllLobes, 100000);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(sampled[k].mean(), expected, 4 * sampled[k].error() + 1e-3) << coat << ", wo.z " << wo.z;
    }
  }
}

/// Energy that a rough boundary scatters once, by plain summing over all facets in double precision: facets of slope p
/// have the density 1 / (pi alpha^2 (1 + |p|^2 / alpha^2)^2), so |p| < p_0 has the share 1 - 1 / (1 + p_0^2 / alpha^2).
double scattered_once(double alpha, Vec3 wo, double eta) {
  const auto lambda = [alpha](double z) { return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - z * z) / (z * z)) - 1); };
  const double lambda_o = lambda(wo.z);
  double sum = 0;
  const int n = 400;
  for (int i = 0; i < n; ++i) {
    // The square takes away the singularity at endless slopes.
    const double t = (i + 0.5) / n, slope = alpha * std::sqrt(1 - t * t) / t, weight = 2 * t / (n * n) / wo.z;
    for (int j = 0; j < n; ++j) {
      const double phi = 2 * M_PI * (j + 0.5) / n, x = -slope * std::cos(phi), y = -slope * std::sin(phi);
      // A facet's area over its projection is l, so its projection to wo is its share times `seen`.
      const double seen = wo.x * x + wo.y * y + wo.z, l = std::sqrt(1 + x * x + y * y), cosine = seen / l;
      if (seen <= 0) continue;
      const double sin2_t = (1 - cosine * cosine) / (eta * eta);
      double f = 1;
      if (sin2_t < 1) {
        const double cosine_t = std::sqrt(1 - sin2_t), a = (cosine - eta * cosine_t) / (cosine + eta * cosine_t),
                     b = (eta * cosine - cosine_t) / (eta * cosine + cosine_t);
        f = 0.5 * (a * a + b * b);
        const double down = (cosine / eta - cosine_t) / l - wo.z / eta;
        if (down < 0) sum += (1 - f) * seen * weight / (1 + lambda_o + lambda(-down));
      }
      const double up = 2 * cosine / l - wo.z;
      if (up > 0) sum += f * seen * weight / (1 + lambda_o + lambda(up));
    }
  }
  return sum;
}

TEST(BsdfEnergy, OfRoughGlassFallsByTheLossOfSingleScattering) {
  for (const float alpha : {0.1f, 0.4f, 0.9f}) {
    for (const float z : {0.95f, 0.5f, -0.8f}) {
      const Vec3 wo{std::sqrt(1 - z * z), 0, z};
      const double expected = scattered_once(alpha, {wo.x, 0, std::abs(z)}, z > 0 ? 1.5 : 1 / 1.5);
      const auto sampled = sampled_albedo(glass(alpha), wo, kAllLobes, 100000);
      EXPECT_NEAR(sampled[0].mean(), expected, 4 * sampled[0].error() + 1e-3) << alpha << ", wo.z " << z;
    }
  }
}

TEST(BsdfEnergy, AlbedoIsNearTheMeanOfSamples) {
  for (const BsdfCase& c : bsdf_cases()) {
    for (const Vec3 wo : viewers()) {
      for (const Lobes lobe : {kDiffuseReflection, kDiffuseTransmission, kGlossy, kSharp}) {
        if (!(lobes(c.bsdf) & lobe)) continue;
        const RGB claimed = albedo(c.bsdf, wo, lobe);
        const auto sampled = sampled_albedo(c.bsdf, wo, lobe, 4000);
        // Two layers of which the lower is rough, and anisotropy, are only estimated.
        const bool estimated = c.bsdf.kind == BsdfKind::coated_conductor || c.bsdf.alpha_x != c.bsdf.alpha_y;
        const double bound = estimated ? 0.2 : 0.08;
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(claimed[k], sampled[k].mean(), bound + 4 * sampled[k].error())
              << c.name << ", wo.z " << wo.z << ", lobe " << int{lobe};
          EXPECT_TRUE(sampled[k].mean() == 0 || max_component(claimed) > 0) << c.name;
        }
      }
    }
  }
}

TEST(BsdfSymmetry, IsReciprocal) {
  for (const BsdfCase& c : bsdf_cases()) {
    int seen = 0;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const Vec3 wo = random_direction(2 * i), wi = random_direction(2 * i + 1);
      const RGB there = evaluate(c.bsdf, wo, wi, kAllLobes) / index_squared(c.bsdf, wo);
      const RGB back = evaluate(c.bsdf, wi, wo, kAllLobes) / index_squared(c.bsdf, wi);
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(there[k], back[k], 2e-3f * std::max(there[k], back[k]) + 1e-6f)
            << c.name << ", z " << wo.z << " and " << wi.z;
        seen += there[k] > 0;
      }
    }
    const bool delta_only = c.name == "pane" || c.name.find("alpha 0.000000") != std::string::npos;
    EXPECT_TRUE(seen > 0 || delta_only) << c.name;
  }
}

TEST(BsdfLobes, AddUpToTheWhole) {
  for (const BsdfCase& c : bsdf_cases()) {
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Vec3 wo = random_direction(2 * i), wi = random_direction(2 * i + 1);
      const RGB whole = evaluate(c.bsdf, wo, wi, kAllLobes), share = albedo(c.bsdf, wo, kAllLobes);
      RGB sum(0.0f), shares(0.0f);
      for (const Lobes lobe : {kDiffuseReflection, kDiffuseTransmission, kGlossy, kSharp}) {
        const RGB f = evaluate(c.bsdf, wo, wi, lobe);
        EXPECT_TRUE((lobes(c.bsdf) & lobe) || is_black(f)) << c.name;
        sum += f;
        shares += albedo(c.bsdf, wo, lobe);
      }
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(sum[k], whole[k], 1e-5f * whole[k]) << c.name;
        EXPECT_NEAR(shares[k], share[k], 1e-5f * share[k]) << c.name;
      }
    }
  }
}

TEST(BsdfLobes, AreSharpBelowTheirThreshold) {
  EXPECT_EQ(lobes(silver(0.079f)), kSharp);
  EXPECT_EQ(lobes(silver(0.081f)), kGlossy);
  EXPECT_EQ(lobes(coated_diffuse(RGB(0.5f), 0)), kSharp | kDiffuseReflection);
  EXPECT_EQ(lobes(coated_diffuse(RGB(0.0f), 0.3f)), kGlossy);
  EXPECT_EQ(lobes(coated_silver(0.3f, 0)), kGlossy | kSharp);
  EXPECT_EQ(lobes(metallic_roughness(RGB(0.5f), 0, 0.5f)), kGlossy | kDiffuseReflection);
}

TEST(BsdfBatch, GivesTheSameBitsAsSingleCalls) {
  std::vector<Vec3> wi(37);
  for (std::uint32_t i = 0; i < wi.size(); ++i) wi[i] = random_direction(i);
  wi[5] = {1, 0, 0};
  std::vector<RGB> out(wi.size());
  for (const BsdfCase& c : bsdf_cases()) {
    for (const Vec3 wo : viewers()) {
      evaluate_batch(c.bsdf, wo, wi, kBroad, out);
      for (std::size_t i = 0; i < wi.size(); ++i) EXPECT_EQ(out[i], evaluate(c.bsdf, wo, wi[i], kBroad)) << c.name;
    }
  }
}

/// Any legal numbers, the ends of their ranges often.
Bsdf random_bsdf(Sampler& sampler) {
  const auto unit = [&sampler] {
    const float x = sampler.next1();
    return x < 0.1f ? 0.0f : x > 0.9f ? 1.0f : (x - 0.1f) / 0.8f;
  };
  const auto color = [&unit] { return RGB(unit(), unit(), unit()); };
  const auto alpha = [&unit] { return unit() * unit() * unit(); };
  Bsdf b;
  b.kind = static_cast<BsdfKind>(std::min(6, static_cast<int>(sampler.next1() * 7)));
  b.thin = sampler.next1() < 0.5f;
  b.diffuse = color();
  b.transmission = color();
  if (b.kind == BsdfKind::lambertian) b.transmission = b.transmission * (RGB(1.0f) - b.diffuse);
  b.specular = color();
  b.eta = RGB(0.3f + 3 * unit(), 0.05f + 3 * unit(), 0.05f + 3 * unit());
  b.k = color() * 8;
  b.use_reflectance = sampler.next1() < 0.5f;
  b.alpha_x = alpha();
  b.alpha_y = sampler.next1() < 0.5f ? b.alpha_x : alpha();
  b.coat_alpha = alpha();
  b.coat = unit();
  b.coat_eta = 1 + 2 * unit();
  b.coat_thickness = 2 * alpha();
  b.coat_bounces = static_cast<std::uint8_t>(6 * unit());
  b.metallic = unit();
  b.transmission_weight = unit();
  b.specular_weight = unit();
  return b;
}

/// Directions at and near the pole and the horizon, and any other.
Vec3 awkward_direction(Sampler& sampler) {
  const float choice = sampler.next1();
  const Vec3 w = square_to_sphere(sampler.next2());
  if (choice < 0.1f) return {0, 0, w.z < 0 ? -1.0f : 1.0f};
  if (choice < 0.2f) return normalize({w.x, w.y, 1e-6f * w.z});
  if (choice < 0.25f) return normalize({w.x, w.y, 0});
  if (choice < 0.35f) return normalize({1e-4f * w.x, 1e-4f * w.y, w.z < 0 ? -1.0f : 1.0f});
  return w;
}

TEST(BsdfFuzz, AlwaysReturnsFiniteNumbers) {
  for (std::uint32_t i = 0; i < 100000; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 9, i);
    const Bsdf b = random_bsdf(sampler);
    const Vec3 wo = awkward_direction(sampler), wi = awkward_direction(sampler);
    const Lobes mask = static_cast<Lobes>(sampler.next1() * 16);
    const Transport transport = sampler.next1() < 0.5f ? Transport::radiance : Transport::flux;
    const RGB f = evaluate(b, wo, wi, mask), share = albedo(b, wo, mask);
    const float density = pdf(b, wo, wi, mask);
    ASSERT_TRUE(is_finite(f) && f.r >= 0 && f.g >= 0 && f.b >= 0) << i;
    ASSERT_TRUE(std::isfinite(density) && density >= 0) << i;
    ASSERT_TRUE(is_finite(share) && share.r >= 0 && max_component(share) < 1.1f)
        << i << ": " << max_component(share) << ", kind " << static_cast<int>(b.kind) << " eta " << b.eta.r << " alpha "
        << b.alpha_x << " " << b.alpha_y << " coat " << b.coat_alpha << " eta " << b.coat_eta << " z " << wo.z;
    const float u_lobe = sampler.next1();
    const BsdfSample s = sample(b, wo, u_lobe, sampler.next2(), mask, transport);
    if (!s.valid) continue;
    ASSERT_TRUE(is_finite(s.wi) && is_finite(s.weight) && s.weight.r >= 0 && s.weight.g >= 0 && s.weight.b >= 0) << i;
    ASSERT_NEAR(length(s.wi), 1, 1e-4f) << i;
    ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0 && (s.lobe & mask)) << i;
  }
}

}  // namespace
}  // namespace glowworm
