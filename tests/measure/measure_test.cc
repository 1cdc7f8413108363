// Sensors: where they are, what is refused, and what their files hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "builtin/builtin.h"
#include "control/job.h"
#include "core/error.h"
#include "measure/measurement.h"
#include "measure/plan.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Sensors, ReadsPointsAsRadianceHasThem) {
  const Sensors s = parse_points("# desks\n1 2 3 0 2 0\r\n\n  -1.5e0,\t0,+2,0,0,-1\n4 5 6 0 1 1", "a.pts");
  ASSERT_EQ(s.size(), 3u);
  EXPECT_EQ(s.position[0], (Vec3{1, 2, 3}));
  EXPECT_EQ(s.normal[0], (Vec3{0, 1, 0}));
  EXPECT_EQ(s.position[1], (Vec3{-1.5f, 0, 2}));
  EXPECT_EQ(s.normal[1], (Vec3{0, 0, -1}));
  EXPECT_NEAR(s.normal[2].y, std::sqrt(0.5f), 1e-6f);
  const Sensors far = parse_points("512345.123,5412345.456,100.251,0,0,1", "a.pts", {512345, 5412345, 0});
  EXPECT_NEAR(far.position[0].x, 0.123f, 1e-6f);
  EXPECT_NEAR(far.position[0].y, 0.456f, 1e-6f);
  EXPECT_EQ(parse_points("\xef\xbb\xbf# desks\r1 2 3 0 2 0\r4 5 6 0 1 1", "a.pts").size(), 2u);
}

TEST(Sensors, RefusesPointsWithReasons) {
  const auto error = [](const std::string& text) { return error_of([&] { parse_points(text, "a.pts"); }); };
  EXPECT_THAT(error("1 2 3 0 1 0\n1 2 3 0 0 0\n"), HasSubstr("a.pts:2: the direction of the sensor has no length"));
  EXPECT_THAT(error("1 2 nan 0 1 0\n"), HasSubstr("a.pts:1: '1 2 nan 0 1 0' is not a place and a direction"));
  EXPECT_THAT(error("1 2 inf 0 1 0\n"), HasSubstr("a.pts:1"));
  EXPECT_THAT(error("1 2 3 0 1\n"), HasSubstr("x y z nx ny nz"));
  EXPECT_THAT(error("1 2 3 0 1 0 7\n"), HasSubstr("x y z nx ny nz"));
  EXPECT_THAT(error("# nothing\n"), HasSubstr("holds no sensors"));
}

TEST(Sensors, CoverPlanesAndSurfaces) {
  SceneDescription d = floor_description();
  add_panel(d, 2, add_emission(d, RGB(1.0f)));
  d.geometry.objects.clear();
  d.geometry.objects.push_back({0, "floor"});
  d.geometry.objects.push_back({2, "panel"});
  const Scene scene(std::move(d));
  const Sensors plane = plane_sensors("-z=1,0.5", scene);
  ASSERT_EQ(plane.size(), 64u);
  EXPECT_EQ(plane.position[0], (Vec3{-1.75f, -1.75f, 1}));
  EXPECT_EQ(plane.position[9], (Vec3{-1.25f, -1.25f, 1}));
  EXPECT_EQ(plane.normal[0], (Vec3{0, 0, -1}));
  const Sensors panel = surface_sensors("panel,0.5", scene);
  Vec3 middle{0, 0, 0};
  for (std::size_t i = 0; i < panel.size(); ++i) {
    EXPECT_EQ(panel.normal[i], (Vec3{0, 0, -1}));
    middle += panel.position[i] / static_cast<float>(panel.size());
  }
  EXPECT_GE(panel.size(), 2u * 5 * 5) << "sides of the triangles are 2.24 m at most";
  EXPECT_LT(length(middle - Vec3{0.25f, 0.5f, 2}), 1e-4f);
  EXPECT_THAT(error_of([&] { surface_sensors("chair,0.5", scene); }), HasSubstr("panel"));
  for (const char* bad : {"", "z", "z=1", "z=1,0", "z=x,1", "w=1,1", "z=1,nan", "z=1,1e-9"})
    EXPECT_NE(error_of([&] { plane_sensors(bad, scene); }), "no error") << bad;
  EXPECT_THAT(error_of([&] { plane_sensors("z=3,1", scene); }), HasSubstr("misses the scene"));
}

