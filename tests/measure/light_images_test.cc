// The sun at sensors by flat mirrors and solid glass, and lamps by flat mirrors, against closed forms, also at the
// borders of their spots.
#include "transport/light_images.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "control/job.h"
#include "maps/air_light.h"
#include "measure/find_year.h"
#include "measure/measurement.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

constexpr float kMirror = 0.9f, kSun = 100, kWater = 1.33f;
constexpr Integrator kBoth[] = {Integrator::gather, Integrator::path};

/// A black floor of 4 m at z = 0 below the sun from 45 degrees, from -x. Materials: floor, mirror, glass.
SceneDescription black_floor() {
  SceneDescription d = floor_description();
  d.materials[0].reflectance.value = RGB(0.0f);
  d.materials.resize(3);
  d.materials[1].kind = MaterialKind::conductor;
  d.materials[1].use_reflectance = true;
  d.materials[1].reflectance.value = RGB(kMirror);
  d.materials[2].kind = MaterialKind::dielectric;
  d.materials[2].reflectance.value = d.materials[2].transmittance.value = RGB(1.0f);
  Light sun;
  sun.kind = LightKind::directional;
  sun.intensity = RGB(kSun);
  sun.direction = normalize({1, 0, -1});
  d.lights = {sun};
  return d;
}

/// What the mirrors reflect, by Schlick's term.
double reflected(double cosine) { return kMirror + (1 - kMirror) * std::pow(1 - cosine, 5); }

/// A mirror at x = 1, 0.5 m high and 1 m wide, that throws the sun back to 0.5 < x < 1.
SceneDescription below_a_mirror() {
  SceneDescription d = black_floor();
  add_quad(d, {1, -0.5f, 0}, {0, 0, 0.5f}, {0, 1, 0}, 1);
  return d;
}

/// The floor under a slab of glass of 2 cm, 1 m above it and 3 m wide, in the shade of a roof that leaves 1 m open.
SceneDescription below_a_slab() {
  SceneDescription d = black_floor();
  d.lights[0].direction = {0, 0, -1};
  const Vec3 x{3, 0, 0}, y{0, 3, 0}, z{0, 0, 0.02f}, low{-1.5f, -1.5f, 1};
  add_quad(d, low, y, x, 2);
  add_quad(d, low + z, x, y, 2);
  add_quad(d, low, x, z, 2);
  add_quad(d, low, z, y, 2);
  add_quad(d, low + x, y, z, 2);
  add_quad(d, low + y, z, x, 2);
  for (const float side : {-1.5f, 0.5f}) add_quad(d, {side, -1.5f, 1.1f}, {1, 0, 0}, {0, 3, 0});
  return d;
}

