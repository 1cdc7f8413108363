// Light that mirrors and glass bend: no integrator, pixel or sensor loses it, however often it is bent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

std::uint32_t add_mirror(SceneDescription& d, float reflectance) {
  Material mirror;
  mirror.kind = MaterialKind::conductor;
  mirror.use_reflectance = true;
  mirror.reflectance.value = RGB(reflectance);
  d.materials.push_back(mirror);
  return static_cast<std::uint32_t>(d.materials.size() - 1);
}

std::uint32_t add_diffuse(SceneDescription& d, float reflectance) {
  d.materials.emplace_back().reflectance.value = RGB(reflectance);
  return static_cast<std::uint32_t>(d.materials.size() - 1);
}

/// Schlick's reflectance.
double schlick(double at_normal, double cosine) { return at_normal + (1 - at_normal) * std::pow(1 - cosine, 5); }

void add_sun(SceneDescription& d, Vec3 travels, float irradiance) {
  Light sun;
  sun.kind = LightKind::directional;
  sun.direction = travels;
  sun.intensity = RGB(irradiance);
  d.lights.push_back(sun);
}

/// The faces of a box, seen from inside.
void add_box(SceneDescription& d, Vec3 low, Vec3 high, std::uint32_t material, std::uint32_t emission = kNone) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      Vec3 corner = low, u{0, 0, 0}, v{0, 0, 0};
      if (upper) corner[axis] = high[axis];
      u[(axis + 1) % 3] = high[(axis + 1) % 3] - low[(axis + 1) % 3];
      v[(axis + 2) % 3] = high[(axis + 2) % 3] - low[(axis + 2) % 3];
      upper ? add_quad(d, corner, v, u, material, emission) : add_quad(d, corner, u, v, material, emission);
    }
}

RenderSettings integrator(Integrator by, std::uint32_t samples) {
  RenderSettings s = by_photons(1, samples, 16, 10'000, "blocked");
  s.integrator = by;
  s.progressive = by != Integrator::path;
  return s;
}
const Integrator kAll[] = {Integrator::gather, Integrator::photons, Integrator::path};

struct Sensor {
  Vec3 position, normal;
};

std::shared_ptr<const PointGrid> grid_of(const std::vector<Sensor>& sensors) {
  auto grid = std::make_shared<PointGrid>();
  grid->width = static_cast<int>(sensors.size());
  grid->height = 1;
  grid->batches = 8;
  for (const Sensor& sensor : sensors) {
    grid->position.push_back(sensor.position);
    grid->normal.push_back(sensor.normal);
  }
  return grid;
}

/// What sensors in air measure, with its stated standard error.
struct Reading {
  double irradiance, error;
};
std::vector<Reading> measure(const Stage& stage, const RenderSettings& settings, const std::vector<Sensor>& sensors) {
  Job job(stage.scene, stage.tracer, settings, nullptr, 0, grid_of(sensors));
  job.wait();
  std::vector<Reading> out;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    out.push_back({job.film().radiance(i, false).g, std::sqrt(double{job.film().variance(i)})});
  return out;
}

/// Five stated errors, of which batches know a third, and 1% for the radius of photons.
void expect_light(const Reading& reading, double expected, double most_error) {
  EXPECT_NEAR(reading.irradiance, expected, 5 * reading.error + 0.01 * expected);
  EXPECT_LT(reading.error, most_error * expected);
  EXPECT_GT(reading.error, 0);
}

SceneDescription lamp_above_mirror() {
  SceneDescription d;
  add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, add_mirror(d, 0.95f));
  Light lamp;
  lamp.position = {-0.5f, 0, 1};
  lamp.intensity = RGB(3.0f);
  d.lights.push_back(lamp);
  return d;
}

