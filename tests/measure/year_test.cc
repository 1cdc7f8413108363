// A year of daylight against the weather file, against renders of single hours, and by hand.
#include "measure/year.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "control/job.h"
#include "core/error.h"
#include "measure/find_year.h"
#include "measure/measurement.h"
#include "measure/year_watch.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

constexpr double kGround = 0.2, kLatitude = 48;

/// Every third hour of a day in every second month, clear and overcast in turn.
WeatherYear some_hours() {
  WeatherYear out;
  for (int month = 1; month <= 12; month += 2)
    for (int hour = 1; hour <= 24; hour += 3) {
      WeatherHour h;
      h.moment = {month, 21, hour - 0.5, kLatitude, 0, 0};
      h.hour = hour;
      const double altitude = sun_place(h.moment).altitude;
      if (altitude > 0) h.irradiance = {month % 4 == 1 ? 800 * std::sin(altitude * M_PI / 180) : 0, 100.0 + month};
      out.hours.push_back(h);
    }
  return out;
}

/// What a sensor gets of the sky of an hour, times the luminous efficacy: lx.
double horizontal_lux(const WeatherHour& hour) {
  const std::optional<PerezSky> sky = perez_sky(hour.moment, hour.irradiance);
  return sky ? kLuminousEfficacy * sky->horizontal() : 0;
}

RenderSettings quick() {
  RenderSettings s;
  s.samples = 8;
  s.gather = 256;
  s.photons = 100'000;
  s.guiding = false;
  s.filter = Filtering::off;
  return s;
}

struct Model {
  YearSky sky;
  SkyPatches patches;
  SunGrid grid;

  explicit Model(const WeatherYear& year, int count = 145, double step = 7.5)
      : sky(year_sky(year, SkyPatches(count), kGround)),
        patches(count),
        grid(year.hours.front().moment, sky.sun, sky.beam, step) {}

  YearState state_of(const SceneDescription& d, const Sensors& sensors, std::uint32_t seed = 0) const {
    const auto points = coefficient_grid(sensors, false);
    RenderSettings s = patch_settings(quick());
    s.seed = seed;
    const YearScene of_sky(scene_under_patches(Scene(d), patches)), of_suns(scene_under_suns(Scene(d), grid.places()));
    Job first(of_sky.scene, of_sky.tracer, s, nullptr, 0, points);
    first.wait();
    Job second(of_suns.scene, of_suns.tracer, s, nullptr, 0, points);
    second.wait();
    return {{daylight_matrix(first, sensors.size()), sun_matrix(second, sensors.size(), grid.places().size())},
            direct_sun(*of_sky.tracer, *points, sensors.size(), sky)};
  }
};

/// Ground of reflectance 0.5, 4 m x 4 m.
SceneDescription ground_alone() {
  SceneDescription d;
  d.materials.resize(1);
  add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  return d;
}

/// With a wall of 2 m in the north.
SceneDescription ground_and_wall() {
  SceneDescription d = ground_alone();
  add_quad(d, {-2, 0, -2}, {4, 0, 0}, {0, 2, 0});
  return d;
}

/// Suns turn with the site, and so do their places.
TEST(YearSky, TurnsWithTheNorth) {
  WeatherYear year = some_hours();
  const YearSky plain = year_sky(year, SkyPatches(145), kGround);
  const SunGrid grid(year.hours.front().moment, plain.sun, plain.beam, 10);
  for (WeatherHour& hour : year.hours) hour.moment.turn = 90;
  const YearSky turned = year_sky(year, SkyPatches(145), kGround);
  const SunGrid turned_grid(year.hours.front().moment, turned.sun, turned.beam, 10);
  ASSERT_EQ(turned.sun.size(), plain.sun.size());
  const auto left = [](Vec3 d) { return Vec3{d.z, d.y, -d.x}; };
  const auto interpolated = [](const SunGrid& of, std::size_t sun) {
    Vec3 sum{0, 0, 0};
    for (const SunGrid::Share& share : of.shares()[sun])
      if (share.weight > 0) sum += of.places()[share.place] * share.weight;
    return sum;
  };
  for (std::size_t i = 0; i < plain.sun.size(); ++i) {
    EXPECT_LT(length(turned.sun[i] - left(plain.sun[i])), 1e-6f) << i;
    EXPECT_LT(length(interpolated(turned_grid, i) - left(interpolated(grid, i))), 1e-4f) << i;
  }
}

