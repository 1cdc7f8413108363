// Light in media against closed forms and tables.
#include <gtest/gtest.h>

#include "media/media_testing.h"

namespace glowworm {
namespace {

/// A sun that shines down the z axis at an angle, with irradiance 1 across its light.
Light sun_at(float degrees) {
  Light sun;
  sun.kind = LightKind::directional;
  const float angle = degrees * kPi / 180;
  sun.direction = {std::sin(angle), 0, -std::cos(angle)};
  sun.intensity = RGB(1.0f);
  return sun;
}

/// A slab of a medium from z = -depth to 0, wide beside its depth. A speck below makes it a scene.
SceneDescription slab(Medium medium, float depth, float width) {
  SceneDescription d;
  add_quad(d, {0, 0, -2 * depth}, {1e-3f, 0, 0}, {0, 1e-3f, 0}, add_material(d, 0));
  add_medium_box(d, {-width / 2, -width / 2, -depth}, {width / 2, width / 2, 0}, std::move(medium));
  return d;
}

enum class Cover { none, pane, plate };
struct FarLight {
  Cover cover;
  Integrator integrator;
};
std::ostream& operator<<(std::ostream& out, const FarLight& of) {
  return out << static_cast<int>(of.cover) << ' ' << static_cast<int>(of.integrator);
}

/// A black floor under a sun, perhaps below glass, in air that absorbs and goes on without end.
SceneDescription floor_in_air(Cover cover, float sigma_a) {
  SceneDescription d;
  const std::uint32_t floor = add_material(d, 0), glass = add_material(d, 1);
  d.materials[floor].outside = 0;
  d.materials[glass].transmittance.value = RGB(1.0f);
  d.materials[glass].kind = cover == Cover::pane ? MaterialKind::thin_dielectric : MaterialKind::dielectric;
  add_quad(d, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0}, floor);
  if (cover == Cover::pane) add_quad(d, {-3, -3, 1}, {6, 0, 0}, {0, 6, 0}, glass);
  if (cover == Cover::plate) add_box(d, {-3, -3, 1}, {3, 3, 1.1f}, glass);
  d.media.push_back(medium_of(sigma_a, 0));
  d.ambient_medium = 0;
  d.lights.push_back(sun_at(0));
  d.cameras.push_back(look_at({0, -1, 4}, {0, 0, 0}, {0, 0, 1}, 30));
  return d;
}

class EndlessAir : public testing::TestWithParam<FarLight> {};

TEST_P(EndlessAir, WeakensLightFromAfarAsFarAsTheSceneReaches) {
  RenderSettings settings = by_photons(1, 16, 16, 200'000, "blocked");
  settings.integrator = GetParam().integrator;
  constexpr float kSigma = 0.1f, kHeight = 0.5f;
  const Stage stage(floor_in_air(GetParam().cover, kSigma)), vacuum(floor_in_air(GetParam().cover, 0));
  const auto at_height = [&](const Stage& s) { return irradiance(s, settings, {{0, 0, kHeight}}, {{0, 0, 1}})[0]; };
  const float top = stage.scene->media()[0].bounds->max.z;
  EXPECT_GT(top, 4);
  EXPECT_NEAR(at_height(stage) / at_height(vacuum), std::exp(-kSigma * (top - kHeight)), 0.005);
  EXPECT_NEAR(irradiance(stage, settings, {{0, 0, 1e-3f}}, {{0, 0, 1}})[0] / at_height(vacuum), std::exp(-kSigma * top),
              0.005);
}

INSTANTIATE_TEST_SUITE_P(
    All, EndlessAir,
    testing::Values(FarLight{Cover::none, Integrator::gather}, FarLight{Cover::none, Integrator::path},
                    FarLight{Cover::none, Integrator::photons}, FarLight{Cover::pane, Integrator::gather},
                    FarLight{Cover::pane, Integrator::path}, FarLight{Cover::pane, Integrator::photons},
                    FarLight{Cover::plate, Integrator::gather}, FarLight{Cover::plate, Integrator::path}));

struct SlabCase {
  float albedo, tau;
  double reflected[3], passed[3];  // sun along the normal, sun at 60 degrees, even light
};

// By integral equations (van de Hulst); albedo 1 and tau 1 in even light is Heaslet and Warming's.
constexpr SlabCase kSlabs[] = {
    {1, 1, {0.34133, 0.49837, 0.44659}, {0.65867, 0.50162, 0.55341}},
    {0.9f, 1, {0.26741, 0.39366, 0.35271}, {0.59162, 0.41484, 0.47475}},
    {0.5f, 1, {0.09912, 0.14975, 0.13417}, {0.44606, 0.23029, 0.30671}},
    {1, 4, {0.69091, 0.78552, 0.75401}, {0.30906, 0.21446, 0.24596}},
    {0.9f, 4, {0.40814, 0.50409, 0.47318}, {0.12852, 0.07182, 0.09056}},
    {0.9f, 0.1f, {0.04210, 0.08038, 0.07443}, {0.94675, 0.89838, 0.90595}},
};

class Slabs : public testing::TestWithParam<SlabCase> {};

/// Reflected and passed light of a slab by sensors beside it, over the light that falls on it.
void expect_slab(const SlabCase& of, int light, const RenderSettings& settings, double tolerance) {
  // Such that a share of 1e-4 of the light at most has passed the borders.
  SceneDescription d = slab(medium_of(of.tau, of.albedo), 1, of.tau < 1 ? 240 : 60);
  double falls = 1;
  if (light == 2) {
    // A hemisphere of even light is half an environment: it also shines from below, as much on either side.
    d.environment = Environment{};
    falls = kPi;
  } else {
    d.lights.push_back(sun_at(light == 0 ? 0.0f : 60.0f));
    falls = light == 0 ? 1 : 0.5;
  }
  const Stage stage(std::move(d));
  const std::vector<double> e = irradiance(stage, settings, {{0, 0, 0.01f}, {0, 0, -1.01f}}, {{0, 0, -1}, {0, 0, 1}});
  if (light == 2) {
    EXPECT_NEAR(e[0] / falls, of.reflected[2] + of.passed[2], tolerance);
    return;
  }
  EXPECT_NEAR(e[0] / falls, of.reflected[light], tolerance) << "reflected";
  EXPECT_NEAR(e[1] / falls, of.passed[light], tolerance) << "passed";
}

TEST_P(Slabs, ByPathTracing) {
  for (int light = 0; light < 3; ++light) {
    SCOPED_TRACE(light);
    expect_slab(GetParam(), light, by_path(1, 1 << 15), 0.01 * GetParam().passed[0] + 0.003);
  }
}

INSTANTIATE_TEST_SUITE_P(Values, Slabs, testing::ValuesIn(kSlabs));

struct HalfSpaceCase {
  float albedo;
  double normal, at_60;  // radiance along the normal by a sun of irradiance 1 along the normal, and at 60 degrees
};

constexpr HalfSpaceCase kHalfSpaces[] = {
    {0.5f, 0.031148, 0.019711}, {0.8f, 0.081306, 0.047931}, {0.9f, 0.122572, 0.068727}, {0.99f, 0.240863, 0.120042}};

class HalfSpaces : public testing::TestWithParam<HalfSpaceCase> {};

// a H(1)^2 / (8 pi) and its like (Chandrasekhar, Radiative Transfer, 1950).
TEST_P(HalfSpaces, ByPathTracing) {
  for (const float degrees : {0.0f, 60.0f}) {
    SceneDescription d = slab(medium_of(1, GetParam().albedo), 60, 400);
    d.lights.push_back(sun_at(degrees));
    d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 1, 1));
    const Mean seen = mean(Stage(std::move(d)).render(by_path(8, 512)));
    const double right = degrees == 0 ? GetParam().normal : GetParam().at_60;
    EXPECT_NEAR(seen.luminance(), right, 0.015 * right) << degrees;
  }
}

