// Lights of every kind on a floor: a diffuse surface reflects its albedo over pi times its irradiance, which is known
// in closed form for a bare floor.
#include <gtest/gtest.h>

#include <cmath>

#include "core/warp.h"
#include "render/render_testing.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"

namespace glowworm {
namespace {

constexpr double kAlbedo = 0.5, kLightsTolerance = 0.005;
/// Half the side of the square of floor that the camera sees, metres.
constexpr float kHalf = 0.5f;

/// The floor, of the half side given, lit as a case says, by lamps that reflect nothing, so that all its light is
/// direct.
SceneDescription bare_floor(LightCase light, float half_floor) {
  SceneDescription d = lit_floor(light);
  Material black;
  black.reflectance.value = RGB(0.0f);
  d.materials.push_back(black);
  for (std::size_t i = 0; i < 4; ++i) d.geometry.positions[i] *= half_floor / 2;  // lit_floor() makes it 2
  for (std::size_t i = 0; i < d.geometry.triangle_count(); ++i)
    if (d.geometry.emission[i] != kNone) d.geometry.material[i] = 1;
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.4f, 2 * kHalf));
  return d;
}

struct Sum {
  double value[3] = {0, 0, 0};
  void add(RGB radiance, double factor) {
    for (int c = 0; c < 3; ++c) value[c] += radiance[c] * factor;
  }
};

/// Irradiance from a parallelogram of emitter, by the midpoint rule: the sum of L cos cos / d^2.
void add_panels(const Scene& scene, Vec3 x, Sum& sum) {
  constexpr int kCells = 24;
  const Geometry& g = scene.geometry();
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    const Emission& emission = scene.emissions()[g.emission[triangle]];
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        // Both halves of each cell of a triangle cut into kCells^2 equal ones.
        for (const double shift : {1.0 / 3, 2.0 / 3}) {
          const float u = static_cast<float>((i + shift) / kCells), v = static_cast<float>((j + shift) / kCells);
          if (u + v >= 1) continue;
          const SurfacePoint p = surface_point(scene, triangle, {u, v});
          const Vec3 to_light = p.position - x;
          const double d2 = length_squared(to_light), d = std::sqrt(d2);
          double cos_light = -dot(p.geometric_normal, to_light) / d;
          if (emission.two_sided) cos_light = std::abs(cos_light);
          const double cos_floor = to_light.z / d;
          if (cos_light <= 0 || cos_floor <= 0) continue;
          const double area = g.area(triangle) / (kCells * kCells);
          sum.add(evaluate(scene.textures(), emission.radiance, p.texture), area * cos_light * cos_floor / d2);
        }
      }
  }
}

/// Full within the inner cone, none outside the outer one; between them smoothstep of the cosine, or the square
/// (KHR_lights_punctual) or fourth power (pbrt-v3) of a linear ramp in it.
double falloff(const Light& light, double cosine) {
  const double t = std::clamp((cosine - light.cos_outer) / (light.cos_inner - light.cos_outer), 0.0, 1.0);
  if (light.falloff == SpotFalloff::smoothstep) return t * t * (3 - 2 * t);
  return std::pow(t, light.falloff == SpotFalloff::quadratic ? 2 : 4);
}

void add_lights(const Scene& scene, Vec3 x, Sum& sum) {
  for (const Light& light : scene.lights()) {
    if (light.kind == LightKind::directional) {
      sum.add(light.intensity, std::max(0.0f, -light.direction.z));
      continue;
    }
    const Vec3 to_light = light.position - x;
    const double d2 = length_squared(to_light), d = std::sqrt(d2);
    double factor = to_light.z / (d * d2);
    if (light.kind == LightKind::spot) factor *= falloff(light, -dot(light.direction, to_light) / d);
    sum.add(light.intensity, factor);
  }
}

/// Irradiance from the sky: pi times the mean over a cosine-weighted hemisphere.
void add_sky(const Scene& scene, Sum& sum) {
  if (!scene.environment()) return;
  constexpr int kCells = 700;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const Vec2 u{(static_cast<float>(i) + 0.5f) / kCells, (static_cast<float>(j) + 0.5f) / kCells};
      sum.add(environment_radiance(scene, square_to_cosine_hemisphere(u)),
              static_cast<double>(kPi) / (kCells * kCells));
    }
}

