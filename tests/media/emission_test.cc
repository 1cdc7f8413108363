// The light of emissive media on surfaces and in media, by photon maps and by paths.
#include <gtest/gtest.h>

#include "core/random.h"
#include "core/warp.h"
#include "media/media_testing.h"
#include "scene/light_groups.h"

namespace glowworm {
namespace {

/// A medium that emits 1 W sr^-1 m^-3 and hardly absorbs.
Medium thin_emitter(float sigma_s) {
  Medium medium;
  medium.name = "glow";
  medium.sigma_a = RGB(1e-4f);
  medium.sigma_s = RGB(sigma_s);
  medium.emission = RGB(1e4f);
  return medium;
}

/// The closed box from -1 to 1, filled with a medium.
SceneDescription filled_box(Medium medium, float albedo) {
  SceneDescription d;
  const std::uint32_t walls = add_material(d, albedo);
  d.materials[walls].inside = 0;
  d.materials[walls].outside = kNone;
  d.media.push_back(std::move(medium));
  add_box(d, {-1, -1, -1}, {1, 1, 1}, walls);
  return d;
}

/// A hot core in cooler smoke: a grid of density, and one of emission.
Medium flame(Box3 bounds) {
  MediumGridValues values;
  values.size = {8, 8, 8};
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3 from{static_cast<float>(x) - 3.5f, static_cast<float>(y) - 3.5f, static_cast<float>(z) - 2.5f};
        const float r = length(from);
        values.density.push_back(std::max(1 - r / 4, 0.0f));
        values.emission.push_back(RGB(1.0f, 0.5f, 0.2f) * std::max(1 - r / 2, 0.0f));
      }
  Medium medium;
  medium.name = "flame";
  medium.bounds = bounds;
  medium.sigma_a = RGB(2.0f);
  medium.sigma_s = RGB(3.0f);
  medium.emission = RGB(40.0f);
  medium.grid = std::make_shared<const MediumGrid>(std::move(values));
  return medium;
}

/// Grey walls around a medium in a corner of a room that is open to the camera.
SceneDescription corner() {
  SceneDescription d;
  const std::uint32_t grey = add_material(d, 0.6f);
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, grey);
  add_quad(d, {-2, 2, 0}, {4, 0, 0}, {0, 0, 3}, grey);
  d.cameras.push_back(look_at({0, -4, 1.6f}, {0, 0, 0.7f}, {0, 0, 1}, 40));
  return d;
}

TEST(EmissiveMedia, AreTheLightOfAScene) {
  const Scene scene(filled_box(thin_emitter(0), 0.5f));
  EXPECT_FALSE(scene.environment());
  ASSERT_EQ(scene.light_source_count(), 1u);
  EXPECT_NEAR(scene.light_power().total(), 4 * kPi * 8, 1e-3);
  EXPECT_EQ(scene.source_of_medium(0), 0u);
  EXPECT_EQ(light_groups(scene).names, std::vector<std::string>{"glow"});
}

/// Files may define media that nothing is filled with.
TEST(EmissiveMedia, AreNoLightWhereNothingNamesThem) {
  SceneDescription d = filled_box(thin_emitter(0), 0.5f);
  d.media.push_back(flame({{-1, -1, -1}, {1, 1, 1}}));
  EXPECT_EQ(Scene(d).light_source_count(), 1u);
  d.materials[0].inside = kNone;
  EXPECT_TRUE(Scene(d).environment()) << "a studio light";
}

/// A horizontal surface of a medium in a basin whose walls name no medium.
TEST(EmissiveMedia, FillBasinsBelowTheirSurface) {
  SceneDescription d;
  const std::uint32_t surface = add_material(d, 0), walls = add_material(d, 0.5f);
  d.materials[surface].inside = 0;
  d.materials[surface].outside = kNone;
  d.media.push_back(thin_emitter(0));
  add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, surface);
  add_box(d, {-1, -1, -1}, {1, 1, 1}, walls);
  EXPECT_NEAR(Scene(d).light_power().total(), 4 * kPi * 8, 1e-3) << "of the box around both";
}