/// Of sensors in, above and beside a crate over a floor.
std::vector<std::uint32_t> objects_around_crate(float bottom) {
  SceneDescription d = floor_description();
  add_panel(d, 2, add_emission(d, RGB(1.0f)));
  d.geometry.objects = {{0, "room"}, {static_cast<std::uint32_t>(d.geometry.triangle_count()), "crate"}};
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {0.0f, 0.5f}) {
      Vec3 corner{0, 0, bottom}, u{0, 0, 0}, v{0, 0, 0};
      corner[axis] += side;
      u[(axis + 1) % 3] = v[(axis + 2) % 3] = 0.5f;
      side > 0 ? add_quad(d, corner, u, v) : add_quad(d, corner, v, u);
    }
  d.geometry.objects.resize(2);
  const Scene scene(std::move(d));
  Sensors s;
  s.add({0.25f, 0.25f, bottom + 0.25f}, {0, 0, 1});
  s.add({0.25f, 0.25f, bottom + 0.55f}, {0, 0, 1});
  s.add({-0.01f, 0.25f, 0.25f}, {0, 0, 1});
  s.add({-1, 0, 1}, {0, 0, 1});
  return objects_around(s, Tracer(scene));
}

TEST(Sensors, InsideOfObjectsAreFound) {
  const std::vector<std::uint32_t> expected = {1, kNone, kNone, kNone};
  EXPECT_EQ(objects_around_crate(0.1f), expected);
  EXPECT_EQ(objects_around_crate(0), expected) << "it stands on the floor";
}

/// Of a scene far from the origin, in its user's coordinates and to the bit.
TEST(Sensors, LieInTheCoordinatesOfTheFile) {
  SceneDescription d = lit_floor(LightCase::panel);
  translate(d, kFarAway);
  const auto far = std::make_shared<const Scene>(d);
  translate(d, -far->origin());
  const auto near = std::make_shared<const Scene>(std::move(d));
  const float above = 1 / 32.0f;  // exact there
  const std::string level = std::to_string(far->origin().z + above);
  const auto measured = [](const std::shared_ptr<const Scene>& scene, const Sensors& sensors) {
    const auto tracer = std::make_shared<const Tracer>(*scene);
    RenderSettings s = sensor_settings({});
    s.samples = 2;
    s.gather = 16;
    s.photons = 1000;
    Job job(scene, tracer, s, nullptr, 0, std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
    job.wait();
    return measurement_of(sensors, job.snapshot(), *scene);
  };
  const Sensors sensors = plane_sensors("z=" + level + ",1", *far);
  EXPECT_EQ(sensors.position, plane_sensors("z=" + std::to_string(above) + ",1", *near).position);
  EXPECT_THAT(error_of([&] { plane_sensors("z=1,1", *far); }), HasSubstr("reaches from 25000"));
  const Measurement there = measured(far, sensors), here = measured(near, sensors);
  EXPECT_EQ(there.irradiance, here.irradiance);
  EXPECT_GT(luminance(there.irradiance[0]), 0);
  EXPECT_EQ(there.origin, far->origin());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    EXPECT_EQ(here.sensors.position[i], sensors.position[i]);
    EXPECT_EQ(there.sensors.position[i], sensors.position[i]);
  }
}

Measurement example() {
  Measurement m;
  m.sensors.add({1, 2, 3}, {0, 1, 0});
  m.sensors.add({4, 5, 6}, {0, 0, -1});
  m.irradiance = {RGB(1, 2, 3), RGB(0.0f)};
  m.relative_error = {0.0125f, 0};
  return m;
}

