// The camera pass.
#include "gather/camera_pass.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "builtin/builtin.h"
#include "core/parallel.h"
#include "gather/direct_light.h"
#include "gather/final_gather.h"
#include "gather/light_edges.h"
#include "scene/scene_parts.h"
#include "support/scene_test_name.h"
#include "transport/vertex.h"

namespace glowworm {
namespace {

struct Seen {
  SlotRadiance radiance;
  FirstHit first_hit;
};

bool same(const std::vector<RGB>& a, const std::vector<RGB>& b) { return a == b; }

/// Whether what is seen first is the same, but for what rounding makes of albedos.
void expect_same(const Seen& a, const Seen& b) {
  EXPECT_TRUE(same(a.radiance.emitted, b.radiance.emitted));
  EXPECT_TRUE(same(a.radiance.direct, b.radiance.direct));
  EXPECT_EQ(a.first_hit.depth, b.first_hit.depth);
  EXPECT_EQ(a.first_hit.normal, b.first_hit.normal);
  EXPECT_TRUE(same(a.first_hit.albedo, b.first_hit.albedo));
}

class CameraPass : public testing::TestWithParam<std::string> {
 protected:
  CameraPass() : scene_(builtin_scene(GetParam())), tracer_(scene_) {}

  GatherPoints points(Seen& seen) const {
    return camera_pass(tracer_, scene_.camera(""), task_, settings_, seen.radiance, seen.first_hit, statistics_);
  }

  const Scene scene_;
  const Tracer tracer_;
  // Neither side a multiple of what is traced together.
  const CameraTask task_{3, 2, 61, 47, 5, 2};
  const CameraPassSettings settings_{64, 48, 7};
  mutable Statistics statistics_;
};

/// Surface samples estimate the same emission and albedo as camera samples, and change nothing else.
TEST_P(CameraPass, SurfaceSamplesFindTheSameEmissionAndAlbedo) {
  constexpr std::uint32_t kSamples = 64;
  const CameraTask whole{0, 0, 64, 48, 0, kSamples};
  CameraPassSettings settings = settings_;
  Seen coarse, fine;
  camera_pass(tracer_, scene_.camera(""), whole, settings, coarse.radiance, coarse.first_hit, statistics_);
  settings.surface_samples = true;
  camera_pass(tracer_, scene_.camera(""), whole, settings, fine.radiance, fine.first_hit, statistics_);
  expect_same(coarse, fine);
  EXPECT_TRUE(coarse.radiance.surface_emitted.empty());
  struct Moments {
    double mean = 0, variance = 0;  ///< of the mean
  };
  const auto moments = [](const std::vector<RGB>& slots) {
    const auto n = static_cast<double>(slots.size());
    double sum = 0, squares = 0;
    for (const RGB& slot : slots) {
      const double l = luminance(slot);
      sum += l;
      squares += l * l;
    }
    return Moments{sum / n, (squares / n - sum / n * (sum / n)) / n};
  };
  // Four standard errors. Pixels are stratified, so the error is less.
  const auto expect_near = [&](const std::vector<RGB>& a, const std::vector<RGB>& b) {
    const Moments of_a = moments(a), of_b = moments(b);
    EXPECT_NEAR(of_a.mean, of_b.mean, 4 * std::sqrt(of_a.variance + of_b.variance));
  };
  expect_near(fine.first_hit.surface_albedo, fine.first_hit.albedo);
  expect_near(fine.radiance.surface_emitted, fine.radiance.emitted);
}

TEST_P(CameraPass, IsTheSameForAnyNumberOfThreads) {
  Seen by_one, by_all;
  set_thread_count(1);
  const GatherPoints one = points(by_one);
  set_thread_count(0);
  const GatherPoints all = points(by_all);
  EXPECT_EQ(one.slot, all.slot);
  EXPECT_EQ(one.position, all.position);
  EXPECT_EQ(one.throughput, all.throughput);
  expect_same(by_one, by_all);
}

TEST_P(CameraPass, SeesEachPixelByRaysThroughIt) {
  Seen seen;
  const GatherPoints found = points(seen);
  const Camera camera = scene_.camera("");
  std::size_t straight = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::uint32_t x = found.sequence[i] % 64, y = found.sequence[i] / 64;
    ASSERT_EQ(found.slot[i], (found.sample[i] - 5) * task_.pixel_count() + (y - 2) * 58 + (x - 3));
    const Vec3 away = found.position[i] - camera.to_world.translation;
    // Points beyond specular bounces lie elsewhere.
    const float depth = seen.first_hit.depth[found.slot[i]];
    if (!(found.throughput[i] == RGB(1.0f)) || std::abs(length(away) - depth) > 1e-4f * depth) continue;
    const CameraRay ray =
        generate_ray(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, 64, 48, {});
    const float pixel = camera.half_extent * 2 / 48;
    EXPECT_LT(length(normalize(away) - ray.direction), pixel);
    ++straight;
  }
  EXPECT_GT(straight, found.size() / 4);
}

/// A lamp that a smooth surface reflects is seen by every surface sample, however small the reflected share.
TEST(SurfaceSamples, SeeReflectionsWithoutNoise) {
  for (const MaterialKind kind :
       {MaterialKind::dielectric, MaterialKind::thin_dielectric, MaterialKind::coated_diffuse}) {
    SceneDescription d;
    Material material;
    material.kind = kind;
    material.reflectance.value = material.transmittance.value = RGB(kind == MaterialKind::coated_diffuse ? 0.5f : 1.0f);
    d.materials.push_back(material);
    add_quad(d, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0});
    add_quad(d, {-9, -9, 4}, {0, 18, 0}, {18, 0, 0}, 0, add_emission(d, RGB(100.0f)));
    d.cameras.push_back(look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 5));
    const Scene scene(std::move(d));
    const Tracer tracer(scene);
    CameraPassSettings settings;
    settings.width = settings.height = 16;
    settings.surface_samples = true;
    Seen seen;
    Statistics statistics;
    camera_pass(tracer, scene.camera(""), CameraTask{0, 0, 16, 16, 0, 2}, settings, seen.radiance, seen.first_hit,
                statistics);
    for (const RGB& emitted : seen.radiance.surface_emitted) {
      EXPECT_GT(emitted.g, 3);
      EXPECT_NEAR(emitted.g, seen.radiance.surface_emitted[0].g, 0.02f * emitted.g);
    }
  }
}

