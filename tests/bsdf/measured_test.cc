// Surfaces that scatter by matrices.
#include "bsdf/measured.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bsdf/bsdf.h"
#include "core/random.h"
#include "core/warp.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

PatchBasis klems() {
  return PatchBasis({{5, 1}, {15, 8}, {25, 16}, {35, 20}, {45, 24}, {55, 24}, {65, 24}, {75, 16}, {90, 12}});
}

constexpr Lobes kReflected = kGlossy, kPassed = kDiffuseTransmission;

Bsdf of(const MeasuredBsdf& measured) {
  Bsdf bsdf;
  bsdf.kind = BsdfKind::measured;
  bsdf.measured = &measured;
  return bsdf;
}

std::vector<Vec3> directions() {
  return {{0, 0, 1}, normalize({0.3f, 0.5f, 0.8f}), normalize({-0.9f, 0.2f, 0.15f}), normalize({0.5f, -0.4f, -0.6f})};
}

/// Values that depend on both patches, unlike on the two sides, and need not be reciprocal.
MeasuredBsdf::Values uneven(std::size_t n, bool reciprocal) {
  MeasuredBsdf::Values v;
  for (std::vector<float>* matrix : {&v.front, &v.back, &v.onwards}) {
    matrix->resize(n * n);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b) {
        const auto hash = static_cast<double>(((reciprocal ? a * b + a + b : 3 * a + 7 * b) * 2654435761u) % 1000);
        (*matrix)[a * n + b] = static_cast<float>(0.1 * hash / 1000);
      }
  }
  return v;
}

TEST(PatchBasis, PatchesDivideTheHemisphereAsKlemsHasThem) {
  const PatchBasis basis = klems();
  ASSERT_EQ(basis.size(), 145u);
  double sum = 0;
  for (std::size_t p = 0; p < basis.size(); ++p) {
    sum += basis.projected(p);
    EXPECT_EQ(basis.opposite(basis.opposite(p)), p);
    for (const Vec2 u : {Vec2{0.01f, 0.01f}, Vec2{0.5f, 0.5f}, Vec2{0.99f, 0.99f}}) {
      const Vec3 w = basis.sample(p, u);
      EXPECT_EQ(basis.patch_of(w), p);
      EXPECT_EQ(basis.patch_of({-w.x, -w.y, -w.z}), basis.opposite(p));
    }
  }
  EXPECT_NEAR(sum, M_PI, 1e-5);
  EXPECT_EQ(basis.patch_of(normalize({0.17f, 0, 1})), 1u) << "the first of a ring lies along x";
  EXPECT_EQ(basis.patch_of(normalize({0, 0.17f, 1})), 3u) << "the next towards y";
}

TEST(MeasuredBsdf, AConstantMatrixIsLambertian) {
  const PatchBasis basis = klems();
  const std::size_t n = basis.size() * basis.size();
  const auto level = [&](double albedo) { return std::vector<float>(n, static_cast<float>(albedo / M_PI)); };
  const MeasuredBsdf measured(basis, {level(0.4), level(0.4), level(0.3), {}});
  const Bsdf bsdf = of(measured);
  Bsdf diffuse;
  diffuse.diffuse = RGB(0.4f);
  diffuse.transmission = RGB(0.3f);
  for (const Vec3 wo : directions()) {
    EXPECT_NEAR(albedo(bsdf, wo, kAllLobes).g, 0.7, 1e-5);
    for (const Vec3 wi : directions()) {
      EXPECT_NEAR(evaluate(bsdf, wo, wi, kAllLobes).r, evaluate(diffuse, wo, wi, kAllLobes).r, 1e-6);
      EXPECT_NEAR(pdf(bsdf, wo, wi, kAllLobes), pdf(diffuse, wo, wi, kAllLobes), 1e-5);
    }
  }
  EXPECT_EQ(lobes(bsdf), kReflected | kPassed);
  EXPECT_EQ(measured.corrections().asymmetry, 0);
}