/// What the medium emits arrives at the walls, as often as they reflect it.
TEST(SlowEmissiveMedia, LoseNoLightInABox) {
  for (const float albedo : {0.0f, 0.5f})
    for (const float sigma_s : {0.0f, 1.0f}) {
      const Stage stage(filled_box(thin_emitter(sigma_s), albedo));
      const double emitted = 4 * kPi * 8, arrives = emitted / (1 - albedo);
      // A seed has a standard deviation of 0.5%.
      double sum = 0;
      RenderSettings settings = by_photons(1, 2, 16, 50'000, "blocked");
      for (settings.seed = 0; settings.seed < 4; ++settings.seed)
        sum += power_on_walls(stage, settings) / (4 * arrives);
      EXPECT_NEAR(sum, 1, 0.01) << albedo << " " << sigma_s;
      EXPECT_NEAR(power_on_walls(stage, by_path(1, 64)) / arrives, 1, 0.01) << albedo << " " << sigma_s;
    }
}

/// A closed ball whose front faces outwards.
Geometry ball(Vec3 centre, float radius) {
  constexpr std::uint32_t kRings = 24, kSides = 48;
  Geometry mesh;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring)
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const float theta = kPi * static_cast<float>(ring) / kRings, phi = 2 * kPi * static_cast<float>(side) / kSides;
      const float across = ring == kRings ? 0 : std::sin(theta);
      mesh.positions.push_back(centre + Vec3{across * std::cos(phi), across * std::sin(phi), std::cos(theta)} * radius);
      mesh.uvs.push_back({0, 0});
    }
  for (std::uint32_t ring = 0; ring < kRings; ++ring)
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const std::uint32_t a = ring * kSides + side, b = ring * kSides + (side + 1) % kSides;
      mesh.triangles.push_back({a, a + kSides, b + kSides});
      mesh.triangles.push_back({a, b + kSides, b});
    }
  return mesh;
}

