// Glare of views over a year against pictures of single hours, and the sun's mirror images by hand.
#include "measure/view_year.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "measure/annual_metrics.h"
#include "measure/measurement.h"
#include "measure/sky_rays.h"
#include "measure/year_watch.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

const YearWatch kWait{[](Job& job, YearProgress) { job.wait(); }, nullptr};

constexpr double kReflectanceOutside = 0.2, kNorth = 48;
constexpr std::uint32_t kPixelsOfView = 40;

/// A room of 4 x 3 x 5 m with an opening towards the south (z), in front of a ground.
SceneDescription room_with_opening(const Material& floor = {}) {
  SceneDescription d;
  d.materials = {{}, floor};
  const Vec3 x{4, 0, 0}, y{0, 3, 0}, z{0, 0, 5};
  add_quad(d, {0, 0, 0}, z, x, 1);
  add_quad(d, y, x, z);
  add_quad(d, {0, 0, 0}, x, y);
  add_quad(d, {0, 0, 0}, y, z);
  add_quad(d, x, z, y);
  // The south wall around the opening.
  add_quad(d, {0, 0, 5}, {0, 0.9f, 0}, x);
  add_quad(d, {0, 1.9f, 5}, {0, 1.1f, 0}, x);
  return d;
}

WeatherHour hour_of(int month, int day, double moment, double direct, double diffuse) {
  WeatherHour h;
  h.moment = {month, day, moment, kNorth, 0, 0};
  h.hour = static_cast<int>(std::ceil(moment));
  h.irradiance = {direct, diffuse};
  return h;
}

WeatherYear three_hours() {
  WeatherYear out;
  out.hours = {hour_of(12, 21, 11.5, 600, 80), hour_of(3, 21, 14.5, 700, 120), hour_of(6, 21, 10.5, 0, 250)};
  return out;
}

Camera fisheye_at(Vec3 eye, Vec3 target) {
  Camera camera = look_at(eye, target, {0, 1, 0}, 90);
  camera.name = "eye";
  camera.kind = CameraKind::fisheye;
  camera.half_extent = half_extent_of(CameraKind::fisheye, 180);
  return camera;
}

/// What a picture of an hour alone is rated as. Its mirrors do not show the sun.
Glare glare_of_hour(SceneDescription d, const Camera& camera, const WeatherHour& hour, std::uint32_t samples = 8,
                    std::uint32_t gather = 64) {
  add_perez_sky(hour.moment, hour.irradiance, kReflectanceOutside, d);
  d.cameras.push_back(camera);
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  RenderSettings s;
  s.width = s.height = static_cast<int>(kPixelsOfView);
  s.samples = samples;
  s.gather = gather;
  s.photons = 100'000;
  s.camera = camera.name;
  s.filter = Filtering::off;
  Job job(scene, tracer, s);
  job.wait();
  GlarePicture picture;
  picture.width = picture.height = static_cast<int>(kPixelsOfView);
  for (std::size_t i = 0; i < job.film().pixel_count(); ++i)
    picture.luminance.push_back(illuminance(job.film().radiance(i, false)));
  std::vector<GlareSource> suns;
  for (const Light& light : scene->lights())
    suns = sources_of_sun(*tracer, scene->camera(camera.name), {}, -light.direction, light.intensity);
  return rate_glare(picture, suns);
}

TEST(SlowRateViews, AgreesWithPicturesOfSingleHours) {
  const WeatherYear weather = three_hours();
  const YearModel model(weather, "", 145, kReflectanceOutside, 7.5);
  // One faces the window, and the sun at noon in winter; one faces a wall.
  const std::vector<Camera> views = {fisheye_at({2, 1.2f, 2.5f}, {2, 1.3f, 5}),
                                     fisheye_at({2, 1.2f, 2.5f}, {0, 1.2f, 3})};
  std::vector<ViewYear> found(2, ViewYear(3));
  const std::vector<std::uint32_t> hours{0, 1, 2};
  ASSERT_TRUE(rate_views(Scene(room_with_opening()), views, kPixelsOfView, model, hours, {}, kWait, found));
  for (std::size_t view = 0; view < 2; ++view)
    for (std::size_t hour = 0; hour < 3; ++hour) {
      const Glare alone = glare_of_hour(room_with_opening(), views[view], weather.hours[hour]);
      EXPECT_NEAR(found[view].illuminance[hour], alone.vertical_illuminance, 0.04 * alone.vertical_illuminance)
          << view << ' ' << hour;
      EXPECT_NEAR(found[view].dgp[hour], alone.dgp, 0.02) << view << ' ' << hour;
      if (view == 1) {
        EXPECT_LT(alone.dgp, 0.9) << "no bound of the index hides a difference";
      }
    }
  EXPECT_GT(found[0].dgp[0], found[1].dgp[0] + 0.05) << "the sun in the eye";
}