/// The mean radiance of the square of floor that the camera sees.
Mean expected_radiance(const Scene& scene) {
  constexpr int kCells = 64;
  Sum sum, sky;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const Vec3 x{kHalf * (2 * (static_cast<float>(i) + 0.5f) / kCells - 1),
                   kHalf * (2 * (static_cast<float>(j) + 0.5f) / kCells - 1), 0};
      add_panels(scene, x, sum);
      add_lights(scene, x, sum);
    }
  add_sky(scene, sky);
  Mean mean;
  for (int c = 0; c < 3; ++c)
    mean.value[c] = (sum.value[c] / (kCells * kCells) + sky.value[c]) * kAlbedo * static_cast<double>(kInversePi);
  return mean;
}

class KnownFloor : public testing::TestWithParam<LightCase> {
 protected:
  void expect_known(const RenderSettings& settings, float half_floor = 2) {
    const Stage stage(bare_floor(GetParam(), half_floor));
    const Mean expected = expected_radiance(*stage.scene), found = mean(stage.render(settings));
    for (int c = 0; c < 3; ++c) {
      ASSERT_GT(expected.value[c], 0);
      EXPECT_NEAR(found.value[c] / expected.value[c], 1, kLightsTolerance) << "channel " << c;
    }
  }
};

class LitFloor : public KnownFloor {};
class SlowLitFloor : public KnownFloor {};

TEST_P(LitFloor, ByPathTracing) { expect_known(by_path(32, 64)); }

TEST_P(LitFloor, ByPhotonMapping) { expect_known(by_photons(32, 16, 16, 1000)); }

/// The photon map itself, far from the edges of the floor: the density of the photons that came straight from the
/// light.
TEST_P(SlowLitFloor, ByTheDensityOfPhotons) {
  RenderSettings settings = by_photons(128, 1, 1, 2'000'000, "blocked");
  settings.integrator = Integrator::photons;
  // A smaller floor, so that half of the photons are where they are looked at.
  expect_known(settings, 0.7f);
}

const auto kLights = testing::Values(LightCase::panel, LightCase::textured, LightCase::point, LightCase::spot,
                                     LightCase::gltf_spot, LightCase::quartic_spot, LightCase::sun, LightCase::sky,
                                     LightCase::lat_long, LightCase::equal_area);
std::string lights_name(const testing::TestParamInfo<LightCase>& info) { return light_case_name(info.param); }
INSTANTIATE_TEST_SUITE_P(Lights, LitFloor, kLights, lights_name);
// "Slow" has to come first in the full name, where programs leave slow tests out by it.
INSTANTIATE_TEST_SUITE_P(Slow, SlowLitFloor, kLights, lights_name);

/// The means of a picture by paths, by final gathering, and of the photon map alone.
std::vector<Mean> means(SceneDescription d) {
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.4f, 2 * kHalf));
  const Stage stage(std::move(d));
  RenderSettings map = by_photons(24, 4, 1, 200'000);
  map.integrator = Integrator::photons;
  return {mean(stage.render(by_path(24, 64))), mean(stage.render(by_photons(24, 16, 16, 1000))),
          mean(stage.render(map))};
}

void expect_same_means(const SceneDescription& a, const SceneDescription& b) {
  const std::vector<Mean> found = means(a), expected = means(b);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i].luminance() / expected[i].luminance(), 1, 0.02) << "integrator " << i;
}

TEST(SlowLampWithAlpha, ShinesWhereItIs) {
  const auto lit_by_a_card = [](float width, float radiance) {
    SceneDescription d = floor_description();
    d.materials.emplace_back().reflectance.value = RGB(0.0f);
    const std::uint32_t emission = add_emission(d, RGB(radiance));
    add_quad(d, {-0.5f, -0.5f, 1}, {0, 1, 0}, {width, 0, 0}, 1, emission);
    return d;
  };
  SceneDescription half_absent = lit_by_a_card(1, 10);
  half_absent.textures.push_back(
      image_node([](Vec2) { return RGB(1.0f); }, [](Vec2 uv) { return uv.y < 0.5f ? 1.0f : 0.0f; }));
  half_absent.materials[1].alpha = {1, 0, Channel::alpha};
  expect_same_means(half_absent, lit_by_a_card(0.5f, 10));
  half_absent.materials[1].alpha_cutoff = 0.5f;
  expect_same_means(half_absent, lit_by_a_card(0.5f, 10));
  SceneDescription sheer = lit_by_a_card(1, 10);
  sheer.materials[1].alpha.value = 0.5f;
  expect_same_means(sheer, lit_by_a_card(1, 5));
}

