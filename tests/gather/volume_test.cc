// Absorbing media, for camera rays of both renderers and for photons.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "control/path_tracer.h"
#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "photon/photon_tracer.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

const RGB kAbsorption{0.5f, 1.5f, 0};

/// A closed box from z = low to high, four metres wide, of glass that hardly refracts if its index is 1.0001.
void add_volume(SceneDescription& d, float low, float high, float ior = 1.0001f, float roughness = 0) {
  Material glass;
  glass.kind = MaterialKind::metallic_roughness;
  glass.reflectance.value = RGB(1.0f);
  glass.transmission.value = 1;
  glass.ior = ior;
  glass.roughness_u.value = glass.roughness_v.value = roughness;
  glass.inside = static_cast<std::uint32_t>(d.media.size());
  d.media.emplace_back().sigma_a = kAbsorption;
  d.materials.push_back(glass);
  const auto m = static_cast<std::uint32_t>(d.materials.size() - 1);
  const float h = high - low;
  add_quad(d, {-2, -2, high}, {4, 0, 0}, {0, 4, 0}, m);
  add_quad(d, {-2, -2, low}, {0, 4, 0}, {4, 0, 0}, m);
  add_quad(d, {-2, -2, low}, {4, 0, 0}, {0, 0, h}, m);
  add_quad(d, {-2, 2, low}, {0, 0, h}, {4, 0, 0}, m);
  add_quad(d, {-2, -2, low}, {0, 0, h}, {0, 4, 0}, m);
  add_quad(d, {2, -2, low}, {0, 4, 0}, {0, 0, h}, m);
}

void expect_transmitted(RGB light, float distance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c], std::exp(-kAbsorption[c] * distance), 2e-3f) << c;
}

TEST(Volume, WeakensCameraRays) {
  SceneDescription d;
  d.name = "volume";
  d.environment = Environment{};
  add_volume(d, 0, 1.25f);
  d.cameras.push_back(look_at({0.1f, 0.2f, 5}, {0.1f, 0.2f, 0}, {0, 1, 0}, 0.1f));
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  const CameraTask task{0, 0, 1, 1, 0, 16};
  Statistics statistics;
  SlotRadiance radiance;
  FirstHit first_hit;
  CameraPassSettings settings;
  settings.width = settings.height = 1;
  camera_pass(tracer, scene.camera(""), task, settings, radiance, first_hit, statistics);
  for (const RGB& seen : radiance.emitted) expect_transmitted(seen, 1.25f);
  RenderSettings paths;
  paths.width = paths.height = 1;
  trace_paths(tracer, scene.camera(""), task, paths, nullptr, radiance, first_hit, statistics);
  for (const RGB& seen : radiance.emitted) expect_transmitted(seen, 1.25f);
}

TEST(Volume, WeakensPhotons) {
  SceneDescription d = floor_description();
  add_volume(d, 0.5f, 1.5f);
  Light sun;
  sun.kind = LightKind::directional;
  sun.direction = {0, 0, -1};
  sun.intensity = RGB(1.0f);
  d.lights.push_back(sun);
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  settings.photons = 2000;
  Statistics statistics;
  const PhotonPass pass = trace_photons(tracer, settings, statistics);
  std::size_t straight = 0;
  for (std::size_t i = 0; i < pass.caustic.size(); ++i) {
    const Vec3 at = pass.caustic.position[i];
    if (std::abs(at.x) > 1.5f || std::abs(at.y) > 1.5f) continue;
    ++straight;
    const RGB flux = pass.caustic.flux[i];
    expect_transmitted(flux / flux.b, 1);
  }
  EXPECT_GT(straight, 500u);
  const FluxBalance& b = pass.balance;
  for (int c = 0; c < 3; ++c) {
    const double in = b.emitted[c] + b.scattered[c];
    EXPECT_NEAR(in, b.arrived[c] + b.escaped[c] + b.cut[c], 1e-6 * in) << "what a volume takes has arrived there";
  }
}