TEST(YearSky, KeepsTheHorizontalIrradiance) {
  const WeatherYear year = some_hours();
  for (const int count : {145, 577}) {
    const SkyPatches patches(count);
    const YearSky sky = year_sky(year, patches, kGround);
    std::vector<double> projected(patches.size());
    for (const SkyPatches::Piece& piece : patches.pieces(3)) projected[piece.patch] += piece.projected;
    double whole = 0;
    for (const double p : projected) whole += p;
    EXPECT_NEAR(whole, M_PI, 1e-6);
    ASSERT_GT(sky.lit.size(), 20u);
    for (std::size_t i = 0; i < sky.lit.size(); ++i) {
      double e = 0;
      for (std::size_t patch = 1; patch < patches.size(); ++patch) e += sky.sky.at(patch, i).g * projected[patch];
      const WeatherHour& hour = sky.hours[sky.lit[i]];
      EXPECT_NEAR(e, perez_sky(hour.moment, hour.irradiance)->diffuse, 1e-4 * e);
      EXPECT_NEAR(sky.sky.at(0, i).g, kGround * horizontal_lux(hour) / kLuminousEfficacy / M_PI, 1e-3);
    }
  }
}

TEST(YearSky, IsExchangedWithRadiance) {
  const WeatherYear year = some_hours();
  YearSky sky = year_sky(year, SkyPatches(145), kGround);
  const YearSky before = sky;
  ColorMatrix matrix = matrix_of_sky(sky);
  EXPECT_EQ(matrix.columns, year.hours.size());
  EXPECT_EQ(matrix.at(5, 0).r, 0) << "night";
  for (RGB& v : matrix.value) v *= 2;
  replace_sky(sky, matrix, "a.smx");
  EXPECT_EQ(sky.sky.at(7, 3).g, 2 * before.sky.at(7, 3).g);
  matrix.columns -= 1;
  EXPECT_THROW(replace_sky(sky, matrix, "a.smx"), Error);
}

TEST(Year, OfAnOpenSensorIsTheHorizontalIlluminance) {
  Sensors sensors;
  sensors.add({0, 0.5f, 0}, {0, 1, 0});
  const WeatherYear weather = some_hours();
  const Model model(weather);
  const YearState state = model.state_of(ground_alone(), sensors);
  const Year year = year_of(model.sky, model.grid, std::span(&state, 1), {});
  double sum = 0, expected = 0;
  for (std::size_t hour = 0; hour < year.hours; ++hour) {
    const double lux = horizontal_lux(weather.hours[hour]);
    EXPECT_NEAR(year.at(0, hour), lux, 0.02 * lux) << hour;
    sum += year.at(0, hour), expected += lux;
  }
  EXPECT_NEAR(sum, expected, 0.01 * expected);
  EXPECT_NEAR(share_under(state.coefficients, overcast_sky(model.patches, kGround))[0], 1, 0.01);
}