TEST(BentLight, SensorsInAirMeetALampInAMirror) {
  const Stage stage(lamp_above_mirror());
  // The image of the lamp is 1 m away across, and 2 m in height.
  const double cosine = 2 / std::sqrt(5.0), expected = 3 * schlick(0.95, cosine) * cosine / 5;
  for (const Integrator by : kAll) {
    SCOPED_TRACE(static_cast<int>(by));
    const auto readings = measure(stage, integrator(by, 24), {{{0.5f, 0, 1}, {0, 0, -1}}});
    if (by == Integrator::photons)
      expect_light(readings[0], expected, 0.06);
    else  // by the lamp's image
      EXPECT_NEAR(readings[0].irradiance, expected, 1e-4 * expected);
  }
}

TEST(BentLight, PhotonsOfSensorsInAirTakeTheTimeOfTheirPhase) {
  const Stage stage(lamp_above_mirror());
  for (const Integrator by : kAll) {
    SCOPED_TRACE(static_cast<int>(by));
    Job job(stage.scene, stage.tracer, integrator(by, 24), nullptr, 0, grid_of({{{0.5f, 0, 1}, {0, 0, -1}}}));
    job.wait();
    const Statistics& s = job.statistics();
    EXPECT_LT(s.seconds(Phase::other), s.seconds(Phase::trace_photons));
  }
}

TEST(BentLight, SensorsBesideAWallMeetTheLightOfTheirSide) {
  SceneDescription d;
  add_quad(d, {0, -1, 0}, {1, 0, 0}, {0, 2, 0}, add_mirror(d, 0.95f));
  add_quad(d, {0, -1, 0}, {0, 2, 0}, {0, 0, 2}, add_diffuse(d, 0));
  add_sun(d, {0, 0, -1}, 1);
  const Stage stage(std::move(d));
  const auto readings =
      measure(stage, integrator(Integrator::gather, 24), {{{0.02f, 0, 1}, {0, 0, -1}}, {{-0.02f, 0, 1}, {0, 0, -1}}});
  EXPECT_NEAR(readings[0].irradiance, 0.95, 1e-4);
  EXPECT_EQ(readings[1].irradiance, 0);
}

/// A floor of reflectance 0.02 under a closed plate of glass, and the sun above: few photons return.
SceneDescription plate_over_floor(float floor = -0.5f) {
  SceneDescription d;
  add_quad(d, {-2, -2, floor}, {4, 0, 0}, {0, 4, 0}, add_diffuse(d, 0.02f));
  Material glass;
  glass.kind = MaterialKind::dielectric;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  d.materials.push_back(glass);
  add_quad(d, {-2, -2, 0.05f}, {4, 0, 0}, {0, 4, 0}, 1);
  add_quad(d, {-2, -2, -0.05f}, {0, 4, 0}, {4, 0, 0}, 1);
  add_sun(d, {0, 0, -1}, 3);
  d.cameras.push_back(square_view({0, 0, -0.5f}, {0, 0, 1}, 0.3f, 1.5f));
  return d;
}
// All reflections between the faces together let pass (1 - R) / (1 + R), with R = 0.04.
constexpr double kPlate = 0.96 / 1.04;

TEST(BentLight, PixelsOfEveryIntegratorSeeASunThroughGlass) {
  const Stage stage(plate_over_floor());
  for (const Integrator by : kAll) {
    RenderSettings settings = integrator(by, 16);
    settings.width = settings.height = 8;
    EXPECT_NEAR(mean(stage.render(settings)).value[1], 3 * kPlate * 0.02 / kPi, 0.03 * 3 * kPlate * 0.02 / kPi)
        << static_cast<int>(by);
  }
}

TEST(SlowBentLight, SensorsInAirMeetASunThroughGlass) {
  const Stage stage(plate_over_floor());
  for (const Integrator by : kAll) {
    SCOPED_TRACE(static_cast<int>(by));
    const auto readings = measure(stage, integrator(by, 16), {{{0.3f, 0.2f, -0.2f}, {0, 0, 1}}});
    if (by == Integrator::photons)
      expect_light(readings[0], 3 * kPlate, 0.06);
    else
      EXPECT_NEAR(readings[0].irradiance, 3 * kPlate, 0.01 * 3 * kPlate) << "an image of the sun";
  }
}

