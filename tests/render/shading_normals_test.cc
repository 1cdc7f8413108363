// Smooth spheres of few triangles, with shading normals far from the geometric ones: no light is lost.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "builtin/mesh_builder.h"
#include "core/random.h"
#include "render/render_testing.h"
#include "scene/surface.h"

namespace glowworm {
namespace {

constexpr double kNormalsTolerance = 0.005;

struct BallCase {
  std::string name;
  Material material;
};

/// Materials that scatter all light.
std::vector<BallCase> lossless_balls() {
  std::vector<BallCase> cases;
  Material m;
  m.reflectance.value = RGB(1.0f);
  cases.push_back({"white", m});
  m.kind = MaterialKind::coated_diffuse;
  m.coat_thickness = 0;
  m.coat_bounces = 0;
  cases.push_back({"coated_white", m});
  m.roughness_u.value = m.roughness_v.value = 0;
  m.kind = MaterialKind::conductor;
  m.use_reflectance = true;
  cases.push_back({"mirror", m});
  m = Material();
  m.reflectance.value = m.transmittance.value = RGB(0.5f);
  cases.push_back({"paper", m});
  m.kind = MaterialKind::dielectric;
  m.reflectance.value = m.transmittance.value = RGB(1.0f);
  cases.push_back({"glass", m});
  return cases;
}

struct Tessellation {
  int segments, rings;
  int triangles() const { return 2 * segments * (rings - 1); }
};

void add_ball(SceneDescription& scene, const Material& material, Tessellation t) {
  scene.materials.push_back(material);
  MeshBuilder mesh(scene.geometry);
  mesh.set_material(static_cast<std::uint32_t>(scene.materials.size() - 1));
  mesh.sphere({0, 0, 0}, 0.5f, t.segments, t.rings);
}

SceneDescription ball_in_the_sky(const Material& material, Tessellation t) {
  SceneDescription scene;
  add_ball(scene, material, t);
  scene.environment = Environment{};
  scene.cameras.push_back(square_view({0, 0, 0}, normalize({0.6f, 0.3f, 0.75f}), 2, 0.7f));
  return scene;
}

/// Walls that emit 1 and reflect half: radiance is 2 everywhere.
SceneDescription ball_in_a_furnace(const Material& material, Tessellation t) {
  SceneDescription scene;
  scene.materials.emplace_back().reflectance.value = RGB(0.5f);
  scene.emissions.emplace_back().radiance.value = RGB(1.0f);
  MeshBuilder mesh(scene.geometry);
  mesh.set_material(0, 0);
  mesh.room({-1, -1, -1}, {1, 1, 1});
  add_ball(scene, material, t);
  scene.cameras.push_back(look_at({0.7f, 0.4f, 0.8f}, {0, 0, 0}, {0, 1, 0}, 90));
  return scene;
}

void expect_mean(const Film& film, const Mean& expected) {
  const Mean found = mean(film);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.value[c] / expected.value[c], 1, kNormalsTolerance) << "channel " << c;
}

RenderSettings long_paths(std::uint32_t samples) {
  RenderSettings settings = by_path(24, samples);
  settings.max_bounces = 1000;
  return settings;
}

class SmoothBall : public testing::TestWithParam<std::tuple<BallCase, Tessellation>> {
 protected:
  SmoothBall() : material_(std::get<0>(GetParam()).material), tessellation_(std::get<1>(GetParam())) {}
  Film in_the_sky(const RenderSettings& settings) const {
    return Stage(ball_in_the_sky(material_, tessellation_)).render(settings);
  }
  Film in_a_furnace(const RenderSettings& settings) const {
    return Stage(ball_in_a_furnace(material_, tessellation_)).render(settings);
  }
  const Material& material_;
  Tessellation tessellation_;
};

class LosslessSmoothBall : public SmoothBall {};

TEST_P(LosslessSmoothBall, VanishesInTheSkyByPathTracing) { expect_mean(in_the_sky(long_paths(384)), {{1, 1, 1}}); }

TEST_P(LosslessSmoothBall, VanishesInTheSkyByPhotonMapping) {
  expect_mean(in_the_sky(by_photons(24, 64, 16, 100'000, "blocked")), {{1, 1, 1}});
}

TEST_P(LosslessSmoothBall, VanishesInAFurnaceByPathTracing) { expect_mean(in_a_furnace(long_paths(256)), {{2, 2, 2}}); }

TEST_P(LosslessSmoothBall, VanishesInAFurnaceByPhotonMapping) {
  expect_mean(in_a_furnace(by_photons(24, 16, 16, 500'000, "blocked")), {{2, 2, 2}});
}

// Of four times three rings, glass holds light by total reflection for thousands of bounces; these do not.
constexpr Tessellation kCoarse{8, 2}, kMiddle{16, 9};

std::string ball_name(const testing::TestParamInfo<std::tuple<BallCase, Tessellation>>& info) {
  return std::get<0>(info.param).name + "_" + std::to_string(std::get<1>(info.param).triangles());
}
// One kind of scattering and one of refraction, which sanitizers see too.
INSTANTIATE_TEST_SUITE_P(Coarse, LosslessSmoothBall,
                         testing::Combine(testing::Values(lossless_balls().front(), lossless_balls().back()),
                                          testing::Values(kCoarse)),
                         ball_name);
INSTANTIATE_TEST_SUITE_P(Slow, LosslessSmoothBall,
                         testing::Combine(testing::ValuesIn(lossless_balls()), testing::Values(kCoarse, kMiddle)),
                         ball_name);

/// Materials that absorb some.
std::vector<BallCase> absorbing_cases() {
  std::vector<BallCase> cases;
  Material m;
  m.kind = MaterialKind::conductor;
  m.eta = {0.155f, 0.117f, 0.138f};
  m.k = {4.83f, 3.12f, 2.15f};
  cases.push_back({"metal", m});
  m.roughness_u.value = m.roughness_v.value = 0.3f;
  cases.push_back({"rough_metal", m});
  m.kind = MaterialKind::coated_diffuse;
  m.reflectance.value = {0.8f, 0.5f, 0.1f};
  cases.push_back({"rough_coat", m});
  m.kind = MaterialKind::metallic_roughness;
  m.metallic.value = 0.5f;
  cases.push_back({"half_metal", m});
  return cases;
}

class AbsorbingSmoothBall : public SmoothBall {
 protected:
  /// The mean of what the camera sees: sky, or the ball's albedo, by samples of the BSDF about the shading normal.
  Mean expected() const {
    const Stage stage(ball_in_the_sky(material_, tessellation_));
    constexpr int kSide = 24, kEach = 128;
    Mean sum;
    for (std::uint32_t i = 0; i < kSide * kSide * kEach; ++i) {
      Sampler sampler(SamplerKind::sobol, 6, i % (kSide * kSide), i / (kSide * kSide));
      const Vec2 u = sampler.next2();
      const Vec2 film{static_cast<float>(i % kSide) + u.x, static_cast<float>(i / kSide % kSide) + u.y};
      const CameraRay ray = generate_ray(stage.scene->camera(""), film, kSide, kSide, {});
      const Hit hit = stage.tracer->intersect({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
      if (hit.triangle == kNone) {
        for (double& v : sum.value) v += 1.0 / (kSide * kSide * kEach);
        continue;
      }
      SurfacePoint point = surface_point(*stage.scene, hit.triangle, hit.barycentric);
      const Bsdf bsdf = resolve_bsdf(*stage.scene, point);
      Vec3 wo = point.frame.to_local(-ray.direction);
      wo.z = std::abs(wo.z);
      const float u_lobe = sampler.next1();
      const BsdfSample s = sample(bsdf, wo, u_lobe, sampler.next2(), kAllLobes, Transport::radiance);
      for (int c = 0; c < 3; ++c) sum.value[c] += s.valid ? s.weight[c] / (kSide * kSide * kEach) : 0;
    }
    return sum;
  }
};

TEST_P(AbsorbingSmoothBall, ReflectsItsAlbedoByPathTracing) { expect_mean(in_the_sky(long_paths(128)), expected()); }

TEST_P(AbsorbingSmoothBall, ReflectsItsAlbedoByPhotonMapping) {
  expect_mean(in_the_sky(by_photons(24, 64, 16, 1000, "blocked")), expected());
}

INSTANTIATE_TEST_SUITE_P(Coarse, AbsorbingSmoothBall,
                         testing::Combine(testing::Values(absorbing_cases().front()), testing::Values(kCoarse)),
                         ball_name);
INSTANTIATE_TEST_SUITE_P(Slow, AbsorbingSmoothBall,
                         testing::Combine(testing::ValuesIn(absorbing_cases()), testing::Values(kCoarse, kMiddle)),
                         ball_name);

}  // namespace
}  // namespace glowworm