/// Floors between a mirror and a dull metal show the sun of each hour, though their lobes are narrower than the
/// distance of the SunGrid's places.
class SlowPolishedFloor : public testing::Test {
 protected:
  /// Low above the floor, which mirrors the sun through the opening.
  const Camera view_ = fisheye_at({2, 0.5f, 3.2f}, {2, 0.3f, 5});
  WeatherYear weather_;

  SlowPolishedFloor() {
    // The sun stands between the places of the grid.
    for (const double moment : {10.8, 11.8, 12.3}) weather_.hours.push_back(hour_of(3, 21, moment, 700, 100));
    weather_.hours.push_back(hour_of(4, 3, 11.7, 700, 100));
  }

  static SceneDescription room(float alpha) {
    Material metal;
    metal.kind = MaterialKind::conductor;
    metal.use_reflectance = true;
    metal.roughness_u.value = metal.roughness_v.value = alpha;
    return room_with_opening(metal);
  }

  ViewYear year(float alpha, const std::vector<std::uint32_t>& hours) const {
    const YearModel model(weather_, "", 145, kReflectanceOutside, 7.5);
    std::vector<ViewYear> found(1, ViewYear(weather_.hours.size()));
    RenderSettings quick;
    quick.photons = 100'000;
    quick.gather = 16;
    rate_views(Scene(room(alpha)), std::span(&view_, 1), kPixelsOfView, model, hours, quick, kWait, found);
    return found[0];
  }
};

TEST_F(SlowPolishedFloor, AgreesWithPicturesOfSingleHours) {
  for (const auto& [alpha, hour] : {std::pair(0.03f, 0u), {0.09f, 3u}}) {
    const ViewYear found = year(alpha, {hour});
    const Glare alone = glare_of_hour(room(alpha), view_, weather_.hours[hour], 512, 8);
    EXPECT_NEAR(found.illuminance[hour], alone.vertical_illuminance, 0.04 * alone.vertical_illuminance) << alpha;
    EXPECT_NEAR(found.dgp[hour], alone.dgp, 0.02 * alone.dgp) << alpha;
  }
}

/// Samples of a picture hardly find narrower lobes, so these are compared with a mirror.
TEST_F(SlowPolishedFloor, TendsToAMirror) {
  const std::vector<std::uint32_t> hours{0, 1, 2, 3};
  const ViewYear mirror = year(0, hours);
  for (const float alpha : {0.0025f, 0.01f}) {
    const ViewYear found = year(alpha, hours);
    for (const std::uint32_t hour : hours)
      EXPECT_NEAR(found.illuminance[hour], mirror.illuminance[hour], 0.05 * mirror.illuminance[hour])
          << alpha << ' ' << hour;
  }
}

