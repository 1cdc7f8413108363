// Glossy query points: vector code for every kind of surface against brute force, which evaluates single BSDFs, on
// every instruction set.
#include "density/glossy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/frame.h"
#include "core/random.h"
#include "density/density_scenes.h"
#include "kernels/simd.h"

namespace glowworm {
namespace {

using namespace density_tests;

struct Surface {
  const char* name;
  Bsdf bsdf;
};

Bsdf coated(float alpha, float eta, float thickness, std::uint8_t bounces) {
  Bsdf b;
  b.kind = BsdfKind::coated_diffuse;
  b.diffuse = {0.8f, 0.4f, 0.05f};
  b.alpha_x = b.alpha_y = alpha;
  b.coat_eta = eta;
  b.coat_thickness = thickness;
  b.coat_bounces = bounces;
  return b;
}

Bsdf conductor(float alpha) {
  Bsdf b;
  b.kind = BsdfKind::conductor;
  b.eta = {0.155f, 0.117f, 1.4f};
  b.k = {4.83f, 3.12f, 0.2f};
  b.specular = {0.9f, 0.6f, 0.3f};
  b.alpha_x = b.alpha_y = alpha;
  return b;
}

Bsdf metallic(float metal, float alpha) {
  Bsdf b;
  b.kind = BsdfKind::metallic_roughness;
  b.diffuse = {0.9f, 0.2f, 0.1f};
  b.specular = {1, 0.5f, 0.8f};
  b.specular_weight = 0.7f;
  b.metallic = metal;
  b.alpha_x = b.alpha_y = alpha;
  return b;
}

/// Every model, smooth (of which the diffuse part is left), as sharp as broad lobes are, and rough.
std::vector<Surface> surfaces() {
  std::vector<Surface> all;
  for (const float alpha : {0.0f, 0.03f, 0.1f, 0.4f, 1.0f}) {
    all.push_back({"coated", coated(alpha, 1.5f, 0.01f, 0)});
    all.push_back({"coated, dense, absorbing", coated(alpha, 2.2f, 0.6f, 5)});
    all.push_back({"conductor", conductor(alpha)});
    all.push_back({"by reflectance", conductor(alpha)});
    all.back().bsdf.use_reflectance = true;
    all.push_back({"plastic", metallic(0, alpha)});
    all.push_back({"metal", metallic(1, alpha)});
    all.push_back({"half metal", metallic(0.5f, alpha)});
  }
  return all;
}

/// A direction about the frame's normal, seldom the normal itself and often slanted.
Vec3 slanted(const Frame& frame, std::uint32_t i) {
  const float z = i % 11 == 0 ? 1.0f : 0.02f + 0.98f * to_unit_float(hash_combine(i, 1));
  const float phi = 2 * kPi * to_unit_float(hash_combine(i, 2)), r = std::sqrt(1 - z * z);
  return frame.to_world({r * std::cos(phi), r * std::sin(phi), z});
}

/// Photons that come from all sides.
PhotonBatch photons_from_everywhere(std::size_t count) {
  PhotonBatch photons = room_photons(count);
  for (std::uint32_t i = 0; i < photons.size(); ++i)
    photons.direction[i] = slanted(Frame::from_normal(photons.normal[i]), i + 77);
  return photons;
}

/// Points of the surfaces given, in turn; the shading frame of every third faces away from who looks, and that of every
/// seventh is tilted. Of every five, one scatters by its diffuse lobes alone, and one by its glossy ones.
QueryPoints points_of(const std::vector<Bsdf>& bsdfs, std::size_t count) {
  const QueryPoints places = room_queries(count, 5);
  QueryPoints points;
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    Frame frame = Frame::from_normal(places.normal[i]);
    QueryBsdf query;
    query.wo = slanted(frame, i);
    if (i % 7 == 0) frame = Frame::from_normal(normalize(places.normal[i] + 0.3f * query.wo));
    if (i % 3 == 0) frame = Frame::from_normal(-frame.n);
    query.s = frame.s;
    query.t = frame.t;
    query.n = frame.n;
    query.bsdf = bsdfs[i % bsdfs.size()];
    if (i % 5 < 2) query.lobes = i % 5 == 0 ? kDiffuse : kGlossy;
    points.push_back(places.position[i], places.normal[i], query, RGB(1.0f), i);
  }
  return points;
}

RadiusPolicy radius(float r, KernelShape shape) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = r;
  policy.kernel = shape;
  return policy;
}

class GlossyQueries : public testing::TestWithParam<std::string> {};

TEST_P(GlossyQueries, AgreeWithBruteForceForEverySurface) {
  const PhotonBatch photons = photons_from_everywhere(3000);
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(testing::Message() << surface.name << ", alpha " << surface.bsdf.alpha_x);
    ASSERT_TRUE(glossy_model(surface.bsdf));
    const QueryPoints points = points_of({surface.bsdf}, 300);
    const RadiusPolicy policy = radius(0.15f, KernelShape::epanechnikov);
    const std::vector<RGB> expected = run("brute", photons, policy, points);
    for (const std::string& simd : simd_names()) {
      set_simd(simd);
      EXPECT_LT(largest_difference(run(GetParam(), photons, policy, points), expected), 1e-4) << simd;
    }
    set_simd("auto");
  }
}

TEST_P(GlossyQueries, AgreeForMixedSurfacesOfChangingRoughnessAndEveryKernel) {
  const PhotonBatch photons = photons_from_everywhere(3000);
  std::vector<Bsdf> bsdfs;
  for (int i = 0; i < 40; ++i) {
    const float alpha = 0.09f + 0.02f * static_cast<float>(i);
    bsdfs.push_back(i % 4 == 0   ? coated(alpha, 1.3f + 0.02f * static_cast<float>(i), 0.1f, 0)
                    : i % 4 == 1 ? conductor(alpha)
                    : i % 4 == 2 ? metallic(0.3f, alpha)
                                 : Bsdf());
    // One that only the scalar code knows, and a Lambertian surface of two sides.
    if (i % 16 == 5) bsdfs.back().alpha_y *= 0.5f;
    if (i % 4 == 3) bsdfs.back().diffuse = bsdfs.back().transmission = {0.3f, 0.2f, 0.1f};
  }
  const QueryPoints points = points_of(bsdfs, 3000);
  for (const KernelShape shape : kKernelShapes) {
    SCOPED_TRACE(static_cast<int>(shape));
    const RadiusPolicy policy = radius(0.1f, shape);
    const std::vector<RGB> expected = run("brute", photons, policy, points);
    EXPECT_LT(largest_difference(run(GetParam(), photons, policy, points), expected), 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, GlossyQueries, testing::Values("blocked", "reverse"),
                         [](const testing::TestParamInfo<std::string>& name) { return name.param; });

TEST(GlossySurfaces, LeaveOtherSurfacesToTheScalarCode) {
  EXPECT_FALSE(glossy_model(Bsdf()));
  Bsdf brushed = conductor(0.2f);
  brushed.alpha_y = 0.5f;
  EXPECT_FALSE(glossy_model(brushed));
  Bsdf lacquered = metallic(0, 0.3f);
  lacquered.coat = 1;
  EXPECT_FALSE(glossy_model(lacquered));
  Bsdf glass = metallic(0, 0.3f);
  glass.transmission_weight = 1;
  EXPECT_FALSE(glossy_model(glass));
}

}  // namespace
}  // namespace glowworm
