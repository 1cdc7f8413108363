// BSDFs of every kind in a sky of radiance 1: pixels show the directional albedo, and lossless objects are invisible.
#include <gtest/gtest.h>

#include <cmath>

#include "builtin/mesh_builder.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"

namespace glowworm {
namespace {

constexpr double kBsdfTolerance = 0.005;

struct MaterialCase {
  std::string name;
  Material material;
};

Material of_kind(MaterialKind kind, float roughness) {
  Material m;
  m.kind = kind;
  m.roughness_u.value = m.roughness_v.value = roughness;
  return m;
}

std::vector<MaterialCase> material_cases() {
  std::vector<MaterialCase> cases;
  Material m;
  m.reflectance.value = {0.8f, 0.5f, 0.1f};
  cases.push_back({"diffuse", m});
  m.transmittance.value = {0.1f, 0.3f, 0.6f};
  cases.push_back({"diffuse_both_sides", m});
  for (const float alpha : {0.0f, 0.05f, 0.3f}) {
    const std::string tail = alpha == 0 ? "_smooth" : alpha < kSpecularAlpha ? "_sharp" : "_rough";
    m = of_kind(MaterialKind::conductor, alpha);
    m.eta = {0.155f, 0.117f, 0.138f};
    m.k = {4.83f, 3.12f, 2.15f};
    cases.push_back({"conductor" + tail, m});
    m = of_kind(MaterialKind::dielectric, alpha);
    m.reflectance.value = m.transmittance.value = RGB(1.0f);
    cases.push_back({"dielectric" + tail, m});
    m = of_kind(MaterialKind::coated_diffuse, alpha);
    m.reflectance.value = {0.8f, 0.5f, 0.1f};
    cases.push_back({"coated_diffuse" + tail, m});
    m = of_kind(MaterialKind::coated_conductor, 0.2f);
    m.coat_roughness.value = alpha;
    m.eta = {0.155f, 0.117f, 0.138f};
    m.k = {4.83f, 3.12f, 2.15f};
    cases.push_back({"coated_conductor" + tail, m});
    m = of_kind(MaterialKind::metallic_roughness, alpha);
    m.reflectance.value = {0.9f, 0.6f, 0.2f};
    cases.push_back({"plastic" + tail, m});
    m.metallic.value = 0.5f;
    m.clearcoat.value = 0.7f;
    m.coat_roughness.value = 0.1f;
    cases.push_back({"lacquered_half_metal" + tail, m});
    m.metallic.value = 0;
    m.transmission.value = 0.8f;
    cases.push_back({"plastic_glass" + tail, m});
  }
  m = of_kind(MaterialKind::thin_dielectric, 0);
  m.reflectance.value = m.transmittance.value = {0.9f, 1, 0.8f};
  cases.push_back({"thin_dielectric", m});
  return cases;
}

/// Where the camera stands: slanted, so that lobes are skewed.
Vec3 viewer() { return normalize({0.6f, 0.3f, 0.75f}); }

SceneDescription sheet_in_the_sky(const Material& material) {
  SceneDescription d;
  d.name = "sheet";
  d.materials.push_back(material);
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  d.environment = Environment{};
  d.cameras.push_back(square_view({0, 0, 0}, viewer(), 1, 1));
  return d;
}

/// The directional albedo of both sides: the integral of f cos by the midpoint rule, and the coefficients of the
/// deltas, each of which is its share over the probability of choosing it.
Mean directional_albedo(const Bsdf& bsdf, Vec3 wo) {
  constexpr int kPolar = 360, kAround = 360, kChoices = 4096;
  Mean sum;
  std::vector<Vec3> directions(kAround);
  std::vector<RGB> values(kAround);
  for (int i = 0; i < 2 * kPolar; ++i) {
    const double theta = (i + 0.5) * kPi / (2 * kPolar), s = std::sin(theta), c = std::cos(theta);
    for (int j = 0; j < kAround; ++j) {
      const double phi = (j + 0.5) * 2 * kPi / kAround;
      directions[j] = {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                       static_cast<float>(c)};
    }
    evaluate_batch(bsdf, wo, directions, kAllLobes, values);
    const double weight = s * std::abs(c) * (kPi / (2 * kPolar)) * (2 * kPi / kAround);
    for (const RGB& f : values)
      for (int k = 0; k < 3; ++k) sum.value[k] += f[k] * weight;
  }
  for (int i = 0; i < kChoices; ++i) {
    const BsdfSample chosen =
        sample(bsdf, wo, (static_cast<float>(i) + 0.5f) / kChoices, {0.5f, 0.5f}, kAllLobes, Transport::radiance);
    if (!chosen.valid || !chosen.delta) continue;
    for (int k = 0; k < 3; ++k) sum.value[k] += chosen.weight[k] / kChoices;
  }
  return sum;
}

class SheetInTheSky : public testing::TestWithParam<MaterialCase> {};

TEST_P(SheetInTheSky, HasItsAlbedoByPathsAndByPhotons) {
  const Stage stage(sheet_in_the_sky(GetParam().material));
  SurfacePoint point = surface_point(*stage.scene, 0, {0.3f, 0.3f});
  const Bsdf bsdf = resolve_bsdf(*stage.scene, point);
  const Mean expected = directional_albedo(bsdf, point.frame.to_local(viewer()));
  for (const RenderSettings& settings : {by_path(16, 256), by_photons(16, 64, 16, 1000)}) {
    const Mean found = mean(stage.render(settings));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found.value[c] / expected.value[c], 1, kBsdfTolerance)
          << "integrator " << static_cast<int>(settings.integrator) << ", channel " << c;
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, SheetInTheSky, testing::ValuesIn(material_cases()),
                         [](const auto& info) { return info.param.name; });

std::vector<MaterialCase> lossless_cases() {
  std::vector<MaterialCase> cases;
  Material m = of_kind(MaterialKind::dielectric, 0);
  m.reflectance.value = m.transmittance.value = RGB(1.0f);
  cases.push_back({"glass", m});
  m.kind = MaterialKind::thin_dielectric;
  cases.push_back({"bubble", m});
  m.kind = MaterialKind::conductor;
  m.use_reflectance = true;
  cases.push_back({"mirror", m});
  m = of_kind(MaterialKind::diffuse, 0);
  m.reflectance.value = RGB(1.0f);
  cases.push_back({"white", m});
  m.reflectance.value = RGB(0.5f);
  m.transmittance.value = RGB(0.5f);
  cases.push_back({"paper", m});
  return cases;
}

/// A ball that loses no light is invisible in an even sky.
class LosslessBall : public testing::TestWithParam<MaterialCase> {
 protected:
  static SceneDescription scene() {
    SceneDescription d;
    d.name = "ball";
    d.materials.push_back(GetParam().material);
    MeshBuilder mesh(d.geometry);
    mesh.sphere({0, 0, 0}, 0.5f, 64, 32);
    // Facets of their own normals: smooth ones bend light that the facets do not let through.
    for (Vec3& n : d.geometry.normals) n = {0, 0, 0};
    d.environment = Environment{};
    d.cameras.push_back(square_view({0, 0, 0}, viewer(), 2, 1.2f));
    return d;
  }
};

TEST_P(LosslessBall, ByPathTracing) {
  const Stage stage(scene());
  RenderSettings settings = by_path(24, 64);
  settings.max_bounces = 1000;
  for (const double v : mean(stage.render(settings)).value) EXPECT_NEAR(v, 1, kBsdfTolerance);
}

TEST_P(LosslessBall, ByPhotonMapping) {
  const Stage stage(scene());
  for (const double v : mean(stage.render(by_photons(24, 16, 25, 500'000, "blocked"))).value)
    EXPECT_NEAR(v, 1, kBsdfTolerance);
}

// One of them under sanitizers, too.
INSTANTIATE_TEST_SUITE_P(Materials, LosslessBall, testing::Values(lossless_cases().front()),
                         [](const auto& info) { return info.param.name; });
INSTANTIATE_TEST_SUITE_P(Slow, LosslessBall, testing::ValuesIn(lossless_cases()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace glowworm