/// The spread of the results of many seeds against the errors that they state.
TEST(SlowRateViews, StatesItsNoise) {
  constexpr std::uint32_t kSeeds = 12;
  const YearModel model(three_hours(), "", 145, kReflectanceOutside, 30);
  const std::vector<Camera> views = {fisheye_at({2, 1.2f, 2.5f}, {0, 1.2f, 3})};
  const std::vector<std::uint32_t> hours{0, 1, 2};
  struct Sums {
    double value = 0, squares = 0, stated = 0;
    void add(double v, double error) {
      value += v / kSeeds;
      squares += v * v / kSeeds;
      stated += error * error / kSeeds;
    }
    double variance() const { return (squares - value * value) * kSeeds / (kSeeds - 1); }
  };
  std::array<Sums, 3> lux, dgp;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    RenderSettings quick;
    quick.seed = seed;
    quick.photons = 20'000;
    quick.gather = 8;
    quick.guiding = false;
    std::vector<ViewYear> found(1, ViewYear(3));
    ASSERT_TRUE(rate_views(Scene(room_with_opening()), views, 16, model, hours, quick, kWait, found));
    for (std::size_t i = 0; i < 3; ++i) {
      lux[i].add(found[0].illuminance[i], found[0].illuminance_error[i]);
      dgp[i].add(found[0].dgp[i], found[0].dgp_error[i]);
    }
  }
  const double widened = std::pow(student_factor(kRoundsOfView - 1), 2);
  for (const auto& of : {lux, dgp}) {
    double stated = 0, true_one = 0;
    for (const Sums& sums : of) {
      stated += sums.stated / widened / (sums.value * sums.value);
      true_one += sums.variance() / (sums.value * sums.value);
    }
    EXPECT_GT(stated, 0.4 * true_one);
    EXPECT_LT(stated, 2.5 * true_one);
  }
}

TEST(RateViews, LeavesOtherHoursAlone) {
  const YearModel model(three_hours(), "", 145, kReflectanceOutside, 30);
  const std::vector<Camera> views = {fisheye_at({2, 1.2f, 2.5f}, {2, 1.3f, 5})};
  std::vector<ViewYear> found(1, ViewYear(3));
  RenderSettings quick;
  quick.photons = 20'000;
  quick.gather = 8;
  std::vector<double> done;
  const YearWatch watch = recording(done);
  ASSERT_TRUE(
      rate_views(Scene(room_with_opening()), views, 16, model, std::vector<std::uint32_t>{1}, quick, watch, found));
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.back(), 1) << "with the hours, which no Job does";
  EXPECT_EQ(found[0].dgp[0], 0);
  EXPECT_GT(found[0].dgp[1], 0.1f);
  EXPECT_EQ(found[0].illuminance[2], 0);
}

/// By Schlick's reflectance.
SceneDescription mirror_on_the_ground(float reflectance) {
  SceneDescription d;
  Material mirror;
  mirror.kind = MaterialKind::conductor;
  mirror.use_reflectance = true;
  mirror.reflectance.value = RGB(reflectance);
  d.materials = {mirror};
  add_quad(d, {-50, 0, -50}, {0, 0, 100}, {100, 0, 0});
  return d;
}

/// A mirror on the ground shows the sun a second time.
TEST(SkyRays, MirrorsShowTheSunAtItsPlace) {
  const Scene scene(mirror_on_the_ground(0.8f));
  const Tracer tracer(scene);
  const Camera eye = fisheye_at({0, 1, 0}, {0, 1, -1});
  constexpr int kPixels = 96;
  const std::vector<SkyRay> ways = sky_rays(tracer, eye, kPixels, kPixels, 3, true);
  const float height = 0.4f;
  const Vec3 to_sun{0.1f, std::sin(height), -std::sqrt(1 - 0.01f - std::sin(height) * std::sin(height))};
  const std::vector<GlareSource> suns = sources_of_sun(tracer, eye, ways, to_sun, RGB(2.0f));
  ASSERT_EQ(suns.size(), 2u);
  EXPECT_NEAR(suns[0].illuminance, 2 * kLuminousEfficacy * suns[0].direction.z, 1e-2 * suns[0].illuminance);
  EXPECT_NEAR(suns[0].direction.y, to_sun.y, 1e-4);
  EXPECT_NEAR(suns[1].direction.y, -to_sun.y, 0.01);
  EXPECT_NEAR(std::abs(suns[1].direction.x), 0.1, 0.01);
  const double passed = 0.8 + 0.2 * std::pow(1 - double{to_sun.y}, 5);
  EXPECT_NEAR(suns[1].luminance / suns[0].luminance, passed, 0.01);
  EXPECT_NEAR(suns[1].solid_angle / suns[0].solid_angle, 1, 0.1);
}