/// A thin ball shines as all of its light from its centre: E = sigma_a Le V / h^2 below its centre (as gravity by
/// Newton's shell theorem).
TEST(EmissiveMedia, ThinBallsShineAsTheirCentre) {
  SceneDescription d;
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, add_material(d, 0.5f));
  Material interface;
  interface.kind = MaterialKind::interface;
  interface.inside = 0;
  interface.outside = kNone;
  d.materials.push_back(interface);
  d.media.push_back(thin_emitter(0));
  append_mesh(d.geometry, ball({0, 0, 1}, 0.4f), "ball", 1, kNone);
  const Stage stage(std::move(d));
  double volume = 0;
  const Geometry& g = stage.scene->geometry();
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t)
    if (g.material_of(t) == 1) volume += dot(g.corners(t)[0] - Vec3{0, 0, 1}, g.scaled_normal(t)) / 6;
  const std::vector<Vec3> place{{0, 0, 0}}, up{{0, 0, 1}};
  EXPECT_NEAR(irradiance(stage, by_photons(1, 64, 256, 20'000, "blocked"), place, up)[0] / volume, 1, 0.01);
  EXPECT_NEAR(irradiance(stage, by_path(1, 16384), place, up)[0] / volume, 1, 0.01);
}

/// Between walls as bright as the medium, places have irradiance pi. A seed has a standard deviation of 0.5%.
TEST(EmissiveMedia, AreAFurnace) {
  for (const bool grid : {false, true}) {
    Medium medium = medium_of(1.5f, 0.5f);
    medium.emission = RGB(1.0f);
    SceneDescription d = filled_box(grid ? as_grid(medium, Box3{{-1, -1, -1}, {1, 1, 1}}) : medium, 0);
    d.emissions.emplace_back().radiance.value = RGB(1.0f);
    d.emissions.back().two_sided = true;
    std::fill(d.geometry.emission.begin(), d.geometry.emission.end(), 0u);
    const Stage stage(std::move(d));
    std::vector<Vec3> places, normals;
    for (std::uint32_t i = 0; i < 64; ++i) {
      Sampler sampler(SamplerKind::sobol, 0, 1, i);
      const Vec2 across = sampler.next2(), up = sampler.next2();
      places.push_back((Vec3{across.x, across.y, up.x} - Vec3{0.5f, 0.5f, 0.5f}) * 1.2f);
      normals.push_back(square_to_sphere(sampler.next2()));
    }
    double sum = 0;
    RenderSettings settings = by_photons(1, 4, 64, 60'000, "blocked");
    for (settings.seed = 0; settings.seed < 4; ++settings.seed)
      for (const double e : irradiance(stage, settings, places, normals)) sum += e / (64 * 4 * kPi);
    EXPECT_NEAR(sum, 1, 0.01) << grid;
  }
}

/// An endless medium in balance with the light that it absorbs: a white square in it is as bright, and so is all air.
/// A seed has a standard deviation of 6% by photons.
TEST(SlowEmissiveMedia, FillAllSpace) {
  SceneDescription d;
  add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, add_material(d, 1));
  Medium medium = medium_of(1, 0.5f, 0.2f);
  medium.emission = RGB(1.0f);
  d.media.push_back(medium);
  d.ambient_medium = 0;
  d.cameras.push_back(look_at({0, -4, 1}, {0, 0, 0.3f}, {0, 0, 1}, 30));
  const Stage stage(std::move(d));
  EXPECT_NEAR(mean(stage.render(by_path(8, 256))).luminance(), 1, 0.005);
  double sum = 0;
  RenderSettings settings = by_photons(8, 16, 16, 200'000, "blocked");
  for (settings.seed = 0; settings.seed < 12; ++settings.seed) sum += mean(stage.render(settings)).luminance() / 12;
  EXPECT_NEAR(sum, 1, 0.05);
}

/// The same square, seen from close above, in thinner air: most of its light comes from far away.
TEST(SlowEmissiveMedia, LightSurfacesFromFarAway) {
  for (const float sigma_t : {1.0f, 0.1f, 0.01f}) {
    SceneDescription d;
    add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, add_material(d, 1));
    d.media.push_back(medium_of(sigma_t, 0));
    d.media.back().emission = RGB(1.0f);
    d.ambient_medium = 0;
    const Stage stage(std::move(d));
    double sum = 0;
    RenderSettings settings = by_photons(1, 4, 64, 20'000, "blocked");
    for (settings.seed = 0; settings.seed < 4; ++settings.seed)
      sum += irradiance(stage, settings, {{0, 0, 0.3f}}, {{0, 0, -1}})[0] / (4 * kPi);
    EXPECT_NEAR(sum, 1, 0.02) << sigma_t;
  }
}

struct LitCorner {
  const char* name;
  SceneDescription (*make)();
};
std::ostream& operator<<(std::ostream& out, const LitCorner& scene) { return out << scene.name; }

class EmissiveMedium : public testing::TestWithParam<LitCorner> {};

/// One seed of the flame has a standard deviation of 1% with 50,000 photons; these means have less than half of that.
TEST_P(EmissiveMedium, LightsSurfacesAndMediaAsByPaths) {
  const Stage stage(GetParam().make());
  const double paths = mean(stage.render(by_path(16, 1024))).luminance();
  RenderSettings settings = by_photons(16, 16, 16, 100'000, "blocked");
  double gathered = 0;
  for (settings.seed = 0; settings.seed < 4; ++settings.seed) gathered += mean(stage.render(settings)).luminance() / 4;
  EXPECT_NEAR(gathered, paths, 0.01 * paths);
}

TEST_P(EmissiveMedium, HasTheSameBitsForThreads) {
  const Stage stage(GetParam().make());
  std::vector<std::vector<std::uint32_t>> bits;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    bits.push_back(stage.render(by_photons(8, 2, 4, 2000, "blocked")).save());
  }
  set_thread_count(0);
  EXPECT_EQ(bits[0], bits[1]);
}

TEST_P(EmissiveMedium, IsALightGroup) {
  const Stage stage(GetParam().make());
  for (RenderSettings settings : {by_path(8, 4), by_photons(8, 4, 6, 2000, "blocked")}) {
    settings.light_groups = true;
    const Film film = stage.render(settings);
    ASSERT_EQ(film.light_group_count(), 1u);
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(film.light_of_group(0, i)[c], film.radiance(i, false)[c],
                    1e-4f * film.radiance(i, false)[c] + 1e-6f);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Slow, EmissiveMedium,
    testing::Values(LitCorner{"a box that glows",
                              [] {
                                SceneDescription d = corner();
                                Medium medium = medium_of(2, 0.5f, 0.3f);
                                medium.emission = RGB(3, 2, 1);
                                add_medium_box(d, {-0.4f, -0.3f, 0.3f}, {0.4f, 0.3f, 1}, medium);
                                return d;
                              }},
                    LitCorner{"a flame in a grid",
                              [] {
                                SceneDescription d = corner();
                                d.media.push_back(flame(Box3{{-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 1.2f}}));
                                d.ambient_medium = 0;
                                return d;
                              }},
                    LitCorner{"a glow beside fog", [] {
                                SceneDescription d = corner();
                                Medium medium = medium_of(2, 0);
                                medium.emission = RGB(5.0f);
                                add_medium_box(d, {-1.2f, -0.3f, 0.5f}, {-0.6f, 0.3f, 1}, medium);
                                add_medium_box(d, {-0.2f, -0.5f, 0.2f}, {1, 0.5f, 1.2f}, medium_of(1, 0.9f));
                                return d;
                              }}));

}  // namespace
}  // namespace glowworm