INSTANTIATE_TEST_SUITE_P(Values, HalfSpaces, testing::ValuesIn(kHalfSpaces));

/// Adds walls of perfect mirrors around a column of 2 x 2 m: what is in it goes on to infinity on all sides.
void add_mirrors(SceneDescription& d, float low, float high) {
  Material mirror;
  mirror.kind = MaterialKind::conductor;
  mirror.use_reflectance = true;
  mirror.reflectance.value = RGB(1.0f);
  d.materials.push_back(mirror);
  const auto material = static_cast<std::uint32_t>(d.materials.size() - 1);
  const float height = high - low;
  add_quad(d, {-1, -1, low}, {0, 2, 0}, {0, 0, height}, material);
  add_quad(d, {1, -1, low}, {0, 2, 0}, {0, 0, height}, material);
  add_quad(d, {-1, -1, low}, {2, 0, 0}, {0, 0, height}, material);
  add_quad(d, {-1, 1, low}, {2, 0, 0}, {0, 0, height}, material);
}

/// A slab or half-space of infinite width, by mirrors, under a sun along its normal.
SceneDescription mirrored_slab(Medium medium, float depth) {
  SceneDescription d;
  add_mirrors(d, -depth - 0.02f, 0.02f);
  medium.bounds = Box3{{-1.1f, -1.1f, -depth}, {1.1f, 1.1f, 0}};
  d.media.push_back(std::move(medium));
  d.ambient_medium = 0;
  d.lights.push_back(sun_at(0));
  return d;
}