// Rough glass samples the light of a lamp within it, which no ray can meet if it is a point.
TEST(Volume, WeakensSamplesOfLampsWithinRoughGlass) {
  const Vec3 lamp{0.1f, 0.2f, 0.4f};
  constexpr float kTop = 1.25f;
  for (const bool is_point : {true, false}) {
    SceneDescription d;
    d.materials.emplace_back();
    add_volume(d, 0, kTop, 1.5f, 0.5f);
    if (is_point) {
      d.lights.emplace_back().position = lamp;
      d.lights.back().intensity = RGB(1.0f);
    } else {
      add_quad(d, lamp - Vec3{0.1f, 0.1f, 0}, {0.2f, 0, 0}, {0, 0.2f, 0}, 0, add_emission(d, RGB(1.0f)));
    }
    d.cameras.push_back(look_at({0.1f, 0.2f, 5}, lamp, {0, 1, 0}, 0.1f));
    const Scene scene(std::move(d));
    const Tracer tracer(scene);
    const CameraTask task{0, 0, 1, 1, 0, 256};
    Statistics statistics;
    SlotRadiance by_photons, by_paths;
    FirstHit first_hit;
    CameraPassSettings settings;
    settings.width = settings.height = 1;
    camera_pass(tracer, scene.camera(""), task, settings, by_photons, first_hit, statistics);
    RenderSettings paths;
    paths.width = paths.height = 1;
    trace_paths(tracer, scene.camera(""), task, paths, nullptr, by_paths, first_hit, statistics);
    for (const SlotRadiance* radiance : {&by_photons, &by_paths}) {
      RGB sum(0.0f);
      for (const auto* layer : {&radiance->emitted, &radiance->direct, &radiance->caustic})
        for (const RGB& seen : *layer) sum += seen;
      EXPECT_GT(sum.b, 0.1f);
      // No way from the lamp out of the glass is shorter; most are hardly longer.
      const float shortest = std::exp(-kAbsorption.r * (kTop - lamp.z));
      EXPECT_LE(sum.r, shortest * sum.b);
      EXPECT_GT(sum.r, 0.8f * shortest * sum.b);
    }
  }
}

// A floor under the volume sees the sky through it, where it gathers; all rays cross it once.
TEST(Volume, WeakensGatherRaysAndPathsFromEitherEnd) {
  constexpr std::uint32_t kSamples = 256;
  const auto sum = [](const std::vector<RGB>& seen) {
    return std::accumulate(seen.begin(), seen.end(), RGB(0.0f)) * (1.0f / kSamples);
  };
  const auto lit = [&](float low) {
    SceneDescription d = floor_description();
    d.materials[0].reflectance.value = RGB(1.0f);
    add_volume(d, low, 1);
    d.environment = Environment{};
    d.cameras.push_back(look_at({0.1f, 0.2f, 0.4f}, {0.1f, 0.2f, 0}, {0, 1, 0}, 0.1f));
    const Scene scene(std::move(d));
    const Tracer tracer(scene);
    const CameraTask task{0, 0, 1, 1, 0, kSamples};
    Statistics statistics;
    SlotRadiance gathered, by_paths;
    FirstHit first_hit;
    CameraPassSettings seen;
    seen.width = seen.height = 1;
    const GatherPoints points = camera_pass(tracer, scene.camera(""), task, seen, gathered, first_hit, statistics);
    FinalGatherSettings settings;
    settings.adds_caustics = true;
    QueryPoints queries;
    final_gather(tracer, points, 0, points.size(), settings, gathered, {queries}, statistics);
    RenderSettings paths;
    paths.width = paths.height = 1;
    trace_paths(tracer, scene.camera(""), task, paths, nullptr, by_paths, first_hit, statistics);
    return std::array{sum(gathered.caustic), sum(by_paths.caustic)};
  };
  // From below the volume, and from within it, where the floor knows nothing of it; the camera's own ray crosses 0.4 m.
  const auto all_below = lit(0.5f), all_within = lit(-0.5f);
  for (std::size_t i = 0; i < 2; ++i) {
    const RGB below = all_below[i], within = all_within[i];
    EXPECT_GT(below.b, 0.5f);
    EXPECT_LT(below.r, 0.8f * below.b);
    EXPECT_LT(within.r, below.r * std::exp(-0.4f * kAbsorption.r));
    EXPECT_LT(within.g, below.g * std::exp(-0.4f * kAbsorption.g));
  }
  // Rays of both kinds meet the same sky by the same law.
  constexpr float kTolerance = 0.03f;  // five deviations of the mean of 256 paths
  for (const auto& both : {all_below, all_within})
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(both[0][c], both[1][c], kTolerance) << c;
}

}  // namespace
}  // namespace glowworm