/// The plate is nearer than the radius of photons on the floor.
TEST(SlowBentLight, SensorsSeeTheLightOfAFloorCloseUnderGlass) {
  const Stage stage(plate_over_floor(-0.1f));
  for (const Integrator by : {Integrator::gather, Integrator::path}) {
    const double expected = 0.02 * 3 * kPlate;
    EXPECT_NEAR(measure(stage, integrator(by, 256), {{{0.3f, 0.2f, -0.09f}, {0, 0, -1}}})[0].irradiance, expected,
                0.02 * expected)
        << static_cast<int>(by);
  }
}

/// A lamp and a sensor above a plate of glass: the light from its upper face comes by an image, and photons bring what
/// its lower face reflects, over discs in which it changes. By Fresnel and Snell, with all reflections inside.
TEST(SlowBentLight, SensorsMeetALampInTheLowerFaceOfGlass) {
  SceneDescription d;
  Material glass;
  glass.kind = MaterialKind::dielectric;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  d.materials.push_back(glass);
  add_quad(d, {-3, -3, 0.1f}, {6, 0, 0}, {0, 6, 0});
  add_quad(d, {-3, -3, 0}, {0, 6, 0}, {6, 0, 0});
  Light lamp;
  lamp.position = {0, 0, 1};
  lamp.intensity = RGB(3.0f);
  d.lights.push_back(lamp);
  const Stage stage(std::move(d));
  const double away = 0.3, heights = 0.9 + 0.4, thickness = 0.1, eta = 1.5;
  double expected = 0;
  for (int passes = 0; passes < 6; ++passes) {
    const auto distance = [&](double sine) {
      return heights * sine / std::sqrt(1 - sine * sine) +
             2 * passes * thickness * sine / std::sqrt(eta * eta - sine * sine);
    };
    double low = 0, high = 1 - 1e-9;
    for (int i = 0; i < 60; ++i) (distance((low + high) / 2) < away ? low : high) = (low + high) / 2;
    const double sine = low, cosine = std::sqrt(1 - sine * sine), inside = std::sqrt(1 - sine * sine / (eta * eta));
    const double across = (cosine - eta * inside) / (cosine + eta * inside),
                 along = (eta * cosine - inside) / (eta * cosine + inside);
    const double reflected = (across * across + along * along) / 2;
    const double share =
        passes == 0 ? reflected : (1 - reflected) * (1 - reflected) * std::pow(reflected, 2 * passes - 1);
    // Solid angle over area: sin d(sin) / cos over x dx.
    const double slope = (distance(sine + 1e-6) - distance(sine - 1e-6)) / 2e-6;
    expected += 3 * share * sine / (cosine * away * slope);
  }
  for (const Integrator by : {Integrator::gather, Integrator::path}) {
    SCOPED_TRACE(static_cast<int>(by));
    const auto readings = measure(stage, integrator(by, 256), {{{0.3f, 0, 0.5f}, {0, 0, -1}}});
    expect_light(readings[0], expected, 0.03);
  }
}

/// Radiance from `direction` in a unit box of mirrors that emit 1, by following the ray until nothing is left.
double glow(Vec3 at, Vec3 direction, double reflectance) {
  double light = 0, weight = 1;
  while (weight > 1e-6) {
    int axis = 0;
    double way = 1e9;
    for (int i = 0; i < 3; ++i) {
      const double wall = direction[i] > 0 ? 1 : 0, t = direction[i] == 0 ? 1e9 : (wall - at[i]) / direction[i];
      if (t < way) way = t, axis = i;
    }
    for (int i = 0; i < 3; ++i) at[i] = std::clamp(at[i] + static_cast<float>(way) * direction[i], 0.0f, 1.0f);
    at[axis] = direction[axis] > 0 ? 1 : 0;
    light += weight;
    weight *= schlick(reflectance, std::abs(direction[axis]));
    direction[axis] = -direction[axis];
  }
  return light;
}