/// Measured irradiance in air.
Measurement measured(const SceneDescription& d, const Sensors& sensors, Integrator integrator, int photons = 5'000) {
  const auto scene = std::make_shared<const Scene>(d);
  RenderSettings s;
  s.integrator = integrator;
  s.samples = integrator == Integrator::path ? 256 : 8;
  s.photons = photons;
  s.gather = 64;
  Job job(scene, std::make_shared<const Tracer>(*scene), sensor_settings(s), nullptr, end_of_sensors(),
          std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
  job.wait();
  return measurement_of(sensors, job.snapshot(), *scene);
}

/// A sensor of 1 mm above the floor that faces along x or up.
Sensors sensors_at(std::initializer_list<float> x, Vec3 normal) {
  Sensors out;
  for (const float at : x) out.add({at, 0.1f, 1e-3f}, normal);
  return out;
}

TEST(LightImages, SpotsOfAMirrorHaveSharpBorders) {
  const double lit = kSun * reflected(std::sqrt(0.5)) * std::sqrt(0.5);
  const Sensors sensors = sensors_at({0.49f, 0.51f, 0.99f, 0.3f}, {1, 0, 0});
  for (const Integrator by : kBoth) {
    const Measurement m = measured(below_a_mirror(), sensors, by);
    EXPECT_EQ(m.irradiance[0].g, 0);
    EXPECT_EQ(m.irradiance[3].g, 0);
    for (const std::size_t i : {1u, 2u}) EXPECT_NEAR(m.irradiance[i].g, lit, 1e-4 * lit);
  }
}

TEST(LightImages, TheSunPassesSolidGlassWithSharpBorders) {
  // All reflections between the faces together let pass (1 - R) / (1 + R), with R = 0.04.
  const double lit = kSun * 0.96 / 1.04;
  const Sensors sensors = sensors_at({-0.51f, -0.49f, 0.49f, 0.51f}, {0, 0, 1});
  for (const Integrator by : kBoth) {
    const Measurement m = measured(below_a_slab(), sensors, by);
    for (const std::size_t i : {0u, 3u}) EXPECT_EQ(m.irradiance[i].g, 0);
    for (const std::size_t i : {1u, 2u}) EXPECT_NEAR(m.irradiance[i].g, lit, 2e-3 * lit);
  }
}

/// Glass that passes 1 in 2000.
TEST(LightImages, DarkGlassLosesNoLight) {
  constexpr double kTint = 0.0225;
  SceneDescription d = below_a_slab();
  d.materials[2].transmittance.value = RGB(static_cast<float>(kTint));
  const double lit = kSun * kTint * kTint * 0.96 * 0.96 / (1 - 0.04 * 0.04);
  for (const Integrator by : kBoth)
    EXPECT_NEAR(measured(d, sensors_at({0}, {0, 0, 1}), by).irradiance[0].g, lit, 1e-6 * kSun);
}

/// Water below z = 0.
SceneDescription water() {
  SceneDescription d = black_floor();
  d.geometry = {};
  d.materials[2].ior = kWater;
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 2);
  d.lights[0].direction = {0, 0, -1};
  return d;
}

/// Refraction spreads the light of a sun, and does not concentrate it as it does radiance.
TEST(LightImages, TheSunReachesSensorsUnderWater) {
  const double lit = kSun * 4 * kWater / ((1 + kWater) * (1 + kWater));
  Sensors sensors;
  sensors.add({0.1f, 0.2f, -0.3f}, {0, 0, 1});
  for (const Integrator by : kBoth) EXPECT_NEAR(measured(water(), sensors, by).irradiance[0].g, lit, 1e-5 * lit);
}

TEST(LightImages, RefractionWidensTheLightOfTheSun) {
  const Scene scene(water());
  const Tracer tracer(scene);
  constexpr double kSine = 0.8, kCosine = 0.6;
  const double below = std::sqrt(1 - kSine * kSine / (kWater * kWater));
  const double s = (kCosine - kWater * below) / (kCosine + kWater * below),
               p = (kWater * kCosine - below) / (kWater * kCosine + below);
  std::uint64_t rays = 0;
  const float found = light_of_image(tracer, {0, 0, -1}, {}, LightImages(scene).of(sun_towards({kSine, 0, kCosine})),
                                     {static_cast<float>(kSine / kWater), 0, static_cast<float>(below)}, rays)
                          .g;
  const double passed = 1 - (s * s + p * p) / 2;
  EXPECT_NEAR(found, passed * kCosine / below, 1e-5);
}

/// Two mirrors across given ways, the first 1 m from the origin, the second 2 m from there.
struct TwoMirrors {
  Vec3 seen = normalize({0.3f, 0.2f, 1}), between = normalize({1, -0.4f, 0.1f}), to_sun = normalize({0.2f, 0.9f, 0.8f});
  SceneDescription d = black_floor();

