// Requirements on every kind of BSDF, on single values.
#include <gtest/gtest.h>

#include "bsdf/bsdf.h"
#include "core/random.h"

namespace glowworm {
namespace {

TEST(BsdfLambertian, HasAlbedoOverPiOnBothSides) {
  Bsdf bsdf;
  bsdf.diffuse = {0.2f, 0.4f, 0.6f};
  const Vec3 up = normalize({0.3f, 0.1f, 0.8f}), side = normalize({-0.5f, 0.4f, 0.2f});
  EXPECT_TRUE(is_lambertian(bsdf));
  EXPECT_EQ(lobes(bsdf), kDiffuseReflection);
  EXPECT_FLOAT_EQ(evaluate(bsdf, up, side, kAllLobes).g, 0.4f * kInversePi);
  EXPECT_FLOAT_EQ(evaluate(bsdf, -up, -side, kAllLobes).b, 0.6f * kInversePi);
  EXPECT_TRUE(is_black(evaluate(bsdf, up, -side, kAllLobes)));
  EXPECT_TRUE(is_black(evaluate(bsdf, up, side, kGlossy)));
  EXPECT_EQ(albedo(bsdf, up, kAllLobes), bsdf.diffuse);
  const BsdfSample s = sample(bsdf, -up, 0.5f, {0.3f, 0.9f}, kAllLobes, Transport::radiance);
  ASSERT_TRUE(s.valid);
  EXPECT_LT(s.wi.z, 0);
  EXPECT_FLOAT_EQ(s.weight.r, 0.2f);
}

TEST(BsdfDielectric, RefractsBySnellsLawAndScalesOnlyRadiance) {
  Bsdf bsdf;
  bsdf.kind = BsdfKind::dielectric;
  bsdf.specular = bsdf.transmission = RGB(1.0f);
  bsdf.eta = RGB(1.5f);
  const Vec3 wo = normalize({0.6f, 0, 0.8f});
  const BsdfSample s = sample(bsdf, wo, 0.999f, {0.5f, 0.5f}, kAllLobes, Transport::radiance);
  ASSERT_TRUE(s.valid && s.delta);
  EXPECT_NEAR(s.wi.x, -0.4f, 1e-6f);
  EXPECT_LT(s.wi.z, 0);
  EXPECT_FLOAT_EQ(s.weight.r, 1 / 2.25f);
  EXPECT_FLOAT_EQ(sample(bsdf, wo, 0.999f, {0.5f, 0.5f}, kAllLobes, Transport::flux).weight.r, 1.0f);
  // From inside, beyond the critical angle, everything is reflected.
  const BsdfSample inner = sample(bsdf, normalize({0.8f, 0, -0.6f}), 0.999f, {0, 0}, kAllLobes, Transport::radiance);
  ASSERT_TRUE(inner.valid);
  EXPECT_LT(inner.wi.z, 0);
  EXPECT_FLOAT_EQ(inner.weight.g, 1.0f);
}

}  // namespace
}  // namespace glowworm