/// A fixed number of bounces would lose light: 0.95^33 = 18%, 0.95^17 = 42%.
TEST(BentLight, ChainsOfMirrorsKeepTheirLight) {
  SceneDescription d;
  const std::uint32_t emission = add_emission(d, RGB(1.0f));
  add_box(d, {0, 0, 0}, {1, 1, 1}, add_mirror(d, 0.95f), emission);
  const Vec3 place{0.4f, 0.45f, 0.3f};
  d.cameras.push_back(look_at(place, place + Vec3{0.3f, 0.5f, 0.8f}, {0, 0, 1}, 1));
  const Stage stage(std::move(d));
  double irradiance = 0;
  constexpr int kSide = 64;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double u = (i % kSide + 0.5) / kSide, v = (i / kSide + 0.5) / kSide, radius = std::sqrt(u);
    const Vec3 direction{static_cast<float>(radius * std::cos(2 * kPi * v)),
                         static_cast<float>(radius * std::sin(2 * kPi * v)), static_cast<float>(std::sqrt(1 - u))};
    irradiance += kPi * glow(place, direction, 0.95) / (kSide * kSide);
  }
  const double seen = glow(place, normalize(Vec3{0.3f, 0.5f, 0.8f}), 0.95);
  for (const Integrator by : {Integrator::gather, Integrator::path}) {
    SCOPED_TRACE(static_cast<int>(by));
    RenderSettings settings = integrator(by, by == Integrator::path ? 4096 : 64);
    settings.gather = 64;
    const auto readings = measure(stage, settings, {{place, {0, 0, 1}}});
    expect_light(readings[0], irradiance, 0.03);
    settings = integrator(by, 64);
    settings.width = settings.height = 8;
    EXPECT_NEAR(mean(stage.render(settings)).value[1], seen, 0.02 * seen);
  }
}

/// Between perfect mirrors every ray ends at the lamp or by roulette, so that all is as bright as the lamp.
TEST(BentLight, PathsBetweenPerfectMirrorsEnd) {
  SceneDescription d;
  add_box(d, {-1, -1, -1}, {1, 1, 1}, add_mirror(d, 1));
  const std::uint32_t emission = add_emission(d, RGB(1.0f), true);
  add_quad(d, {-0.25f, -0.25f, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, add_diffuse(d, 0), emission);
  d.cameras.push_back(look_at({0, 0, 0.9f}, {0.3f, 0.2f, 0}, {0, 1, 0}, 60));
  const Stage stage(std::move(d));
  for (const Integrator by : {Integrator::gather, Integrator::path}) {
    RenderSettings settings = integrator(by, 16);
    settings.width = settings.height = 16;
    Job job(stage.scene, stage.tracer, settings);
    job.wait();
    // A ray misses the lamp fifty times on average, and roulette gives some of those that it keeps a multiple weight.
    EXPECT_NEAR(mean(job.film()).value[1], 1, 0.06) << static_cast<int>(by);
    EXPECT_LT(job.statistics().count(Counter::camera_rays), 200u * 16 * 16 * 16);
  }
}

/// No photon stays anywhere, so none is sent.
TEST(BentLight, ScenesOfMirrorsAloneHaveNoPhotons) {
  SceneDescription d;
  add_box(d, {-1, -1, -1}, {1, 1, 1}, add_mirror(d, 1));
  Light lamp;
  lamp.position = {0.5f, 0.5f, 0.5f};
  d.lights.push_back(lamp);
  d.cameras.push_back(look_at({0, 0, 0.9f}, {0, 0, 0}, {0, 1, 0}, 60));
  const Stage stage(std::move(d));
  Job job(stage.scene, stage.tracer, integrator(Integrator::gather, 1));
  job.wait();
  EXPECT_EQ(job.statistics().count(Counter::photons_emitted), 0u);
}

}  // namespace
}  // namespace glowworm