/// A layer of absorbing air weakens the sun, twice as much on the way by a mirror on the ground.
TEST(SkyRays, ShowTheSunThroughMedia) {
  const auto suns_in = [](float absorption) {
    SceneDescription d = mirror_on_the_ground(1);
    Medium air;
    air.sigma_a = RGB(absorption);
    air.bounds = Box3{{-100, -1, -100}, {100, 3, 100}};
    d.media.push_back(air);
    d.ambient_medium = 0;
    const Scene scene(std::move(d));
    const Tracer tracer(scene);
    const Camera eye = fisheye_at({0, 1, 0}, {0, 1, -1});
    return sources_of_sun(tracer, eye, sky_rays(tracer, eye, 96, 96, 3, false), {0, 0.6f, -0.8f}, RGB(2.0f));
  };
  const std::vector<GlareSource> clear = suns_in(0), dim = suns_in(0.3f);
  ASSERT_EQ(clear.size(), 2u);
  ASSERT_EQ(dim.size(), 2u);
  EXPECT_NEAR(dim[0].luminance / clear[0].luminance, std::exp(-0.3 * 2 / 0.6), 1e-3);
  EXPECT_NEAR(dim[1].luminance / clear[1].luminance, std::exp(-0.3 * 4 / 0.6), 5e-3);
}

/// The images of the sun in both of two panes on the ground are one, with the light of both.
TEST(SkyRays, PanesShowOneImageOfTheSun) {
  const auto images_in = [](int panes) {
    SceneDescription d;
    Material glass;
    glass.kind = MaterialKind::thin_dielectric;
    glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
    d.materials = {glass};
    for (int i = 0; i < panes; ++i) add_quad(d, {-50, -0.01f * static_cast<float>(i), -50}, {0, 0, 100}, {100, 0, 0});
    const Scene scene(std::move(d));
    const Tracer tracer(scene);
    const Camera eye = fisheye_at({0, 1, 0}, {0, 1, -1});
    const float height = 0.4f;
    return sources_of_sun(tracer, eye, sky_rays(tracer, eye, 96, 96, 3, false),
                          {0, std::sin(height), -std::cos(height)}, RGB(2.0f));
  };
  const std::vector<GlareSource> one = images_in(1), two = images_in(2);
  ASSERT_EQ(one.size(), 2u);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_NEAR(two[1].solid_angle / one[1].solid_angle, 1, 0.02);
  const double r = one[1].luminance / one[0].luminance;
  EXPECT_NEAR(two[1].luminance / two[0].luminance, r + (1 - r) * (1 - r) * r / (1 - r * r), 0.02 * r);
}

/// Both lobes of a pane are followed: straight on, and mirrored.
TEST(SkyRays, PanesPassAndReflectTheSky) {
  SceneDescription d;
  Material glass;
  glass.kind = MaterialKind::thin_dielectric;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  d.materials = {glass};
  add_quad(d, {-500, -500, -1}, {1000, 0, 0}, {0, 1000, 0});
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  const std::vector<SkyRay> ways = sky_rays(tracer, fisheye_at({0, 1, 0}, {0, 1, -1}), 16, 16, 1, true);
  double straight = 0, bent = 0;
  std::size_t count = 0;
  for (const SkyRay& way : ways)
    if (way.seen.z > 0.99f) (way.bent ? bent : straight) += way.share, count += way.bent ? 0 : 1;
  ASSERT_GT(count, 0u);
  const double r = std::pow(0.5 / 2.5, 2), reflected = 2 * r / (1 + r);
  EXPECT_NEAR(straight / static_cast<double>(count), 1 - reflected, 2e-3);
  EXPECT_NEAR(bent / static_cast<double>(count), reflected, 2e-3);
}

TEST(GlareMetrics, CountOccupiedHoursAndTheTwentieth) {
  std::vector<float> dgp;
  for (int i = 0; i < 100; ++i) dgp.push_back((static_cast<float>(i) + 0.5f) / 200);
  dgp.push_back(0.9f);
  std::vector<std::uint8_t> occupied(101, 1);
  occupied[100] = 0;
  const GlareMetrics m = glare_metrics(dgp, occupied);
  // Five of a hundred hours lie above it.
  EXPECT_NEAR(m.exceeded, 0.4725, 1e-6);
  EXPECT_EQ(m.hours_above[0], 30u);
  EXPECT_EQ(m.hours_above[1], 20u);
  EXPECT_EQ(m.hours_above[2], 10u);
  EXPECT_EQ(glare_metrics(dgp, std::vector<std::uint8_t>(101, 0)).exceeded, 0);
}

}  // namespace
}  // namespace glowworm