  TwoMirrors() {
    d.geometry = {};
    const auto add_mirror = [&](Vec3 center, Vec3 normal) {
      const Frame f = Frame::from_normal(normal);
      add_quad(d, center - (f.s + f.t) * 0.05f, f.s * 0.1f, f.t * 0.1f, 1);
    };
    add_mirror(seen, normalize(between - seen));
    add_mirror(seen + between * 2, normalize(to_sun - between));
    d.lights[0].direction = -to_sun;
  }
  double light() const {
    const auto cosine = [](Vec3 in, Vec3 out) { return std::sqrt((1 - double{dot(in, out)}) / 2); };
    return reflected(cosine(seen, between)) * reflected(cosine(between, to_sun));
  }
};

TEST(LightImages, AreSeenByTwoMirrors) {
  const TwoMirrors mirrors;
  const Scene scene(mirrors.d);
  const Tracer tracer(scene);
  double light = 0;
  std::uint64_t rays = 0;
  const ImagedLight sun = LightImages(scene).of(sun_towards(mirrors.to_sun));
  for (const Vec3 image : sun.images) {
    const double found = light_of_image(tracer, {0, 0, 0}, {}, sun, image, rays).g;
    if (found > 0) expect_near(image, mirrors.seen, 1e-5f);
    light += found;
  }
  EXPECT_NEAR(light, mirrors.light(), 1e-5);
}

/// A sheet before the mirror covers a quarter, and takes that of the light on each of its ways through it.
TEST(LightImages, AreSeenThroughSheetsByTheShareThatTheyLeave) {
  SceneDescription d = below_a_mirror();
  d.materials.push_back(d.materials[0]);
  d.materials[3].alpha.value = 0.25f;
  add_quad(d, {0.9f, -1, -0.1f}, {0, 0, 1}, {0, 2, 0}, 3);
  const Sensors sensors = sensors_at({0.6f, 0.7f, 0.8f}, {1, 0, 0});
  const double passed = 0.75 * 0.75 * kSun * reflected(M_SQRT1_2) * M_SQRT1_2;
  for (const Integrator by : kBoth)
    for (const RGB& found : measured(d, sensors, by).irradiance) EXPECT_NEAR(found.g, passed, 1e-4 * passed);
}

/// Facets of a curved mirror are too small for images, and photons bring their light: also where a scene has images.
TEST(LightImages, LeaveCurvedMirrorsToPhotons) {
  SceneDescription d = black_floor();
  constexpr int kFacets = 200;
  const auto at = [](int k) {
    const double angle = 1.2 * (k / double{kFacets} - 0.5);  // a convex cylinder
    return Vec3{static_cast<float>(1.5 - 0.5 * std::cos(angle)), -1, static_cast<float>(0.6 + 0.5 * std::sin(angle))};
  };
  for (int i = 0; i < kFacets; ++i) add_quad(d, at(i), at(i + 1) - at(i), {0, 2, 0}, 1);
  const Sensors sensors = sensors_at({0.2f, 0.4f, 0.6f}, {1, 0, 0});
  EXPECT_EQ(LightImages(Scene(d)).of(sun_towards({0, 0, 1})).images.size(), 0u);
  const Measurement alone = measured(d, sensors, Integrator::gather);
  // Out of sight.
  add_quad(d, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 1);
  EXPECT_EQ(LightImages(Scene(d)).of(sun_towards({0, 0, 1})).images.size(), 2u);
  for (const Integrator by : kBoth) {
    const Measurement m = measured(d, sensors, by);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      const double light = alone.irradiance[i].g;
      EXPECT_GT(light, 5) << i;
      const double error = light * std::hypot(alone.relative_error[i], m.relative_error[i]);
      EXPECT_NEAR(m.irradiance[i].g, light, 3 * error + 0.03 * light) << i;
    }
  }
}

/// Along a ray, by the middles of its steps.
double optical_depth(const Medium& medium, Vec3 from, Vec3 direction, double length) {
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    sum += medium_point(medium, from + direction * static_cast<float>((i + 0.5) / kSteps * length)).sigma_a.g;
  return sum * length / kSteps;
}