/// A sheet that covers a third takes a third of the sun from every sensor below it.
TEST(Sensors, MeasureTheShareThatAlphaPasses) {
  SceneDescription d = floor_description();
  d.materials[0].reflectance.value = RGB(0.0f);
  d.materials.resize(2, d.materials[0]);
  d.materials[1].alpha.value = 1.0f / 3;
  add_quad(d, {-3, -3, 1}, {6, 0, 0}, {0, 6, 0}, 1);
  Light sun;
  sun.kind = LightKind::directional;
  sun.direction = {0, 0, -1};
  sun.intensity = RGB(3.0f);
  d.lights.push_back(sun);
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const Sensors sensors = plane_sensors("z=0,1", *scene);
  for (const Integrator integrator : {Integrator::gather, Integrator::path}) {
    RenderSettings s;
    s.integrator = integrator;
    s.samples = 8;
    s.photons = 1000;
    Job job(scene, tracer, sensor_settings(s), nullptr, end_of_sensors(),
            std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
    job.wait();
    for (const RGB& found : measurement_of(sensors, job.snapshot(), *scene).irradiance) EXPECT_NEAR(found.g, 2, 1e-4f);
  }
}

/// Light of window-room comes through a window: rays that are guided there find it more often.
TEST(Sensors, GuideTheirRaysToTheLight) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("window-room"));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const Sensors sensors = plane_sensors("y=0.8,0.8", *scene);
  std::vector<Measurement> found;
  for (const bool learns : {true, false}) {
    PointGrid grid = sensor_grid(sensors, false);
    EXPECT_TRUE(grid.learns);
    grid.learns = learns;
    RenderSettings s;
    s.samples = 16;
    s.gather = 64;
    s.photons = 100'000;
    s.filter = Filtering::off;
    Job job(scene, tracer, s, nullptr, 0, std::make_shared<const PointGrid>(grid));
    job.wait();
    found.push_back(measurement_of(sensors, job.snapshot(), *scene));
  }
  double mean[2] = {0, 0}, variance[2] = {0, 0};
  for (int k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      const double light = luminance(found[k].irradiance[i]);
      mean[k] += light;
      variance[k] += std::pow(light * found[k].relative_error[i], 2);
    }
  EXPECT_NEAR(mean[0], mean[1], 3 * std::sqrt(variance[0] + variance[1]));
  EXPECT_LT(variance[0], 0.8 * variance[1]);
  printf("variance %g of %g over %zu sensors\n", variance[0], variance[1], sensors.size());
}

// A narrow strip of long triangles has many sensors on little area. One of its triangles is there twice.
TEST(MeasurementFiles, MeansAreThoseOfTheArea) {
  SceneDescription d;
  d.name = "table";
  d.materials.emplace_back();
  add_quad(d, {0, 0, 0}, {1, 0, 0}, {0, 0.01f, 0});
  add_quad(d, {0, 0.01f, 0}, {1, 0, 0}, {0, 0.99f, 0});
  d.geometry.triangles.push_back(d.geometry.triangles[0]);
  d.geometry.material.push_back(0);
  d.geometry.emission.push_back(kNone);
  d.geometry.objects = {{0, "table"}};
  const Scene scene(std::move(d));
  Measurement m;
  m.sensors = surface_sensors("table,0.1", scene);
  for (const Vec3 p : m.sensors.position)
    m.irradiance.push_back(RGB((scene.outside(p).y < 0.01f ? 1000.0f : 200.0f) / kLuminousEfficacy));
  m.relative_error.resize(m.sensors.size());
  const std::string page = measurement_page(m, "about", {});
  EXPECT_THAT(page, HasSubstr("mean illuminance</td><td>208 lx"));
  EXPECT_THAT(page, HasSubstr("minimum / mean</td><td>0.962"));
}

TEST(MeasurementFiles, HoldTheColumnsOfTheHeader) {
  const std::string csv = measurement_csv(example(), "a\nb");
  EXPECT_THAT(csv, HasSubstr("# a b\n"));
  EXPECT_THAT(csv, HasSubstr("179 lm/W"));
  EXPECT_THAT(csv, HasSubstr("\nx,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error\n1,2,3,0,1,0,2,1,2,3,"));
  const float lux = 179 * (0.2126f + 2 * 0.7152f + 3 * 0.0722f);
  const nlohmann::json json = nlohmann::json::parse(measurement_json(example(), "a"));
  EXPECT_NEAR(json.at("points").at(0).at("E_lx").get<double>(), lux, 1e-3);
  EXPECT_EQ(json.at("points").at(1).at("nz"), -1.0);
  EXPECT_EQ(json.at("lumens_per_watt"), 179.0);
  EXPECT_THAT(measurement_ply(example(), "a"), HasSubstr("element vertex 2\n"));
  Measurement far = example();
  far.origin = {5412345, 0, 0};
  far.sensors.position[0].x = 0.123f;
  EXPECT_THAT(measurement_csv(far, "a"), HasSubstr("\n5412345.123,2,3,0,1,0,"));
  EXPECT_THAT(measurement_ply(far, "a"), HasSubstr("property double x\n"));
  EXPECT_THAT(measurement_vtk(far, "a"), HasSubstr("POINTS 2 double\n5412345.123 2 3\n"));
  EXPECT_NEAR(nlohmann::json::parse(measurement_json(far, "a")).at("points").at(0).at("x").get<double>(), 5412345.123,
              1e-5);
  EXPECT_THAT(measurement_vtk(example(), std::string(400, 'x')),
              HasSubstr("\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"));
}

}  // namespace
}  // namespace glowworm