/// By sensors all over a column of the slab. One seed has a standard deviation of 0.2% of what is reflected where tau
/// is 1, and of 1.3% where it is 4: photons of the sun start over all of the medium, which reaches beyond the mirrors.
class SlabsByPhotons : public Slabs {};

TEST_P(SlabsByPhotons, HaveTheirValues) {
  const SlabCase& of = GetParam();
  const Stage stage(mirrored_slab(medium_of(of.tau, of.albedo), 1));
  std::vector<Vec3> positions, normals;
  constexpr int kSide = 6;
  for (const bool below : {false, true})
    for (int i = 0; i < kSide * kSide; ++i) {
      const float u = (static_cast<float>(i % kSide) + 0.5f) * 2 / kSide - 1,
                  v = (static_cast<float>(i / kSide) + 0.5f) * 2 / kSide - 1;
      positions.push_back({u, v, below ? -1.01f : 0.01f});
      normals.push_back({0, 0, below ? 1.0f : -1.0f});
    }
  double reflected = 0, passed = 0;
  const std::uint32_t seeds = of.tau > 1 ? 16 : 1;
  RenderSettings settings = by_photons(1, 2, 64, 160'000, "blocked");
  for (settings.seed = 0; settings.seed < seeds; ++settings.seed) {
    const std::vector<double> all = irradiance(stage, settings, positions, normals);
    for (std::size_t i = 0; i < all.size(); ++i)
      (i < all.size() / 2 ? reflected : passed) += all[i] * 2 / static_cast<double>(all.size() * seeds);
  }
  EXPECT_NEAR(reflected, of.reflected[0], 0.01 * of.reflected[0] + 0.001);
  EXPECT_NEAR(passed, of.passed[0], 0.01 * of.passed[0] + 0.001);
}

INSTANTIATE_TEST_SUITE_P(Slow, SlabsByPhotons, testing::ValuesIn(kSlabs));

class HalfSpacesByPhotons : public HalfSpaces {};

TEST_P(HalfSpacesByPhotons, HaveTheirValues) {
  SceneDescription d = mirrored_slab(medium_of(1, GetParam().albedo), 30);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 1, 1.8f));
  // The more often light scatters, the fewer paths leave them.
  const std::uint64_t photons = GetParam().albedo < 0.85f ? 60'000 : 240'000;
  const double seen = mean(Stage(std::move(d)).render(by_photons(8, 4, 1, photons, "blocked"))).luminance();
  EXPECT_NEAR(seen, GetParam().normal, 0.015 * GetParam().normal);
}

INSTANTIATE_TEST_SUITE_P(Slow, HalfSpacesByPhotons, testing::ValuesIn(kHalfSpaces));

/// A beam of the sun through a slit of width D into a thin medium, seen from the side at a depth x: radiance sigma_s E
/// D p(90 degrees) exp(-sigma_t x), with what the medium before it takes away.
double beam_from_the_side(const RenderSettings& settings, float sigma, float depth) {
  constexpr float kWidth = 0.5f, kAround = 0.05f;
  SceneDescription d;
  const std::uint32_t black = add_material(d, 0);
  for (const float side : {-1.0f, 1.0f})
    add_quad(d, {side > 0 ? kWidth / 2 : -5, -5, 1}, {5 - kWidth / 2, 0, 0}, {0, 10, 0}, black);
  add_medium_box(d, {-kWidth / 2 - kAround, -2, -1}, {kWidth / 2 + kAround, 2, 0.5f}, medium_of(sigma, 0.5f));
  d.lights.push_back(sun_at(0));
  d.cameras.push_back(square_view({0, 0, 0.5f - depth}, {-1, 0, 0}, 2, 0.01f));
  const double seen = mean(Stage(std::move(d)).render(settings)).luminance();
  const double before = std::exp(-sigma * (kAround + kWidth / 2)), along = std::exp(-sigma * depth);
  return seen / (sigma * 0.5 * kWidth / (4 * kPi) * before * along);
}