/// Absorbing media, even and as a grid, weaken the light in the middle of a mirror's spot: that of a sun and that of a
/// lamp without size. Rays integrate a grid as coarse as this to 1%.
TEST(LightImages, PassMedia) {
  SceneDescription d = below_a_mirror();
  d.media.resize(2);
  for (Medium& medium : d.media) {
    medium.sigma_a = RGB(0.3f);
    medium.bounds = Box3{{-1.9f, -1.9f, -1}, {0.9f, 1.9f, 1.5f}};
  }
  MediumGridValues values;
  values.size = {2, 2, 2};
  values.density = {1, 2, 1, 2, 3, 1, 3, 1};
  d.media[1].grid = std::make_shared<const MediumGrid>(std::move(values));
  const Sensors sensors = sensors_at({0.75f}, {1, 0, 0});
  const Vec3 seen = normalize({1, 0, 1}), to_light{-seen.x, 0, seen.z},
             at_mirror = sensors.position[0] + Vec3{0.25f, 0, 0.25f};
  SceneDescription with_lamp = d;
  with_lamp.lights[0].kind = LightKind::point;
  with_lamp.lights[0].position = at_mirror + to_light * 2;
  const double from_mirror = 0.25 * std::sqrt(2.0);
  for (const std::uint32_t ambient : {0u, 1u}) {
    d.ambient_medium = with_lamp.ambient_medium = ambient;
    const double depth = optical_depth(d.media[ambient], sensors.position[0], seen, from_mirror) +
                         optical_depth(d.media[ambient], at_mirror, to_light, 10);
    const double lit = kSun * reflected(std::sqrt(0.5)) * std::sqrt(0.5) * std::exp(-depth);
    const double by_lamp = lit / ((2 + from_mirror) * (2 + from_mirror)) *
                           std::exp(optical_depth(d.media[ambient], at_mirror + to_light * 2, to_light, 8));
    for (const Integrator by : kBoth) {
      EXPECT_NEAR(measured(d, sensors, by).irradiance[0].g, lit, 0.01 * lit) << ambient;
      EXPECT_NEAR(measured(with_lamp, sensors, by).irradiance[0].g, by_lamp, 0.01 * by_lamp) << ambient;
    }
  }
}

/// A lamp of 50 W sr^-1 in its aim, and how its intensity falls off, by the cosine of the angle from there.
struct LampCase {
  Light light;
  double (*relative)(double cosine) = nullptr;
};

/// One of each kind. The luminaire falls linearly from its aim to nothing at the other side.
std::vector<LampCase> lamps() {
  std::vector<LampCase> out(3);
  for (LampCase& lamp : out) {
    lamp.light.intensity = RGB(50.0f);
    lamp.light.position = {0.5f, 0.3f, 1.2f};
    lamp.light.direction = normalize({0.2f, -0.1f, -1});
    lamp.light.right = Frame::from_normal(lamp.light.direction).s;
  }
  out[0].relative = [](double) { return 1.0; };
  out[1].light.kind = LightKind::spot;
  out[1].light.falloff = SpotFalloff::quadratic;
  out[1].light.cos_outer = -1;
  out[1].relative = [](double cosine) { return (cosine + 1) * (cosine + 1) / 4; };
  out[2].light.kind = LightKind::luminaire;
  out[2].light.table = std::make_shared<const IntensityTable>(TablePole::forward, std::vector<float>{0},
                                                              std::vector<float>{0, kPi}, std::vector<float>{1, 0});
  out[2].relative = [](double cosine) { return 1 - std::acos(cosine) / kPi; };
  return out;
}

/// Irradiance at a sensor by an image of a lamp behind mirrors with axes as their normals.
/// @param turned -1 along the axes that the mirrors turn
double by_image(const LampCase& lamp, Vec3 position, Vec3 normal, Vec3 turned) {
  const Vec3 way = lamp.light.position * turned - position, to_image = normalize(way);
  double share = 1;
  for (int axis = 0; axis < 3; ++axis)
    if (turned[axis] < 0) share *= reflected(std::abs(to_image[axis]));
  const double cosine = -dot(to_image * turned, lamp.light.direction);
  return lamp.light.intensity.g * lamp.relative(cosine) * share * std::max(dot(to_image, normal), 0.0f) / dot(way, way);
}

