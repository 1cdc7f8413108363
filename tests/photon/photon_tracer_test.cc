// The photon pass: where flux goes, and that none is lost.
#include "photon/photon_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "builtin/builtin.h"
#include "core/parallel.h"
#include "photon/photon_chunk.h"
#include "scene/scene_parts.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

PhotonPass shoot(const Scene& scene, std::uint64_t photons, std::uint32_t seed = 0, std::uint32_t pass = 0) {
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  settings.photons = photons;
  settings.seed = seed;
  settings.pass = pass;
  Statistics statistics;
  PhotonPass result = trace_photons(tracer, settings, statistics);
  EXPECT_EQ(statistics.count(Counter::photons_emitted), result.emitted);
  EXPECT_EQ(statistics.count(Counter::photons_stored), result.stored);
  EXPECT_TRUE(!scene.media().empty() || result.stored == result.global.size());
  return result;
}

/// The balance adds up millions of terms in double precision: equal to that.
void expect_balanced(const PhotonPass& pass) {
  const FluxBalance& b = pass.balance;
  for (int c = 0; c < 3; ++c) {
    const double in = b.emitted[c] + b.scattered[c], out = b.arrived[c] + b.escaped[c] + b.cut[c];
    EXPECT_NEAR(in, out, 1e-11 * in);
    EXPECT_GE(b.arrived[c] - b.scattered[c], -1e-11 * in);
  }
}

class PhotonBalance : public testing::TestWithParam<std::string> {};

TEST_P(PhotonBalance, EmittedFluxIsAbsorbedEscapedOrCut) {
  const Scene scene(builtin_scene(GetParam()));
  const PhotonPass pass = shoot(scene, 20000);
  expect_balanced(pass);
  EXPECT_GE(pass.global.size(), 20000u);
  ASSERT_GT(pass.balance.emitted[0], 0);
}

TEST_P(PhotonBalance, StoredFluxIsThatOfThePhotons) {
  const Scene scene(builtin_scene(GetParam()));
  const PhotonPass pass = shoot(scene, 20000);
  double total[3] = {};
  for (const RGB& flux : pass.global.flux)
    for (int c = 0; c < 3; ++c) total[c] += flux[c];
  bool flat = true;
  for (const Vec3& n : scene.geometry().normals) flat &= n == Vec3{0, 0, 0};
  // Photons on smooth normals carry the correction for them on top.
  if (flat) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(total[c], pass.balance.stored[c], 2e-6 * pass.balance.stored[c]);
  }
  for (std::size_t i = 0; i < pass.global.size(); ++i) {
    ASSERT_TRUE(is_finite(pass.global.flux[i]));
    ASSERT_NEAR(length(pass.global.normal[i]), 1, 1e-5f);
    ASSERT_NEAR(length(pass.global.direction[i]), 1, 1e-5f);
    ASSERT_GE(dot(pass.global.normal[i], pass.global.direction[i]), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Builtin, PhotonBalance,
                         testing::Values("cornell", "ajar", "furnace-box", "glass-sphere", "ring", "window-room"),
                         scene_test_name);

/// A lamp of 1 W between two specks, in fog that fills all space.
SceneDescription lamp_in_fog(float albedo, float sigma_t) {
  SceneDescription d;
  d.materials.emplace_back().reflectance.value = RGB(0.0f);
  for (const float at : {-3.0f, 3.0f}) add_quad(d, {at, at, at}, {1e-4f, 0, 0}, {0, 1e-4f, 0}, 0);
  Light lamp;
  lamp.intensity = RGB(1 / (4 * kPi));
  d.lights.push_back(lamp);
  Medium& fog = d.media.emplace_back();
  fog.sigma_s = RGB(sigma_t * albedo);
  fog.sigma_a = RGB(sigma_t * (1 - albedo));
  d.ambient_medium = 0;
  return d;
}

/// Mean of some passes with its standard error.
struct MeanOfPasses {
  double sum = 0, squares = 0, count = 0;
  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt((squares / count - mean() * mean()) / (count - 1)); }
};