TEST(SpotWithAHardEdge, LightsItsConeAsAPointLightDoes) {
  SceneDescription spot = floor_description();
  Light light;
  light.position = {0, 0, 1};
  light.intensity = RGB(2.0f);
  SceneDescription point = spot;
  point.lights.push_back(light);
  light.kind = LightKind::spot;
  light.direction = {0, 0, -1};
  light.cos_inner = light.cos_outer = std::cos(0.9f);
  spot.lights.push_back(light);
  expect_same_means(spot, point);
}

/// A floor between a lamp and the open sky, everything lit at once and by both sides of a lamp: the two integrators
/// must agree where no plain answer is at hand.
TEST(SlowLightsTogether, LookTheSameInBothIntegrators) {
  SceneDescription d = lit_floor(LightCase::all);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.4f, 2 * kHalf));
  const Stage stage(std::move(d));
  const Mean path = mean(stage.render(by_path(32, 1024)));
  const Mean photons = mean(stage.render(by_photons(32, 16, 64, 400'000, "knn")));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(photons.value[c] / path.value[c], 1, kLightsTolerance) << "channel " << c;
}

/// Filtered pictures find suns by surface samples, others by light samples: both have the same light in all layers,
/// with light groups, beside a lamp and a mirror, below a pane, and in haze.
TEST(DirectionalLights, BringTheSameLightWithAndWithoutAFilter) {
  for (const bool hazy : {false, true}) {
    SceneDescription d = floor_description();
    for (const MaterialKind kind : {MaterialKind::conductor, MaterialKind::thin_dielectric}) {
      Material& material = d.materials.emplace_back();
      material.kind = kind;
      material.reflectance.value = material.transmittance.value = RGB(kind == MaterialKind::conductor ? 0.8f : 1.0f);
    }
    const auto mirror = static_cast<std::uint32_t>(d.materials.size() - 2), pane = mirror + 1;
    add_quad(d, {0.1f * kHalf, -kHalf, 0.01f}, {0.7f * kHalf, 0, 0.3f * kHalf}, {0, 2 * kHalf, 0}, mirror);
    add_quad(d, {-kHalf, -kHalf, 0.5f}, {kHalf, 0, 0}, {0, kHalf, 0}, pane);
    Light light;
    light.name = "lamp";
    light.position = {0, 0, 1};
    light.intensity = RGB(0.5f);
    d.lights.push_back(light);
    light.kind = LightKind::directional;
    for (const float side : {-0.3f, 0.2f}) {
      light.name = side < 0 ? "morning" : "evening";
      light.direction = normalize(Vec3{side, 0.1f, -1});
      light.intensity = RGB(2 + side);
      d.lights.push_back(light);
    }
    if (hazy) {
      Medium& haze = d.media.emplace_back();
      haze.sigma_a = RGB(0.2f);
      haze.bounds = Box3{{-3, -3, -3}, {3, 3, 3}};
      d.ambient_medium = 0;
    }
    d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 2, 2 * kHalf));
    const Stage stage(std::move(d));
    RenderSettings settings = by_photons(24, 64, 4, 10'000, "blocked");
    settings.light_groups = true;
    const Film plain = stage.render(settings);
    settings.filter = Filtering::automatic;
    const Film fine = stage.render(settings);
    ASSERT_TRUE(fine.has_surface_samples());
    const auto mean_of = [&](const Film& film, Film::Layer layer) {
      double sum = 0;
      for (std::size_t i = 0; i < film.pixel_count(); ++i) sum += luminance(film.mean(layer, i));
      return sum / static_cast<double>(film.pixel_count());
    };
    const double direct = mean_of(plain, Film::Layer::direct);
    EXPECT_GT(direct, 0.1);
    EXPECT_NEAR(mean_of(fine, Film::Layer::direct), direct, 0.01 * direct) << hazy;
    EXPECT_NEAR(mean(fine).luminance(), mean(plain).luminance(), 0.01 * mean(plain).luminance()) << hazy;
    ASSERT_EQ(fine.light_group_count(), 3u);
    for (std::size_t group = 0; group < 3; ++group) {
      double sum = 0, expected = 0;
      for (std::size_t i = 0; i < fine.pixel_count(); ++i) {
        sum += luminance(fine.light_of_group(group, i));
        expected += luminance(plain.light_of_group(group, i));
      }
      EXPECT_NEAR(sum, expected, 0.01 * expected) << group;
    }
  }
}

}  // namespace
}  // namespace glowworm