/// Mirrors of 40 m on the planes z = 0 and, for a corner, x = 0, without a floor.
SceneDescription mirrors_under(const Light& lamp, bool corner) {
  SceneDescription d = black_floor();
  d.geometry = {};
  add_quad(d, {corner ? 0.0f : -20.0f, -20, 0}, {corner ? 20.0f : 40.0f, 0, 0}, {0, 40, 0}, 1);
  if (corner) add_quad(d, {0, -20, 0}, {0, 40, 0}, {0, 0, 20}, 1);
  d.lights = {lamp};
  return d;
}

/// Sensors that face down, to both sides, and tilted.
Sensors sensors_above() {
  Sensors out;
  for (const float z : {0.2f, 0.3f, 0.9f}) out.add({0.9f, 0.1f, z}, {0, 0, -1});
  for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, normalize({-1, 0.5f, -1}), normalize({1, 0.5f, 1})})
    out.add({0.9f, 0.1f, 0.5f}, normal);
  return out;
}

TEST(LightImages, OfLampsAreSeenByMirrorsAndCorners) {
  const Sensors sensors = sensors_above();
  for (const LampCase& lamp : lamps())
    for (const bool corner : {false, true})
      for (const Integrator by : kBoth) {
        const Measurement m = measured(mirrors_under(lamp.light, corner), sensors, by);
        for (std::size_t i = 0; i < sensors.size(); ++i) {
          double lit = 0;
          for (const Vec3 turned : {Vec3{1, 1, 1}, Vec3{1, 1, -1}, Vec3{-1, 1, 1}, Vec3{-1, 1, -1}})
            if (corner || turned.x > 0) lit += by_image(lamp, sensors.position[i], sensors.normal[i], turned);
          EXPECT_NEAR(m.irradiance[i].g, lit, 1e-3 * lit) << i << (corner ? " in a corner" : "");
        }
      }
}

/// A mirror of 1 m shows the lamp to sensors at -0.25 < x < 1.25.
TEST(LightImages, OfLampsEndWithTheMirror) {
  const LampCase lamp = lamps()[0];
  SceneDescription d = mirrors_under(lamp.light, false);
  d.geometry = {};
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
  Sensors sensors;
  for (const float x : {-0.26f, -0.24f, 1.24f, 1.26f}) sensors.add({x, 0.3f, 0.6f}, {0, 0, -1});
  for (const Integrator by : kBoth) {
    const Measurement m = measured(d, sensors, by);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      const double lit = i == 1 || i == 2 ? by_image(lamp, sensors.position[i], {0, 0, -1}, {1, 1, -1}) : 0;
      EXPECT_NEAR(m.irradiance[i].g, lit, 1e-3 * lit) << i;
    }
  }
}

/// A screen hides the way from the lamp to the mirror.
TEST(LightImages, OfLampsAreHidden) {
  const LampCase lamp = lamps()[0];
  SceneDescription d = mirrors_under(lamp.light, false);
  add_quad(d, {0.4f, 0.2f, 1}, {0.2f, 0, 0}, {0, 0.2f, 0});
  Sensors sensors;
  sensors.add({0.6f, 0.3f, 0.3f}, {0, 0, -1});
  sensors.add({1.5f, 0.3f, 0.3f}, {0, 0, -1});
  for (const Integrator by : kBoth) {
    const Measurement m = measured(d, sensors, by);
    EXPECT_EQ(m.irradiance[0].g, 0);
    const double lit = by_image(lamp, sensors.position[1], {0, 0, -1}, {1, 1, -1});
    EXPECT_NEAR(m.irradiance[1].g, lit, 1e-3 * lit);
  }
}