// Of 1 W, a^n W scatter for the n-th time, at a mean square of 2 n / sigma_t^2 from the lamp. The map has no photons of
// the first scattering.
TEST(PhotonsInOpenFog, AreFewFarAwayButCarryAllFlux) {
  constexpr float kAlbedo = 0.7f, kSigma = 0.8f;
  const Scene scene(lamp_in_fog(kAlbedo, kSigma));
  MeanOfPasses flux, squares, scattered;
  double far_photons = 0, far_flux = 0;
  for (std::uint32_t pass = 0; pass < 32; ++pass) {
    const PhotonPass photons = shoot(scene, 20000, 3, pass);
    expect_balanced(photons);
    double of_all = 0, by_square = 0;
    for (std::size_t i = 0; i < photons.in_media.size(); ++i) {
      const double w = photons.in_media.flux[i].r, d = length(photons.in_media.position[i]);
      of_all += w;
      by_square += w * d * d;
      if (d < 7) continue;
      far_flux += w / 32;
      far_photons += 1.0 / (32 * static_cast<double>(photons.in_media.size()));
    }
    flux.add(of_all);
    scattered.add(photons.balance.scattered[0]);
    squares.add(by_square);
  }
  const double a = kAlbedo;
  EXPECT_NEAR(scattered.mean(), a / (1 - a), 4 * scattered.error());
  EXPECT_LT(scattered.error(), 0.003 * scattered.mean());
  EXPECT_NEAR(flux.mean(), a * a / (1 - a), 4 * flux.error());
  EXPECT_LT(flux.error(), 0.01 * flux.mean());
  EXPECT_NEAR(squares.mean(), 2 * (a / ((1 - a) * (1 - a)) - a) / (kSigma * kSigma), 4 * squares.error());
  EXPECT_LT(squares.error(), 0.05 * squares.mean());
  EXPECT_LT(far_photons, 0.1 * far_flux / flux.mean());
}

TEST(PhotonTracer, LosesNothingFromClosedScenes) {
  for (const char* name : {"furnace-box", "furnace-sphere"}) {
    const Scene scene(builtin_scene(name));
    const PhotonPass pass = shoot(scene, 200000);
    expect_balanced(pass);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(pass.balance.escaped[c], 0) << name;
      EXPECT_LT(pass.balance.cut[c], 1e-9 * pass.balance.emitted[c]);
      // Every surface is diffuse, so each arrival is stored.
      EXPECT_EQ(pass.balance.stored[c], pass.balance.arrived[c]);
      // Albedo one half: half of what arrives goes on, and the sum over bounces is twice what is emitted. The number of
      // bounces of a path is geometric with a variance of 2.
      const double ratio = pass.balance.arrived[c] / pass.balance.emitted[c];
      EXPECT_NEAR(ratio, 2, 4.9 * std::sqrt(2.0 / static_cast<double>(pass.emitted))) << name;
    }
  }
}

TEST(PhotonTracer, EmitsThePowerOfTheLights) {
  for (const LightCase light : light_cases()) {
    // The power of a textured lamp is an estimate, which only chooses between lights.
    if (light == LightCase::textured || light == LightCase::all) continue;
    const Scene scene(lit_floor(light));
    const PhotonPass pass = shoot(scene, 50000);
    RGB power(0.0f);
    for (const RGB& source : scene.source_powers()) power += source;
    expect_balanced(pass);
    // Images spread the flux of photons about the mean; all else emits equal photons.
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(pass.balance.emitted[c] / power[c], 1, 0.02) << light_case_name(light) << " channel " << c;
  }
}

void expect_same_bits(const PhotonBatch& a, const PhotonBatch& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.position.data(), b.position.data(), a.size() * sizeof(Vec3)), 0);
  EXPECT_EQ(std::memcmp(a.direction.data(), b.direction.data(), a.size() * sizeof(Vec3)), 0);
  EXPECT_EQ(std::memcmp(a.flux.data(), b.flux.data(), a.size() * sizeof(RGB)), 0);
  EXPECT_EQ(std::memcmp(a.normal.data(), b.normal.data(), a.size() * sizeof(Vec3)), 0);
}

/// The flux on the floor below a point light of 1 W, with or without a ceiling through the light.
double flux_below_a_point_light(Vec3 at, Vec3 along, Vec3 across, bool ceiling) {
  const Vec3 down = normalize(cross(along, across)), corner = at - along * 0.37f - across * 0.43f;
  SceneDescription d;
  d.materials.resize(1);
  add_quad(d, corner + down * 2.0f, along, across, 0);
  if (ceiling) add_quad(d, corner, along, across, 0);
  Light light;
  light.kind = LightKind::point;
  light.position = at;
  light.intensity = RGB(static_cast<float>(1 / (4 * kPi)));
  d.lights.push_back(light);
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  settings.photons = 20000;
  settings.max_bounces = 1;
  Statistics statistics;
  const PhotonPass pass = trace_photons(tracer, settings, statistics);
  double flux = 0;
  for (std::size_t i = 0; i < pass.global.size(); ++i)
    if (dot(pass.global.position[i] - at, down) > 1) flux += pass.global.flux[i].g;
  return flux;
}

