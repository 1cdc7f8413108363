// Energy conservation, reciprocity and other properties of every kind of BSDF, for any parameters.
#include <gtest/gtest.h>

#include <array>

#include "bsdf/cases.h"
#include "bsdf/microfacet.h"
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

TEST(SlowBsdfEnergy, NeverScattersMoreThanArrives) {
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

/// Share of the flux from wo that is scattered, by evenly spread random numbers (additive recurrence of the powers of
/// the root of x^4 = x + 1; Roberts 2018). Its error is below that of independent numbers.
Mean evenly_sampled_albedo(const Bsdf& bsdf, Vec3 wo, int samples) {
  Mean out;
  for (int i = 0; i < samples; ++i) {
    const auto u = [i](double step) { return static_cast<float>(std::fmod(0.5 + i * step, 1.0) * (1 - 1e-7)); };
    const BsdfSample s =
        sample(bsdf, wo, u(0.8191725134), {u(0.6710436067), u(0.5497004779)}, kAllLobes, Transport::flux);
    out.add(s.valid ? s.weight.r : 0.0);
  }
  return out;
}

/// Materials that absorb nothing, of one roughness.
std::vector<BsdfCase> white_materials(float alpha) {
  std::vector<BsdfCase> cases;
  const RGB white(1.0f);
  Bsdf b = silver(alpha);
  b.use_reflectance = true;
  b.specular = white;
  cases.push_back({"metal", b});
  cases.push_back({"glass", glass(alpha)});
  cases.push_back({"dense glass", glass(alpha, 2.2f)});
  cases.push_back({"bubble", glass(alpha, 1 / 1.33f)});
  cases.push_back({"plastic", coated_diffuse(white, alpha)});
  for (const float coat_alpha : {0.0f, 0.4f}) {
    b = coated_silver(alpha, coat_alpha);
    b.use_reflectance = true;
    b.specular = white;
    cases.push_back({"metal under a coat of alpha " + std::to_string(coat_alpha), b});
  }
  for (const float metallic : {0.0f, 0.4f, 1.0f}) {
    const std::string tail = " of metal " + std::to_string(metallic);
    cases.push_back({"glTF" + tail, metallic_roughness(white, metallic, alpha)});
    for (const float coat_alpha : {0.0f, 0.3f}) {
      b = metallic_roughness(white, metallic, alpha);
      b.coat = 0.8f;
      b.coat_alpha = coat_alpha;
      cases.push_back({"glTF lacquer of alpha " + std::to_string(coat_alpha) + tail, b});
    }
    b = metallic_roughness(white, metallic, alpha);
    b.transmission_weight = 0.7f;
    b.thin = true;
    cases.push_back({"glTF pane" + tail, b});
  }
  b = metallic_roughness(white, 0, alpha);
  b.transmission_weight = 1;
  cases.push_back({"glTF glass", b});
  b.specular_weight = 0.3f;
  cases.push_back({"glTF glass of little reflection", b});
  for (const float metallic : {0.0f, 0.3f}) {
    b = metallic_roughness(white, metallic, alpha);
    b.transmission_weight = 0.4f;
    cases.push_back({"glTF glass with paint on it, of metal " + std::to_string(metallic), b});
  }
  b = metallic_roughness(white, 0, alpha);
  b.diffuse_transmission = 0.6f;
  b.transmission = white;
  cases.push_back({"glTF leaf", b});
  return cases;
}

/// Materials of glTF's further layers that absorb nothing, of one roughness, with and without a clearcoat.
std::vector<BsdfCase> layered_white_materials(float alpha, float coat, float coat_alpha) {
  std::vector<BsdfCase> cases;
  const RGB white(1.0f);
  const auto base = [&](float metallic) {
    Bsdf b = metallic_roughness(white, metallic, alpha);
    b.coat = coat;
    b.coat_alpha = coat_alpha;
    return b;
  };
  const std::string tail = " under a coat of " + std::to_string(coat) + " and alpha " + std::to_string(coat_alpha);
  Bsdf b = base(0);
  b.sheen = white;
  b.sheen_alpha = 0.4f;
  cases.push_back({"glTF cloth" + tail, b});
  b = base(0);
  b.transmission_weight = 1;
  cases.push_back({"glTF glass" + tail, b});
  for (const float metallic : {0.0f, 1.0f}) {
    b = base(metallic);
    b.iridescence = 1;
    b.film_thickness = 250;
    cases.push_back({"glTF film of metal " + std::to_string(metallic) + tail, b});
    // Of a mirror under such a coat, little light is so unlike that it takes many samples.
    if (metallic > 0 && alpha == 0) continue;
    b = base(metallic);
    b.coat_normal = normalize({0.25f, 0.1f, 1});
    cases.push_back({"glTF of metal " + std::to_string(metallic) + tail + " and another normal", b});
  }
  return cases;
}

/// The same, brushed along one axis: where the facets have one roughness along and another across.
std::vector<BsdfCase> brushed(std::vector<BsdfCase> cases, float ratio) {
  for (BsdfCase& c : cases) {
    c.name += ", brushed";
    c.bsdf.alpha_y = ratio * c.bsdf.alpha_x;
  }
  return cases;
}

// A furnace: what meets several facets or layers comes out again.
void expect_conserved(const std::vector<BsdfCase>& cases, int samples) {
  for (const BsdfCase& c : cases)
    for (const Vec3 wo : viewers()) {
      const Mean albedo = evenly_sampled_albedo(c.bsdf, wo, samples);
      EXPECT_NEAR(albedo.mean(), 1, 0.005 + albedo.error())
          << c.name << ", alpha " << c.bsdf.alpha_x << " and " << c.bsdf.alpha_y << ", wo.z " << wo.z;
    }
}

TEST(BsdfEnergy, IsConservedByWhiteMaterialsOfAnyRoughness) {
  for (const float alpha : {0.0f, 0.1f, 0.3f, 1.0f}) expect_conserved(white_materials(alpha), 4096);
}

TEST(BsdfEnergy, IsConservedByWhiteLayers) {
  for (const float alpha : {0.0f, 0.1f, 0.4f}) {
    expect_conserved(layered_white_materials(alpha, 0, 0), 2048);
    expect_conserved(layered_white_materials(alpha, 0.9f, 0), 2048);
    expect_conserved(layered_white_materials(alpha, 0.9f, 0.3f), 2048);
  }
}

TEST(BsdfEnergy, IsConservedByWhiteBrushedMaterials) {
  expect_conserved(brushed(white_materials(0.3f), 0.25f), 2048);
  expect_conserved(brushed(layered_white_materials(0.3f, 0, 0), 0.25f), 2048);
  expect_conserved(brushed(layered_white_materials(0.8f, 0.9f, 0.3f), 0.5f), 2048);
}

// Light that meets a dark surface twice is absorbed: dark metal has the value of one facet, as glTF's and pbrt's have.
TEST(BsdfEnergy, OfDarkMetalIsThatOfOneFacet) {
  constexpr float kReflectance = 0.05f;
  for (const float alpha : {0.3f, 1.0f}) {
    const bsdf_detail::Microfacet facets{alpha, alpha};
    for (std::uint32_t i = 0; i < 200; ++i) {
      Vec3 wo = random_direction(2 * i), wi = random_direction(2 * i + 1);
      wo.z = std::abs(wo.z);
      wi.z = std::abs(wi.z);
      const Vec3 h = normalize(wo + wi);
      const float m = 1 - dot(wo, h), fresnel = kReflectance + (1 - kReflectance) * m * m * m * m * m;
      const float one = fresnel * facets.distribution(h) * facets.masking_shadowing(wo, wi) / (4 * wo.z * wi.z);
      const float all = evaluate(metallic_roughness(RGB(kReflectance), 1, alpha), wo, wi, kAllLobes).r;
      EXPECT_NEAR(all * kPi, one * kPi, 0.02) << alpha << ", z " << wo.z << " and " << wi.z;
    }
  }
}

TEST(SlowBsdfEnergy, AlbedoIsNearTheMeanOfSamples) {
  for (const BsdfCase& c : bsdf_cases()) {
    for (const Vec3 wo : viewers()) {
      for (const Lobes lobe : {kDiffuseReflection, kDiffuseTransmission, kGlossy, kSpecular}) {
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
      for (const Lobes lobe : {kDiffuseReflection, kDiffuseTransmission, kGlossy, kSpecular}) {
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
  EXPECT_EQ(lobes(silver(0.079f)), kSpecular);
  EXPECT_EQ(lobes(silver(0.081f)), kGlossy);
  EXPECT_EQ(lobes(coated_diffuse(RGB(0.5f), 0)), kSpecular | kDiffuseReflection);
  EXPECT_EQ(lobes(coated_diffuse(RGB(0.0f), 0.3f)), kGlossy);
  EXPECT_EQ(lobes(coated_silver(0.3f, 0)), kGlossy | kSpecular);
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
  // Calls in separate statements have the same order with every compiler.
  const auto color = [&unit] {
    RGB out(0.0f);
    for (int c = 0; c < 3; ++c) out[c] = unit();
    return out;
  };
  const auto alpha = [&unit] { return unit() * unit() * unit(); };
  Bsdf b;
  b.kind = static_cast<BsdfKind>(std::min(6, static_cast<int>(sampler.next1() * 7)));
  b.thin = sampler.next1() < 0.5f;
  b.diffuse = color();
  b.transmission = color();
  if (b.kind == BsdfKind::lambertian) b.transmission = b.transmission * (RGB(1.0f) - b.diffuse);
  b.specular = color();
  b.eta = 3 * color() + RGB(0.3f, 0.05f, 0.05f);
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
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 9, i);
    const Bsdf b = random_bsdf(sampler);
    const Vec3 wo = awkward_direction(sampler), wi = awkward_direction(sampler);
    const Lobes mask = static_cast<Lobes>(sampler.next1() * 16);
    const Transport transport = sampler.next1() < 0.5f ? Transport::radiance : Transport::flux;
    const RGB f = evaluate(b, wo, wi, mask), share = albedo(b, wo, mask);
    const float density = pdf(b, wo, wi, mask);
    ASSERT_TRUE(is_finite(f) && f.r >= 0 && f.g >= 0 && f.b >= 0) << i;
    ASSERT_TRUE(std::isfinite(density) && density >= 0) << i;
    ASSERT_TRUE(is_finite(share) && share.r >= 0 && max_component(share) < 1.03f)
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