TEST(ParallelBeam, IsSeenFromTheSide) {
  for (const float depth : {0.1f, 1.2f}) {
    EXPECT_NEAR(beam_from_the_side(by_path(4, 1024), 0.02f, depth), 1, 0.01) << depth;
    EXPECT_NEAR(beam_from_the_side(by_photons(4, 64, 1, 10'000, "blocked"), 0.02f, depth), 1, 0.01) << depth;
  }
}

/// A closed black box of a medium that only scatters, around a lamp: all light arrives at the walls.
class BlackBox : public testing::TestWithParam<Medium> {};

double power_of_lamp_on_walls(const Medium& medium, const RenderSettings& settings) {
  SceneDescription d;
  const std::uint32_t black = add_material(d, 0);
  d.materials[black].inside = 0;
  d.materials[black].outside = kNone;
  d.media.push_back(medium);
  add_box(d, {-1, -1, -1}, {1, 1, 1}, black);
  Light lamp;
  lamp.position = {0.3f, -0.2f, 0.4f};
  lamp.intensity = RGB(1 / (4 * kPi));
  d.lights.push_back(lamp);
  return power_on_walls(Stage(std::move(d)), settings);
}

TEST_P(BlackBox, KeepsAllLightByPathTracing) {
  EXPECT_NEAR(power_of_lamp_on_walls(GetParam(), by_path(1, 128)), 1, 0.03);
}
TEST_P(BlackBox, KeepsAllLightByPhotons) {
  EXPECT_NEAR(power_of_lamp_on_walls(GetParam(), by_photons(1, 2, 16, 50'000, "blocked")), 1, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Values, BlackBox,
                         testing::Values(medium_of(0.2f, 1, 0.6f), medium_of(1, 1), medium_of(1, 1, -0.4f)));

/// Even light stays even in a medium that only scatters.
TEST(MediaFurnace, KeepsTheEnvironment) {
  for (const float sigma : {0.2f, 5.0f}) {
    SceneDescription d;
    add_medium_box(d, {-1, -1, -1}, {1, 1, 1}, medium_of(sigma, 1, 0.3f));
    d.environment = Environment{};
    d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 5, 2.4f));
    const Stage stage(std::move(d));
    EXPECT_NEAR(mean(stage.render(by_path(8, 128))).luminance(), 1, 0.005) << sigma;
  }
}

/// Photons of the sky start in the medium around the scene, and meet all of it: also where it reaches far beyond the
/// surfaces, and where its density falls from cell to cell.
TEST(SlowMediaFurnace, KeepsTheEnvironmentByPhotons) {
  const Box3 box{{-1, -1, -1}, {1, 1, 1}};
  Medium bounded = medium_of(1.5f, 1, 0.3f);
  bounded.bounds = box;
  MediumGridValues falling;
  falling.size = {3, 3, 3};
  for (int i = 0; i < 27; ++i) falling.density.push_back(i % 3 == 1 && i / 3 % 3 == 1 && i / 9 == 1 ? 1.0f : 0.3f);
  Medium uneven = bounded;
  uneven.grid = std::make_shared<const MediumGrid>(std::move(falling));
  for (const bool ambient : {false, true})
    for (const Medium& medium : {bounded, uneven}) {
      SceneDescription d;
      add_quad(d, {-0.1f, -0.1f, 0}, {0.2f, 0, 0}, {0, 0.2f, 0}, add_material(d, 1));
      if (ambient) {
        d.media.push_back(medium);
        d.ambient_medium = 0;
      } else {
        add_medium_box(d, box.min, box.max, medium);
      }
      d.environment = Environment{};
      d.cameras.push_back(square_view({0.2f, 0.1f, 0}, {0, 0, 1}, 5, 2.4f));
      const Stage stage(std::move(d));
      EXPECT_NEAR(mean(stage.render(by_photons(8, 16, 4, 60'000, "blocked"))).luminance(), 1, 0.005)
          << ambient << !!medium.grid;
    }
}

/// Kernels reach out of both sides of slabs that are thin beside their radii, which are seen at an angle.
TEST(MediaFurnace, KeepsTheEnvironmentInThinSlabsByPhotons) {
  for (const float depth : {0.002f, 0.005f}) {
    SceneDescription d = slab(medium_of(60, 1), depth, 1);
    d.environment = Environment{};
    d.cameras.push_back(square_view({0.1f, 0, 0}, {0, 0.9f, 0.436f}, 1, 0.15f));
    const std::uint64_t photons = depth < 0.004f ? 200'000 : 20'000;
    const Stage stage(std::move(d));
    EXPECT_NEAR(mean(stage.render(by_photons(8, 16, 4, photons, "blocked"))).luminance(), 1, 0.01) << depth;
  }
}

/// A medium as bright as the walls is not seen.
TEST(MediaFurnace, EmitsAsTheWalls) {
  for (const bool grid : {false, true})
    for (const float albedo : {0.0f, 0.5f, 0.9f}) {
      SceneDescription d;
      const std::uint32_t walls = add_material(d, 0);
      d.materials[walls].inside = 0;
      Medium medium = medium_of(1.5f, albedo);
      medium.emission = RGB(1.0f);
      d.media.push_back(grid ? as_grid(medium, Box3{{-1, -1, -1}, {1, 1, 1}}) : medium);
      add_box(d, {-1, -1, -1}, {1, 1, 1}, walls, add_emission(d, RGB(1.0f), true));
      d.cameras.push_back(look_at({0.2f, 0.1f, 0.5f}, {0, 0, -1}, {0, 1, 0}, 60));
      const Stage stage(std::move(d));
      EXPECT_NEAR(mean(stage.render(by_path(8, 64))).luminance(), 1, 0.005) << albedo;
    }
}

struct AirlightCase {
  float sigma, height;
  double radiance;
};

/// Light of a point lamp that air scatters once along ten metres, beside the lamp.
class Airlight : public testing::TestWithParam<AirlightCase> {};

double airlight(const AirlightCase& of, RenderSettings settings) {
  SceneDescription d;
  add_quad(d, {-1, -1, -5}, {2, 0, 0}, {0, 2, 0}, add_material(d, 0));
  d.media.push_back(medium_of(of.sigma, 1));
  d.ambient_medium = 0;
  Light lamp;
  lamp.position = {0, of.height, 0};
  lamp.intensity = RGB(1.0f);
  d.lights.push_back(lamp);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 5, 1e-3f));
  settings.max_bounces = 1;
  settings.sampler = SamplerKind::sobol;
  return mean(Stage(std::move(d)).render(settings)).luminance();
}

TEST_P(Airlight, ByPathTracing) {
  EXPECT_NEAR(airlight(GetParam(), by_path(4, 1024)), GetParam().radiance, 0.01 * GetParam().radiance);
}
TEST_P(Airlight, ByLightSamplesOfSegments) {
  EXPECT_NEAR(airlight(GetParam(), by_photons(4, 256, 1, 1000, "blocked")), GetParam().radiance,
              0.01 * GetParam().radiance);
}

INSTANTIATE_TEST_SUITE_P(Values, Airlight,
                         testing::Values(AirlightCase{0.05f, 1, 0.007856}, AirlightCase{0.05f, 0.25f, 0.036627},
                                         AirlightCase{0.2f, 1, 0.012126}, AirlightCase{0.2f, 0.25f, 0.064269},
                                         AirlightCase{1, 1, 0.000566}, AirlightCase{1, 0.25f, 0.004511}));

/// Absorbing air dims a lamp in front of a point and one behind it.
TEST(MediaPoints, LookBehindThroughTheMedium) {
  constexpr float kAbsorption = 0.3f, kDistance = 2, kBehind = 0.25f;
  SceneDescription d;
  d.materials.resize(1);
  d.media.push_back(medium_of(kAbsorption, 0));
  d.ambient_medium = 0;
  add_quad(d, {5, 5, 5}, {1, 0, 0}, {0, 1, 0});
  d.materials[0].reflectance.value = RGB(0.0f);
  Light lamp;
  lamp.intensity = RGB(1.0f);
  d.lights.push_back(lamp);
  const Stage stage(std::move(d));
  PointGrid grid;
  grid.width = 2;
  grid.height = 1;
  grid.position = {{0, 0, -kDistance}, {0, 0, kDistance}};
  grid.normal.assign(2, {0, 0, 1});
  grid.from_behind.assign(2, RGB(kBehind));
  const double arriving = std::exp(-kAbsorption * kDistance) / (kDistance * kDistance);
  for (const RenderSettings& settings : {by_path(1, 4), by_photons(1, 4, 4, 1000)}) {
    Job job(stage.scene, stage.tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(grid));
    job.wait();
    const Film film = job.snapshot();
    EXPECT_NEAR(film.radiance(0, false).g, (1 - kBehind) * arriving, 1e-4);
    EXPECT_NEAR(film.radiance(1, false).g, kBehind * arriving, 1e-4);
  }
}

/// All shadow rays of a sensor to a sun or to a lamp without size are one: each has a transmittance of its own.
TEST(MediaPoints, SeeLampsThroughGrids) {
  SceneDescription d;
  add_quad(d, {5, 5, 5}, {1, 0, 0}, {0, 1, 0}, add_material(d, 0));
  Medium smoke = medium_of(1.2f, 0);
  smoke.bounds = Box3{{-1, -1, -1}, {1, 1, 1}};
  MediumGridValues two_cells;
  two_cells.size = {1, 1, 2};
  two_cells.density = {1, 0.5f};
  smoke.grid = std::make_shared<const MediumGrid>(std::move(two_cells));
  d.media.push_back(std::move(smoke));
  d.ambient_medium = 0;
  d.lights.push_back(sun_at(0));
  Light lamp;
  lamp.position = {0, 0, 2};
  lamp.intensity = RGB(1.0f);
  d.lights.push_back(lamp);
  const Stage stage(std::move(d));
  // The outer eighths of the cells are missing, as their density falls to a half at the borders.
  const double passed = std::exp(-1.2 * 1.5 * (1 - 1.0 / 8)), right = passed * (1 + 1.0 / 16);
  for (const RenderSettings& settings : {by_path(1, 1 << 15), by_photons(1, 256, 256, 1000, "blocked")})
    EXPECT_NEAR(irradiance(stage, settings, {{0, 0, -2}}, {{0, 0, 1}})[0], right, 0.015 * right);
}

/// The light of groups is that of the picture, in media, too.
TEST(SlowMediaScenes, KeepLightGroupsApart) {
  SceneDescription d = foggy_floor(false);
  Light lamp;
  lamp.name = "lamp";
  lamp.position = {1, 0, 0.2f};
  lamp.intensity = RGB(1.0f);
  d.lights.push_back(lamp);
  const Stage stage(std::move(d));
  for (RenderSettings settings : {by_path(8, 4), by_photons(8, 4, 6, 2000, "blocked")}) {
    settings.light_groups = true;
    const Film film = stage.render(settings);
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      RGB sum;
      for (std::size_t group = 0; group < film.light_group_count(); ++group) sum += film.light_of_group(group, i);
      const RGB all = film.radiance(i, false);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], all[c], 1e-4f * all[c] + 1e-6f);
    }
  }
}

/// One medium, as that of the camera and of all space, and as a box around everything.
TEST(SlowMediaScenes, TellOneMediumInTwoWays) {
  const auto room = [](bool boxed) {
    SceneDescription d;
    const std::uint32_t grey = add_material(d, 0.5f), black = add_material(d, 0);
    add_quad(d, {-2, -2, -1}, {4, 0, 0}, {0, 4, 0}, grey);
    add_quad(d, {-0.5f, -0.5f, 1}, {0, 1, 0}, {1, 0, 0}, black, add_emission(d, RGB(5.0f)));
    Medium fog = medium_of(0.4f, 0.9f, 0.3f);
    if (boxed) {
      add_medium_box(d, {-6, -6, -6}, {6, 6, 6}, fog);
    } else {
      fog.bounds = Box3{{-6, -6, -6}, {6, 6, 6}};
      d.media.push_back(fog);
      d.ambient_medium = 0;
    }
    d.cameras.push_back(look_at({0, -4, 0.5f}, {0, 0, 0}, {0, 0, 1}, 60));
    return Stage(std::move(d));
  };
  const Stage as_ambient = room(false), as_box = room(true);
  const auto seen = [](const Stage& stage, const RenderSettings& settings) {
    return mean(stage.render(settings)).luminance();
  };
  // A seed has a standard deviation of 8% by 4,000 photons, so 2% by these.
  const RenderSettings by_paths = by_path(12, 256), by_maps = by_photons(12, 2, 8, 64'000, "blocked");
  const double paths = seen(as_box, by_paths), photons = seen(as_box, by_maps);
  EXPECT_NEAR(seen(as_ambient, by_paths), paths, 0.02 * paths);
  EXPECT_NEAR(seen(as_ambient, by_maps), photons, 0.03 * photons);
  EXPECT_NEAR(photons, paths, 0.05 * paths);
}

}  // namespace
}  // namespace glowworm