Light directional(Vec3 direction, RGB irradiance) {
  Light light;
  light.kind = LightKind::directional;
  light.direction = normalize(direction);
  light.intensity = irradiance;
  return light;
}

/// A wall that a sun lights beside the shadow of a board, seen from the front: the edge of the shadow is upright at
/// x = 0.13 m, and pixels have a side of 0.1 m.
SceneDescription wall_with_shadow() {
  SceneDescription d;
  d.materials.emplace_back().reflectance.value = RGB(0.5f);
  add_quad(d, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0});
  add_quad(d, {-9, -9, 6}, {9.13f, 0, 0}, {0, 18, 0});
  d.lights = {directional({0, 0, -1}, RGB(2))};
  d.cameras.push_back(look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.8f / 4) * 180 / kPi));
  return d;
}

/// Pixels at an edge of light have four times as many surface samples as others, without bias.
TEST(SurfaceSamples, AreMoreAtEdgesOfLight) {
  constexpr int kSide = 16, kSamples = 256, kColumn = 9;
  constexpr double kLit = 0.7;  // of that column: the edge lies at 9.3 pixels
  const Scene scene(wall_with_shadow());
  const Tracer tracer(scene);
  CameraPassSettings settings;
  settings.width = settings.height = kSide;
  settings.surface_samples = settings.suns = true;
  Seen seen;
  Statistics statistics;
  camera_pass(tracer, scene.camera(""), CameraTask{0, 0, kSide, kSide, 0, kSamples}, settings, seen.radiance,
              seen.first_hit, statistics);
  const auto lit = [&](std::size_t sample, int x, int y) {
    return double{
               seen.radiance.sun[(sample * kSide + static_cast<std::size_t>(y)) * kSide + static_cast<std::size_t>(x)]
                   .g} *
           kPi / (0.5 * 2);
  };
  double sum = 0, squares = 0;
  constexpr double kCount = kSide * kSamples;
  for (std::size_t sample = 0; sample < kSamples; ++sample)
    for (int y = 0; y < kSide; ++y) {
      EXPECT_NEAR(lit(sample, kColumn - 1, y), 0, 1e-6);
      EXPECT_NEAR(lit(sample, kColumn + 1, y), 1, 1e-3);
      sum += lit(sample, kColumn, y);
      squares += std::pow(lit(sample, kColumn, y) - kLit, 2);
    }
  EXPECT_NEAR(sum / kCount, kLit, 4 * std::sqrt(squares) / kCount);
  // Four samples have strata of a quarter of the pixel, and the edge cuts the last but one of these at 0.8.
  constexpr double kOfFour = 0.8 * 0.2 / (4 * 4);
  EXPECT_LT(squares / kCount, kOfFour / 4);
}