TEST(SlowYear, OfSingleHoursIsWhatRendersOfThemMeasure) {
  SceneDescription d = ground_and_wall();
  Sensors sensors;
  sensors.add({0, 0.5f, -1}, {0, 1, 0});
  sensors.add({1, 0.5f, -1}, normalize({0.2f, 0, -1}));
  sensors.add({0, 0.5f, 0}, {0, -1, 0});
  WeatherYear weather;
  for (const auto& [month, hour, direct] :
       {std::tuple{6, 10, 700.0}, std::tuple{3, 15, 500.0}, std::tuple{9, 12, 0.0}}) {
    WeatherHour h;
    h.moment = {month, 21, hour - 0.5, kLatitude, 0, 0};
    h.hour = hour;
    h.irradiance = {direct, 150};
    weather.hours.push_back(h);
  }
  const Model model(weather);
  const YearState state = model.state_of(d, sensors);
  const Year year = year_of(model.sky, model.grid, std::span(&state, 1), {});
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false));
  for (std::size_t hour = 0; hour < 3; ++hour) {
    SceneDescription lit = d;
    add_perez_sky(weather.hours[hour].moment, weather.hours[hour].irradiance, kGround, lit);
    const auto scene = std::make_shared<const Scene>(std::move(lit));
    RenderSettings one = sensor_settings(quick());
    one.samples = 4;
    Job job(scene, std::make_shared<const Tracer>(*scene), one, nullptr, end_of_sensors(), grid);
    job.wait();
    const Measurement m = measurement_of(sensors, job.film(), *scene);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      const double lux = illuminance(m.irradiance[i]);
      EXPECT_NEAR(year.at(i, hour), lux, (0.03 + 2 * m.relative_error[i]) * lux) << hour << ' ' << i;
    }
  }
  EXPECT_GT(year.sun[0], 0.5f * year.at(0, 0)) << "the sun alone";
  EXPECT_EQ(year.sun[2 * year.hours], 0) << "from above";
}

TEST(Year, FollowsTheScheduleOfShades) {
  SceneDescription roofed = ground_alone();
  add_quad(roofed, {-9, 2, -9}, {18, 0, 0}, {0, 0, 18});
  Sensors sensors;
  sensors.add({0, 1.9f, 0}, {0, 1, 0});
  WeatherYear weather = some_hours();
  const Model model(weather, 145, 20);
  const YearState states[2] = {model.state_of(ground_alone(), sensors), model.state_of(roofed, sensors)};
  std::vector<std::uint32_t> schedule(weather.hours.size());
  for (std::size_t i = 0; i < schedule.size(); ++i) schedule[i] = i % 2;
  const Year year = year_of(model.sky, model.grid, states, schedule);
  for (std::size_t hour = 0; hour < year.hours; ++hour) {
    const double open = horizontal_lux(weather.hours[hour]);
    EXPECT_NEAR(year.at(0, hour), hour % 2 == 0 ? open : 0.06 * open, 0.03 * open) << hour;
    const std::optional<PerezSky> sky = perez_sky(weather.hours[hour].moment, weather.hours[hour].irradiance);
    const double sun = sky ? kLuminousEfficacy * sky->direct * sky->shape.sun.y : 0;
    EXPECT_NEAR(year.sun[hour], sun, 1e-3 * sun) << "that of the first state";
  }
}

/// A box of 1 m without its south side, where slats of 8 cm are, 4 cm apart.
SceneDescription box_behind_slats() {
  SceneDescription d;
  d.materials.resize(1);
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  add_quad(d, {0, 0, 0}, z, x);
  add_quad(d, y, x, z);
  add_quad(d, {0, 0, 0}, x, y);
  add_quad(d, {0, 0, 0}, y, z);
  add_quad(d, x, z, y);
  for (int i = 0; i < 25; ++i) add_quad(d, Vec3{0, 0.04f * static_cast<float>(i), 1}, Vec3{0, -0.03f, 0.075f}, x);
  return d;
}

TEST(FindState, IsUnbiasedBehindSlats) {
  WeatherYear weather;
  WeatherHour hour;
  hour.moment = {3, 21, 12, kLatitude, 0, 0};
  hour.irradiance = {0, 200};
  weather.hours = {hour};
  const YearModel model(weather, "", 145, kGround, 7.5);
  Sensors sensors;
  for (const float at : {0.3f, 0.6f}) sensors.add({0.5f, 0.5f, at}, {0, 1, 0});
  const Scene plain(box_behind_slats());
  const YearScene sky = under_sky(plain, model);
  RenderSettings asked;
  asked.noise_target = 0.02;
  const YearWatch wait{[](Job& job, YearProgress) { job.wait(); }, nullptr};
  const auto found = find_state(plain, sky, sensors, false, model, asked, wait);
  ASSERT_TRUE(found);
  // Paths under the same patches, all of radiance 1.
  asked.noise_target = 0;
  asked.integrator = Integrator::path;
  asked.samples = 1 << 15;
  Job job(sky.scene, sky.tracer, sensor_settings(asked), nullptr, end_of_sensors(),
          std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
  job.wait();
  const Measurement m = measurement_of(sensors, job.film(), *sky.scene);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    double sum = 0;
    for (std::size_t patch = 0; patch < model.patches.size(); ++patch)
      sum += found->state.coefficients.sky.at(i, patch).g;
    const double error = std::hypot(m.relative_error[i], found->relative_error[i]);
    EXPECT_NEAR(sum / m.irradiance[i].g, 1, 3 * error) << i;
    EXPECT_LT(error, 0.04) << i;
  }
}