/// A mirror, and a pane, of patches: light stays in the patch of its mirror image, and goes straight on.
TEST(MeasuredBsdf, AMirrorOfPatches) {
  const PatchBasis basis = klems();
  const std::size_t n = basis.size();
  MeasuredBsdf::Values v;
  v.front.resize(n * n);
  v.onwards.resize(n * n);
  for (std::size_t a = 0; a < n; ++a) {
    v.front[a * n + basis.opposite(a)] = 0.9f / basis.projected(a);
    v.onwards[a * n + basis.opposite(a)] = 0.1f / basis.projected(a);
  }
  const MeasuredBsdf measured(basis, v);
  const Bsdf bsdf = of(measured);
  for (const Vec3 wo : directions()) {
    EXPECT_NEAR(albedo(bsdf, wo, kReflected).r, wo.z > 0 ? 0.9 : 0, 1e-5);
    EXPECT_NEAR(albedo(bsdf, wo, kPassed).r, 0.1, 1e-5);
    const BsdfSample s = sample(bsdf, wo, 0.3f, {0.2f, 0.7f}, wo.z > 0 ? kReflected : kPassed, Transport::radiance);
    ASSERT_TRUE(s.valid);
    EXPECT_EQ(basis.patch_of(s.wi), basis.patch_of(-wo));
    EXPECT_GT(s.wi.z, 0);
  }
}

TEST(MeasuredBsdf, IsReciprocalAndTellsWhereItsMatricesAreNot) {
  const PatchBasis basis = klems();
  MeasuredBsdf::Values values = uneven(basis.size(), false);
  values.backwards = values.front;
  const MeasuredBsdf measured(basis, values);
  EXPECT_GT(measured.corrections().asymmetry, 0.1);
  const Bsdf bsdf = of(measured);
  for (const Vec3 wo : directions())
    for (const Vec3 wi : directions())
      EXPECT_EQ(evaluate(bsdf, wo, wi, kAllLobes).r, evaluate(bsdf, wi, wo, kAllLobes).r);
  EXPECT_EQ(MeasuredBsdf(basis, uneven(basis.size(), true)).corrections().scale, 1);
}

TEST(MeasuredBsdf, NeverGivesMoreLightThanItGets) {
  const PatchBasis basis = klems();
  const std::size_t n = basis.size() * basis.size();
  const auto level = [&](double albedo) { return std::vector<float>(n, static_cast<float>(albedo / M_PI)); };
  const MeasuredBsdf measured(basis, {level(0.9), {}, level(0.6), {}});
  EXPECT_NEAR(measured.corrections().scale, 1 / 1.5, 1e-6);
  EXPECT_NEAR(albedo(of(measured), {0, 0, 1}, kAllLobes).r, 1, 1e-5);
}

TEST(MeasuredBsdf, SamplesFollowTheirDensity) {
  const PatchBasis basis = klems();
  const MeasuredBsdf measured(basis, uneven(basis.size(), true));
  const Bsdf bsdf = of(measured);
  for (const Vec3 wo : directions()) {
    // The share of samples in each patch of both sides, and the weight of each.
    std::vector<double> counts(2 * basis.size()), expected(2 * basis.size());
    constexpr int kSamples = 40000;
    const RGB whole = albedo(bsdf, wo, kAllLobes);
    for (int i = 0; i < kSamples; ++i) {
      const auto index = static_cast<std::uint32_t>(i);
      const Vec2 u{to_unit_float(hash32(3 * index)), to_unit_float(hash32(3 * index + 1))};
      const BsdfSample s = sample(bsdf, wo, to_unit_float(hash32(3 * index + 2)), u, kAllLobes, Transport::radiance);
      ASSERT_TRUE(s.valid);
      EXPECT_NEAR(s.weight.r, whole.r, 1e-4);
      EXPECT_NEAR(s.pdf * s.weight.r, evaluate(bsdf, wo, s.wi, kAllLobes).r * std::abs(s.wi.z), 1e-4);
      ++counts[basis.patch_of(s.wi) + (s.wi.z * wo.z > 0 ? 0 : basis.size())];
    }
    for (std::size_t p = 0; p < basis.size(); ++p)
      for (const float z : {1.0f, -1.0f}) {
        Vec3 wi = basis.sample(p, {0.5f, 0.5f});
        wi.z = std::copysign(wi.z, wo.z * z);
        expected[p + (z > 0 ? 0 : basis.size())] =
            kSamples * evaluate(bsdf, wo, wi, kAllLobes).r * basis.projected(p) / whole.r;
      }
    expect_fit(chi_squared_counts(counts, expected).p_value, 4, "patches");
  }
}

}  // namespace
}  // namespace glowworm