TEST(PhotonTracer, PointLightsInACeilingLightTheRoom) {
  for (const Vec3 at : {Vec3{0, 2, 0}, Vec3{31.7f, -12.3f, 7.9f}})
    for (const auto& [along, across] :
         {std::pair{Vec3{4, 0, 0}, Vec3{0, 0, 4}}, {Vec3{3.1f, 0.7f, 2}, Vec3{-1, 4.1f, 0.13f}}}) {
      const double open = flux_below_a_point_light(at, along, across, false);
      EXPECT_GT(open, 0.05);
      EXPECT_NEAR(flux_below_a_point_light(at, along, across, true), open, 0.05 * open);
    }
}

TEST(PhotonTracer, GivesTheSamePhotonsForAnyNumberOfThreads) {
  const Scene scene(builtin_scene("glass-sphere"));
  set_thread_count(1);
  const PhotonPass one = shoot(scene, 30000, 5);
  set_thread_count(2);
  const PhotonPass two = shoot(scene, 30000, 5);
  set_thread_count(0);
  EXPECT_EQ(one.emitted, two.emitted);
  expect_same_bits(one.global, two.global);
  expect_same_bits(one.caustic, two.caustic);
  EXPECT_GT(one.caustic.size(), 0u);
  EXPECT_EQ(one.balance.arrived, two.balance.arrived);
}

TEST(PhotonTracer, SeedsAndPassesHaveDifferentPhotons) {
  const Scene scene(builtin_scene("cornell"));
  const PhotonPass base = shoot(scene, 5000, 1, 0), seed = shoot(scene, 5000, 2, 0), pass = shoot(scene, 5000, 1, 1);
  EXPECT_FALSE(base.global.position[0] == seed.global.position[0]);
  EXPECT_FALSE(base.global.position[0] == pass.global.position[0]);
}

TEST(PhotonTracer, EndsIfNothingCanBeStored) {
  // The light shines away from all there is.
  SceneDescription d = floor_description();
  Light light = spot_light(SpotFalloff::smoothstep);
  light.direction = {0, 0, 1};
  d.lights.push_back(light);
  const Scene scene(std::move(d));
  const PhotonPass pass = shoot(scene, 1000);
  EXPECT_EQ(pass.global.size(), 0u);
  EXPECT_GT(pass.emitted, 0u);
  EXPECT_DOUBLE_EQ(pass.balance.escaped[0], pass.balance.emitted[0]);
}

/// Nothing takes the light away: every path bounces as often as it may.
TEST(PhotonTracer, EndsInAClosedWhiteRoom) {
  SceneDescription d = builtin_scene("furnace-box");
  for (Material& m : d.materials) m.reflectance.value = RGB(1.0f);
  const Scene scene(std::move(d));
  const PhotonPass pass = shoot(scene, 500'000);
  EXPECT_GE(pass.global.size(), 500'000u);
  EXPECT_LT(pass.global.size(), 750'000u);
  EXPECT_LT(pass.emitted, 8 * kPathsPerChunk);
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  std::uint64_t left = 500'000;
  EXPECT_LT(trace_pilot(tracer, settings, 0, 16 * kPathsPerChunk, left).size(), 8 * kPathsPerChunk);
  EXPECT_EQ(left, 0u);
}

TEST(PhotonTracer, CausticPhotonsArriveOnlyBySharpBounces) {
  const Scene scene(builtin_scene("furnace-box"));
  EXPECT_EQ(shoot(scene, 5000).caustic.size(), 0u);
  const Scene glass(builtin_scene("glass-sphere"));
  const PhotonPass pass = shoot(glass, 20000);
  EXPECT_GT(pass.caustic.size(), 100u);
  EXPECT_LT(pass.caustic.size(), pass.global.size());
}

TEST(PhotonTracer, APassOfCausticPhotonsAloneHasThoseOfTheWholePass) {
  const Scene scene(builtin_scene("glass-sphere"));
  const Tracer tracer(scene);
  PhotonPassSettings settings;
  settings.photons = 20000;
  Statistics statistics;
  const PhotonPass whole = trace_photons(tracer, settings, statistics);
  settings.choice = PhotonChoice::caustic;
  settings.max_emitted = whole.emitted;
  const PhotonPass caustic = trace_photons(tracer, settings, statistics);
  EXPECT_EQ(caustic.emitted, whole.emitted);
  EXPECT_EQ(caustic.stored, whole.caustic.size());
  EXPECT_EQ(caustic.global.size(), 0u);
  expect_same_bits(caustic.caustic, whole.caustic);
}

}  // namespace
}  // namespace glowworm