/// Which pixels these are does not depend on the task.
TEST(SurfaceSamples, AreThoseOfTheWholePicture) {
  const Scene scene(wall_with_shadow());
  const Tracer tracer(scene);
  CameraPassSettings settings;
  settings.width = settings.height = 16;
  settings.surface_samples = settings.suns = true;
  const auto seen_by = [&](CameraTask task) {
    Seen seen;
    Statistics statistics;
    camera_pass(tracer, scene.camera(""), task, settings, seen.radiance, seen.first_hit, statistics);
    return seen;
  };
  const Seen whole = seen_by({0, 0, 16, 16, 0, 3}), part = seen_by({9, 2, 11, 7, 1, 2});
  for (std::size_t sample = 0; sample < 2; ++sample)
    for (std::size_t y = 0; y < 5; ++y)
      for (std::size_t x = 0; x < 2; ++x) {
        const std::size_t of_part = (sample * 5 + y) * 2 + x, of_whole = ((sample + 1) * 16 + y + 2) * 16 + x + 9;
        EXPECT_EQ(part.radiance.sun[of_part], whole.radiance.sun[of_whole]);
        EXPECT_EQ(part.first_hit.surface_albedo[of_part], whole.first_hit.surface_albedo[of_whole]);
      }
}

/// Passes that know the edges of earlier ones have the same samples, by fewer rays.
TEST(SurfaceSamples, RememberEdgesOfLight) {
  const Scene scene(wall_with_shadow());
  const Tracer tracer(scene);
  KnownLightEdges known(20, 20);
  CameraPassSettings settings;
  settings.width = settings.height = 20;
  settings.surface_samples = settings.suns = true;
  const auto see = [&](KnownLightEdges* edges, Seen& seen) {
    settings.edges = edges;
    Statistics statistics;
    camera_pass(tracer, scene.camera(""), CameraTask{0, 0, 20, 20, 0, 1}, settings, seen.radiance, seen.first_hit,
                statistics);
    return statistics.count(Counter::camera_rays);
  };
  Seen alone, first, second;
  const std::uint64_t rays = see(nullptr, alone);
  EXPECT_EQ(see(&known, first), rays);
  EXPECT_EQ(see(&known, second), rays - (17 + 5) * (17 + 5));
  for (const Seen* seen : {&first, &second}) EXPECT_EQ(seen->radiance.sun, alone.radiance.sun);
}