/// Finds coefficients; returns the shares of the work that were told to be done.
std::vector<double> told_shares(const SceneDescription& scene, const Sensors& sensors, bool on_surfaces,
                                const RenderSettings& asked, std::uint32_t& rounds) {
  const YearModel model(some_hours(), "", 145, kGround, 60);
  const Scene plain(scene);
  std::vector<double> done;
  const YearWatch watch = recording(done);
  rounds = find_state(plain, under_sky(plain, model), sensors, on_surfaces, model, asked, watch)->rounds;
  return done;
}

/// Nothing is smooth, so the sun has no images. Photons give sensors on surfaces those that it has.
TEST(FindState, TellsTheEndOfItsWork) {
  Sensors sensors;
  sensors.add({0.5f, 0, 0.5f}, {0, 1, 0});
  for (const bool on_surfaces : {true, false}) {
    RenderSettings asked;
    asked.samples = 4;
    std::uint32_t rounds = 0;
    const std::vector<double> done = told_shares(ground_alone(), sensors, on_surfaces, asked, rounds);
    EXPECT_EQ(rounds, 2u);
    EXPECT_TRUE(std::is_sorted(done.begin(), done.end())) << on_surfaces;
    EXPECT_EQ(done.back(), 1) << on_surfaces;
  }
}

TEST(FindState, ProgressDoesNotGoBackAsMoreRoundsAreFoundToBeNeeded) {
  Sensors sensors;
  sensors.add({0.5f, 0.5f, 0.5f}, {0, 1, 0});
  RenderSettings asked;
  asked.noise_target = 0.2;
  asked.photons = 2000;
  asked.gather = 16;
  std::uint32_t rounds = 0;
  const std::vector<double> done = told_shares(box_behind_slats(), sensors, false, asked, rounds);
  EXPECT_GT(rounds, 2u);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.back(), 1);
}

TEST(CoefficientMean, KnowsTheSpreadOfItsParts) {
  const WeatherYear weather = some_hours();
  const Model model(weather, 145, 30);
  CoefficientMean mean(model.sky, model.grid);
  DaylightCoefficients one;
  one.sky = {2, 146, std::vector<RGB>(2 * 146, RGB(1.0f))};
  one.suns = {2, model.grid.places().size(), std::vector<RGB>(2 * model.grid.places().size())};
  mean.add(one);
  EXPECT_EQ(mean.relative_error()[0], 0);
  DaylightCoefficients other = one;
  for (std::size_t patch = 0; patch < 146; ++patch) other.sky.value[patch] = RGB(3.0f);
  mean.add(other);
  // Two values, 1 and 3, have the mean 2 and the standard error 1.
  EXPECT_NEAR(mean.relative_error()[0], 0.5 * student_factor(1), 1e-3);
  EXPECT_NEAR(mean.relative_error()[1], 0, 1e-3);
  EXPECT_EQ(mean.mean().sky.at(0, 9).g, 2);
}

TEST(CoefficientMean, DoesNotKnowTheErrorOfLightThatNoPartFound) {
  const WeatherYear weather = some_hours();
  const Model model(weather, 145, 30);
  CoefficientMean mean(model.sky, model.grid);
  DaylightCoefficients dark;
  dark.sky = {1, 146, std::vector<RGB>(146)};
  dark.suns = {1, model.grid.places().size(), std::vector<RGB>(model.grid.places().size())};
  for (int part = 0; part < 2; ++part) mean.add(dark);
  EXPECT_TRUE(std::isinf(mean.relative_error()[0]));
}

}  // namespace
}  // namespace glowworm
