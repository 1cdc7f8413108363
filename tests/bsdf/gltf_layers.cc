// Layers of glTF's materials against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "bsdf/cases.h"
#include "bsdf/sheen.h"
#include "core/random.h"

namespace glowworm {
namespace {

using bsdf_detail::film_reflectance;
using bsdf_detail::Sheen;

/// Share of the light from wo that is scattered, and four standard errors.
std::pair<double, double> scattered(const Bsdf& bsdf, Vec3 wo, int samples = 20000) {
  double sum = 0, squares = 0;
  for (int i = 0; i < samples; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 1, static_cast<std::uint32_t>(i));
    const float u = sampler.next1();
    const BsdfSample s = sample(bsdf, wo, u, sampler.next2(), kAllLobes, Transport::flux);
    const double w = s.valid ? s.weight.g : 0.0;
    sum += w;
    squares += w * w;
  }
  const double mean = sum / samples;
  return {mean, 4 * std::sqrt(std::max(0.0, squares / samples - mean * mean) / samples)};
}

/// A base that scatters what its layers leave and no more: white, without a specular layer.
Bsdf white() {
  Bsdf b = metallic_roughness(RGB(1.0f), 0, 0.5f);
  b.specular_weight = 0;
  return b;
}

TEST(GltfSheen, ScattersItsAlbedo) {
  for (const float alpha : {0.04f, 0.25f, 1.0f}) {
    Bsdf cloth = white();
    cloth.diffuse = RGB(0.0f);
    cloth.sheen = RGB(0.7f);
    cloth.sheen_alpha = alpha;
    for (const Vec3 wo : viewers()) {
      const auto [mean, error] = scattered(cloth, wo);
      EXPECT_NEAR(mean, 0.7 * Sheen(alpha).albedo(std::abs(wo.z)), error + 4e-3) << alpha << ", wo.z " << wo.z;
    }
  }
}

// KHR_materials_sheen: the base gets what the greater of the two albedos leaves, so that white cloth of white sheen is
// no furnace: its albedo lies between that without the second factor and 1.
TEST(GltfSheen, TakesItsLightFromTheBase) {
  Bsdf cloth = white();
  cloth.sheen = RGB(1.0f);
  for (const float alpha : {0.1f, 0.5f}) {
    cloth.sheen_alpha = alpha;
    for (const Vec3 wo : viewers()) {
      const auto [mean, error] = scattered(cloth, wo);
      const double own = Sheen(alpha).albedo(std::abs(wo.z));
      EXPECT_LT(mean, 1 + error + 4e-3);
      EXPECT_GT(mean, own + 0.2 * (1 - own)) << "the base is seen";
    }
  }
}

TEST(GltfFilm, OfIndexOneHasNoEffect) {
  for (const float cosine : {1.0f, 0.6f, 0.2f})
    for (const float base : {0.04f, 0.5f, 0.9f}) {
      const RGB film = film_reflectance(cosine, 1.0001f, 300, RGB(base));
      const float schlick = base + (1 - base) * std::pow(1 - cosine, 5.0f);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(film[c], schlick, 0.012f) << cosine << ", " << base;
    }
}

// Orders of interference that the eye cannot tell leave the sum of reflections without it: R12 + T^2 R23 / (1 - R12
// R23).
TEST(GltfFilm, ThatIsThickHasNoColour) {
  constexpr float kEta = 1.5f, kBase = 0.5f;
  const float r12 = 0.04f, root = std::sqrt(kBase), base_eta = (1 + root) / (1 - root);
  const float r23 = (base_eta - kEta) * (base_eta - kEta) / ((base_eta + kEta) * (base_eta + kEta));
  const float expected = r12 + (1 - r12) * (1 - r12) * r23 / (1 - r12 * r23);
  const RGB film = film_reflectance(1, kEta, 20000, RGB(kBase));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(film[c], expected, 2e-3f);
}

// Green light of 550 nm is extinguished by a film of a quarter of its wavelength in the film between air and a base of
// higher index, and not by one of half of it.
TEST(GltfFilm, OfAQuarterWaveIsDark) {
  const float eta = 1.3f, base = 0.067f;
  const RGB quarter = film_reflectance(1, eta, 550 / (4 * eta), RGB(base));
  const RGB half = film_reflectance(1, eta, 550 / (2 * eta), RGB(base));
  EXPECT_LT(quarter.g, 0.3f * half.g);
}

TEST(GltfDiffuseTransmission, SplitsTheBaseIntoTwoHalves) {
  Bsdf leaf = white();
  leaf.diffuse = {0.8f, 0.4f, 0.2f};
  leaf.transmission = {0.1f, 0.6f, 0.3f};
  leaf.diffuse_transmission = 0.25f;
  const Vec3 wo = normalize({0.3f, 0.5f, 0.8f}), wi = normalize({-0.6f, 0.2f, 0.5f});
  EXPECT_NEAR(evaluate(leaf, wo, wi, kAllLobes).g, 0.75f * 0.4f / kPi, 1e-5f);
  EXPECT_NEAR(evaluate(leaf, wo, -wi, kAllLobes).g, 0.25f * 0.6f / kPi, 1e-5f);
  EXPECT_NEAR(evaluate(leaf, -wo, wi, kAllLobes).g, 0.25f * 0.6f / kPi, 1e-5f) << "from either side";
  EXPECT_EQ(lobes(leaf) & kBroad & ~kGlossy, kDiffuseReflection | kDiffuseTransmission);
}

TEST(GltfCoat, OfAnotherNormalMirrorsAboutIt) {
  Bsdf coat = metallic_roughness(RGB(0.0f), 0, 0.5f);
  coat.specular_weight = 0;
  coat.coat = 1;
  coat.coat_normal = normalize({0.2f, 0, 1});
  const Vec3 wo = normalize({0.3f, 0.2f, 0.9f});
  const BsdfSample s = sample(coat, wo, 0.5f, {0.5f, 0.5f}, kSpecular, Transport::radiance);
  ASSERT_TRUE(s.valid && s.delta);
  EXPECT_NEAR(dot(s.wi, coat.coat_normal), dot(wo, coat.coat_normal), 1e-5f);
  EXPECT_NEAR(length(cross(s.wi + wo, coat.coat_normal)), 0, 1e-5f);
  const float n = dot(wo, coat.coat_normal), fresnel = 0.04f + 0.96f * std::pow(1 - n, 5.0f);
  const auto share = [&](Vec3 w) { return std::min(1.0f, n / w.z); };
  EXPECT_NEAR(s.weight.r, fresnel * share(wo) * share(s.wi) * s.wi.z / n, 1e-5f);
}

TEST(GltfCoat, OfAnyNormalIsASharpLobe) {
  Bsdf coat = metallic_roughness(RGB(0.5f), 0, 0.5f);
  coat.coat = 1;
  for (int i = 0; i < 8; ++i) {
    const float azimuth = 2 * kPi * static_cast<float>(i) / 8;
    coat.coat_normal = normalize({std::cos(azimuth), std::sin(azimuth), 1});
    EXPECT_EQ(lobes(coat), kSpecular | kGlossy | kDiffuseReflection) << azimuth;
  }
}

TEST(GltfDispersion, ThreeWavelengthsShareTheLight) {
  Bsdf glass = metallic_roughness(RGB(1.0f), 0, 0);
  glass.transmission_weight = 1;
  glass.dispersion = 4;
  RGB sum(0.0f);
  constexpr int kSteps = 3000;
  for (int i = 0; i < kSteps; ++i) {
    Bsdf b = glass;
    const RGB factor = choose_wavelength(b, {0.2f, 0.5f, 0.8f}, (static_cast<float>(i) + 0.5f) / kSteps);
    sum += factor;
    // Abbe number 5: the outer indices differ by (1.5 - 1) / 5.
    const int channel = factor.r > 0 ? 0 : factor.g > 0 ? 1 : 2;
    EXPECT_NEAR(b.eta.r, 1.5f + static_cast<float>(channel - 1) * 0.05f, 1e-5f);
    Bsdf again = glass;
    EXPECT_EQ(choose_wavelength(again, factor, 0.3f), RGB(channel == 0, channel == 1, channel == 2))
        << "light of one wavelength keeps it";
    EXPECT_EQ(again.eta.r, b.eta.r);
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / kSteps, 1, 3e-3);
  Bsdf plain = metallic_roughness(RGB(1.0f), 0, 0);
  EXPECT_EQ(choose_wavelength(plain, RGB(1.0f), 0.5f), RGB(1.0f));
}

}  // namespace
}  // namespace glowworm