/// Surface samples bring the light of two suns that light samples bring, on diffuse, rough and coated surfaces, beside
/// a board and its shadow, with less noise. Each surface has as many pixels as the others.
TEST(SlowSurfaceSamples, FindTheLightOfDirectionalLights) {
  constexpr int kSide = 24, kSamples = 256;
  constexpr std::uint32_t kLightSamples = 2;
  SceneDescription d;
  for (const MaterialKind kind : {MaterialKind::diffuse, MaterialKind::conductor, MaterialKind::coated_diffuse}) {
    Material material;
    material.kind = kind;
    material.reflectance.value = RGB(0.5f);
    material.roughness_u.value = material.roughness_v.value = 0.2f;
    d.materials.push_back(material);
  }
  for (std::uint32_t i = 0; i < 3; ++i) add_quad(d, {-3 + 2 * static_cast<float>(i), -9, 0}, {2, 0, 0}, {0, 18, 0}, i);
  add_quad(d, {-9, 1, 0.5f}, {18, 0, 0}, {0, 1, 0}, 0);
  d.lights = {directional({0.1f, 0.2f, -1}, {3, 2, 1}), directional({-0.2f, -0.3f, -1}, {0.1f, 0.2f, 0.3f})};
  d.cameras.push_back(look_at({0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 53));
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  Statistics statistics;
  const auto direct_of = [&](bool suns) {
    CameraPassSettings settings;
    settings.width = settings.height = kSide;
    settings.surface_samples = true;
    settings.suns = suns;
    Seen seen;
    const GatherPoints points = camera_pass(tracer, scene.camera(""), CameraTask{0, 0, kSide, kSide, 0, kSamples},
                                            settings, seen.radiance, seen.first_hit, statistics);
    DirectLightSettings direct;
    direct.light_samples = kLightSamples;
    direct.gather_rays = 1;
    direct.directional = !suns;
    add_direct_light(tracer, points, direct, seen.radiance, statistics);
    return seen.radiance.direct;
  };
  struct Spread {
    double sum = 0, squares = 0;
    double mean() const { return sum / (kSide * kSide / 3 * kSamples); }
  };
  std::array<std::array<Spread, 3>, 2> found{};
  for (const bool suns : {false, true}) {
    const std::vector<RGB> direct = direct_of(suns);
    for (std::size_t i = 0; i < direct.size(); ++i) {
      Spread& spread = found[suns][i % kSide / (kSide / 3)];
      spread.sum += luminance(direct[i]);
      spread.squares += double{luminance(direct[i])} * luminance(direct[i]);
    }
  }
  for (int surface = 0; surface < 3; ++surface) {
    const Spread &samples = found[0][surface], &suns = found[1][surface];
    EXPECT_GT(samples.mean(), 0.05);
    EXPECT_NEAR(suns.mean(), samples.mean(), 0.01 * samples.mean()) << "surface " << surface;
    EXPECT_LT(suns.squares, samples.squares) << "surface " << surface;
  }
}

/// Surface samples find the light of lamps that rough metal reflects, beside a shadow, with the mean of light samples
/// of camera samples and at most a third of their variance.
TEST(SurfaceSamples, FindTheLampsThatRoughMetalReflects) {
  constexpr int kSide = 16, kSamples = 64;
  SceneDescription d;
  Material material;
  material.kind = MaterialKind::conductor;
  material.reflectance.value = RGB(0.8f);
  material.roughness_u.value = material.roughness_v.value = 0.05f;
  d.materials.push_back(material);
  add_quad(d, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0});
  add_quad(d, {-1, 3, 4}, {0, 2, 0}, {2, 0, 0}, 0, add_emission(d, RGB(10.0f)));
  d.cameras.push_back(look_at({0, -3, 3}, {0, 0, 0}, {0, 0, 1}, 40));
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  double sum[2] = {}, squares[2] = {};
  for (const bool by_surface : {false, true}) {
    CameraPassSettings settings;
    settings.width = settings.height = kSide;
    settings.surface_samples = by_surface;
    Seen seen;
    Statistics statistics;
    camera_pass(tracer, scene.camera(""), CameraTask{0, 0, kSide, kSide, 0, kSamples}, settings, seen.radiance,
                seen.first_hit, statistics);
    // The variance of samples of the same pixel.
    constexpr std::size_t kPixels = std::size_t{kSide} * kSide;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      double of_pixel = 0;
      for (std::size_t i = 0; i < kSamples; ++i) {
        const double light = seen.radiance.direct[pixel + i * kPixels].g;
        of_pixel += light;
        squares[by_surface] += light * light;
      }
      squares[by_surface] -= of_pixel * of_pixel / kSamples;
      sum[by_surface] += of_pixel;
    }
  }
  EXPECT_GT(sum[0], kSide * kSide * kSamples * 0.01);
  EXPECT_NEAR(sum[1], sum[0], 0.02 * sum[0]);
  EXPECT_LT(squares[1], squares[0] / 3);
}

INSTANTIATE_TEST_SUITE_P(OfBuiltinScenes, CameraPass, testing::Values("cornell", "atrium", "glass-sphere", "ring"),
                         scene_test_name);

}  // namespace
}  // namespace glowworm
