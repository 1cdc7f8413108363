// Guided emission: more photons where the image needs them, and the same mean light.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "builtin/builtin.h"
#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"
#include "core/parallel.h"
#include "core/random.h"
#include "maps/photon_guiding.h"

namespace glowworm {
namespace {

RenderSettings small_picture(const Scene& scene) {
  RenderSettings s;
  s.width = 64;
  s.height = 48;
  return resolve(s, scene);
}

/// Photons and their flux in a box, per emitted path and per stored photon.
struct Arrivals {
  double photons_per_path = 0, share_of_stored = 0;
  double flux = 0, standard_error = 0;  // W, luminance; over passes
};

Arrivals arrivals_in(const Box3& room, const Tracer& tracer, const EmissionGuide* guide, int passes) {
  double emitted = 0, stored = 0, inside = 0, sum = 0, squares = 0;
  for (int pass = 0; pass < passes; ++pass) {
    PhotonPassSettings settings;
    settings.photons = 20000;
    settings.pass = static_cast<std::uint32_t>(pass);
    settings.guide = guide;
    Statistics statistics;
    const PhotonPass photons = trace_photons(tracer, settings, statistics);
    double flux = 0;
    for (std::size_t i = 0; i < photons.global.size(); ++i) {
      const Vec3 p = photons.global.position[i];
      bool in = true;
      for (int a = 0; a < 3; ++a) in &= p[a] > room.min[a] && p[a] < room.max[a];
      if (!in) continue;
      flux += luminance(photons.global.flux[i]);
      ++inside;
    }
    emitted += static_cast<double>(photons.emitted);
    stored += static_cast<double>(photons.global.size());
    sum += flux;
    squares += flux * flux;
  }
  Arrivals out;
  out.photons_per_path = inside / emitted;
  out.share_of_stored = inside / stored;
  out.flux = sum / passes;
  out.standard_error = std::sqrt((squares / passes - out.flux * out.flux) / (passes - 1));
  return out;
}

void report(const Arrivals& plain, const Arrivals& guided) {
  fmt::print(
      "photons per path {:.5f} without, {:.5f} with guiding: {:.1f} times; of those stored {:.4f}, {:.4f}: {:.1f} "
      "times; flux {:.4f} +- {:.4f}, {:.4f} +- {:.4f} W\n",
      plain.photons_per_path, guided.photons_per_path, guided.photons_per_path / plain.photons_per_path,
      plain.share_of_stored, guided.share_of_stored, guided.share_of_stored / plain.share_of_stored, plain.flux,
      plain.standard_error, guided.flux, guided.standard_error);
}

/// The means must agree at 4 standard errors: a false alarm in 16,000 runs of another seed.
void expect_same_flux(const Arrivals& a, const Arrivals& b) {
  EXPECT_NEAR(a.flux, b.flux, 4 * std::hypot(a.standard_error, b.standard_error));
}

TEST(PhotonGuiding, BringsTwentyTimesThePhotonsThroughAWindowOfOnePercent) {
  const Scene scene(builtin_scene("window-room"));
  const Tracer tracer(scene);
  const PhotonGuiding guiding = guide_photons(tracer, scene.camera(""), small_picture(scene));
  // The inner faces of the room, with those of the window's reveal, whose bounds stand in builtin_window_room().
  Box3 room;
  room.grow(Vec3{-2.55f, -0.05f, -2.05f});
  room.grow(Vec3{2.55f, 3.05f, 2.05f});
  const Arrivals plain = arrivals_in(room, tracer, nullptr, 40);
  const Arrivals guided = arrivals_in(room, tracer, &guiding.guide, 40);
  report(plain, guided);
  EXPECT_GE(guided.photons_per_path, 20 * plain.photons_per_path);
  EXPECT_LT(guided.standard_error, plain.standard_error);
  expect_same_flux(plain, guided);
}

/// Fifty rooms in a row, each closed and with a lamp of its own; the camera is in one of them.
SceneDescription fifty_rooms(int watched) {
  SceneDescription scene;
  scene.name = "fifty rooms";
  MeshBuilder mesh(scene.geometry);
  const std::uint32_t wall = add_diffuse(scene, "wall", RGB(0.5f));
  const std::uint32_t lamp = add_emission(scene, "lamp", RGB(10));
  for (int i = 0; i < 50; ++i) {
    const float x = 5 * static_cast<float>(i);
    mesh.set_material(wall);
    mesh.room({x, 0, 0}, {x + 4, 3, 4});
    mesh.set_material(wall, lamp);
    mesh.quad({x + 1.5f, 2.9f, 1.5f}, {x + 2.5f, 2.9f, 1.5f}, {x + 2.5f, 2.9f, 2.5f}, {x + 1.5f, 2.9f, 2.5f});
  }
  const float x = 5 * static_cast<float>(watched);
  scene.cameras.push_back(look_at({x + 0.5f, 1.5f, 0.5f}, {x + 3, 1, 3}, {0, 1, 0}, 70));
  return scene;
}

TEST(PhotonGuiding, FindsTheOneLampAmongFiftyThatLightsTheRoom) {
  const Scene scene(fifty_rooms(31));
  const Tracer tracer(scene);
  const PhotonGuiding guiding = guide_photons(tracer, scene.camera(""), small_picture(scene));
  Box3 room;
  room.grow(Vec3{154.9f, -0.1f, -0.1f});
  room.grow(Vec3{159.1f, 3.1f, 4.1f});
  const Arrivals plain = arrivals_in(room, tracer, nullptr, 16);
  const Arrivals guided = arrivals_in(room, tracer, &guiding.guide, 16);
  report(plain, guided);
  // One path in fifty, at the most every one.
  EXPECT_NEAR(plain.share_of_stored, 0.02, 0.002);
  EXPECT_GT(guided.share_of_stored, 0.4);
  expect_same_flux(plain, guided);
}

/// A small house on a plain of fifteen times its length, under a sky that shines in by a skylight; the camera is
/// inside.
SceneDescription house_on_a_plain() {
  SceneDescription scene;
  scene.name = "house on a plain";
  MeshBuilder mesh(scene.geometry);
  mesh.set_material(add_diffuse(scene, "wall", RGB(0.6f)));
  mesh.quad({-30, 0, 30}, {30, 0, 30}, {30, 0, -30}, {-30, 0, -30});
  mesh.box({-2.2f, 0, -2.2f}, {2.2f, 3, -2});
  mesh.box({-2.2f, 0, 2}, {2.2f, 3, 2.2f});
  mesh.box({-2.2f, 0, -2}, {-2, 3, 2});
  mesh.box({2, 0, -2}, {2.2f, 3, 2});
  mesh.box({-2.2f, 3, -2.2f}, {2.2f, 3.2f, -1});
  mesh.box({-2.2f, 3, 1}, {2.2f, 3.2f, 2.2f});
  mesh.box({-2.2f, 3, -1}, {-1, 3.2f, 1});
  mesh.box({1, 3, -1}, {2.2f, 3.2f, 1});
  scene.environment = Environment{};
  scene.cameras.push_back(look_at({-1.5f, 1.6f, 1.5f}, {1, 1, -2}, {0, 1, 0}, 70));
  return scene;
}

TEST(SlowPhotonGuiding, FindsASmallHouseOnALargePlain) {
  const Scene scene(house_on_a_plain());
  const Tracer tracer(scene);
  const PhotonGuiding guiding = guide_photons(tracer, scene.camera(""), small_picture(scene));
  Box3 house;
  house.grow(Vec3{-1.99f, -0.01f, -2.01f});
  house.grow(Vec3{1.99f, 3.01f, 2.01f});
  const Arrivals plain = arrivals_in(house, tracer, nullptr, 48);
  const Arrivals guided = arrivals_in(house, tracer, &guiding.guide, 48);
  report(plain, guided);
  EXPECT_GE(guided.photons_per_path, 20 * plain.photons_per_path);
  EXPECT_LT(guided.standard_error, plain.standard_error);
  expect_same_flux(plain, guided);
}

TEST(PhotonGuiding, DoesNothingIfEmissionNeedsNoGuiding) {
  for (const char* name : {"cornell", "furnace-box"}) {
    const Scene scene(builtin_scene(name));
    const Tracer tracer(scene);
    const PhotonGuiding guiding = guide_photons(tracer, scene.camera(""), small_picture(scene));
    EXPECT_EQ(guiding.guide.cell_count(), 1u) << name;
    EXPECT_FALSE(guiding.importance.gathered.empty());
  }
}

TEST(PhotonGuiding, IsTheSameForAnyNumberOfThreads) {
  const Scene scene(builtin_scene("window-room"));
  const Tracer tracer(scene);
  RenderSettings settings = small_picture(scene);
  settings.photons = 50000;
  std::vector<EmissionNumbers> warped[2];
  std::vector<float> weights[2];
  for (int i = 0; i < 2; ++i) {
    set_thread_count(i + 1);
    const PhotonGuiding guiding = guide_photons(tracer, scene.camera(""), settings);
    Sampler sampler(SamplerKind::independent, 1, 2, 3);
    for (int n = 0; n < 1000; ++n) {
      EmissionNumbers u = {sampler.next1(), sampler.next1(), sampler.next1(), sampler.next1(), sampler.next1()};
      weights[i].push_back(guiding.guide.warp(u));
      warped[i].push_back(u);
    }
  }
  set_thread_count(0);
  EXPECT_EQ(weights[0], weights[1]);
  EXPECT_EQ(warped[0], warped[1]);
}

}  // namespace
}  // namespace glowworm