/// Light that a slab refracts has no image.
TEST(LightImages, OfLampsLeaveRefractionToPhotons) {
  SceneDescription d = below_a_slab();
  d.lights = {lamps()[0].light};
  d.lights[0].position = {0, 0, 2};
  const ImagedLight lamp = LightImages::of_lights(Scene(d)).of(d.lights[0]);
  EXPECT_GT(lamp.images.size(), 2u);
  const Scene scene(d);
  const Tracer tracer(scene);
  std::uint64_t rays = 0;
  for (const Vec3 image : lamp.images) EXPECT_EQ(light_of_image(tracer, {0.1f, 0, 0.1f}, {}, lamp, image, rays).g, 0);
  const Measurement m = measured(d, sensors_at({0}, {0, 0, 1}), Integrator::path, 50'000);
  // By three stated errors, which are a few percent of so few photons.
  EXPECT_NEAR(m.irradiance[0].g, 50 * 0.96 / 1.04 / 4, 3 * m.relative_error[0] * 50 / 4);
  EXPECT_LT(m.relative_error[0], 0.04);
}

/// Photons bring the light of more lamps than rays are worth.
TEST(LightImages, OfManyLampsAreNone) {
  SceneDescription d = mirrors_under(lamps()[0].light, true);
  EXPECT_EQ(LightImages::of_lights(Scene(d)).of(d.lights[0]).images.size(), 4u);
  d.lights.resize(65, d.lights[0]);
  EXPECT_TRUE(LightImages::of_lights(Scene(d)).empty());
}

TEST(LightImages, AreThoseOfTheSun) {
  SceneDescription d = below_a_mirror();
  EXPECT_FALSE(LightImages::of_lights(Scene(d)).empty());
  d.lights[0].intensity = RGB(0.0f);
  EXPECT_TRUE(LightImages::of_lights(Scene(d)).empty());
}

/// At hours between the places of the sun whose light is interpolated.
TEST(LightImages, SpotsOfAYearAreWhereTheSunThrowsThem) {
  SceneDescription d;
  d.materials = black_floor().materials;
  add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  // North is -z: a mirror of 20 cm in the north throws the sun back.
  add_quad(d, {-0.1f, 0.5f, -1}, {0.2f, 0, 0}, {0, 0.2f, 0}, 1);
  WeatherYear weather;
  for (const double hour : {10.2, 11.3, 12.6}) {
    WeatherHour h;
    h.moment = {4, 3, hour, 48, 0, 0};
    h.irradiance = {700, 1};
    weather.hours.push_back(h);
  }
  const YearModel model(weather, "", 145, 0, 7.5);
  Sensors sensors;
  for (const Vec3 sun : model.sky.sun) {
    // On the way of the middle of the spot, and 15 cm beside it.
    const Vec3 out = {sun.x, sun.y, -sun.z}, middle = Vec3{0, 0.6f, -1} - out * (0.4f / out.y);
    for (const float beside : {0.0f, 0.15f}) sensors.add(middle + Vec3{beside, 0, 0}, {0, 0, -1});
  }
  const Scene plain(d);
  const YearScene sky = under_sky(plain, model);
  const auto grid = coefficient_grid(sensors, false);
  std::vector<double> done;
  const DirectSun found =
      direct_sun(*sky.tracer, *grid, sensors.size(), model.sky, [&](double share) { done.push_back(share); });
  EXPECT_EQ(done, (std::vector<double>{0, 1})) << "before a few hours, all at once, and after them";
  for (std::size_t hour = 0; hour < 3; ++hour) {
    const Vec3 sun = model.sky.sun[hour];
    const double expected = sun.z * reflected(sun.z);
    EXPECT_NEAR(found.mirrored[2 * hour * 3 + hour], expected, 1e-4 * expected) << hour;
    EXPECT_EQ(found.mirrored[(2 * hour + 1) * 3 + hour], 0) << hour;
  }
}

}  // namespace
}  // namespace glowworm
