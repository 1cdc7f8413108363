// Skies of the command line: their light on the ground, their shape, the sun's place, and weather files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "import/daylight.h"
#include "import/sky_text.h"
#include "import/weather.h"
#include "scene/environment.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

SceneDescription under(const std::string& sky) {
  SceneDescription d = floor_description();
  add_sky(sky, 0, d);
  return d;
}

TEST(Sky, CieSkiesHaveTheIlluminanceAndTheGradationOfTheNorm) {
  for (int type = 1; type <= 16; ++type) {
    const SkyModel sky = *under("cie:" + std::to_string(type) + ",40,120,12000,0.5").environment->sky;
    EXPECT_NEAR(horizontal_irradiance(sky) * kLuminousEfficacy, 12'000, 0.5) << type;
    EXPECT_NEAR(sky.ground * M_PI * kLuminousEfficacy, 6000, 0.5) << type;
    EXPECT_EQ(sky_radiance(sky, {0, -0.001f, 1}), sky.ground) << "just below the horizon";
  }
  const auto ratio = [](int type, Vec3 a, Vec3 b) {
    const SkyModel sky = *under("cie:" + std::to_string(type) + ",30,180").environment->sky;
    return sky_radiance(sky, a) / sky_radiance(sky, b);
  };
  const Vec3 zenith{0, 1, 0}, horizon = normalize({1, 1e-4f, 0}), sun = sky_direction(30, 180);
  EXPECT_NEAR(ratio(16, zenith, horizon), 3, 1e-3) << "overcast: three times as bright";
  EXPECT_NEAR(ratio(5, zenith, horizon), 1, 1e-5) << "uniform";
  EXPECT_NEAR(ratio(1, zenith, horizon), 1 + 4 * std::exp(-0.7), 1e-3);
  // Type 12: the sun's place against the mirrored one, by the indicatrix alone.
  const Vec3 mirrored = sky_direction(30, 0);
  const auto indicatrix = [](double chi) {
    return 1 + 10 * (std::exp(-3 * chi) - std::exp(-3 * M_PI / 2)) + 0.45 * std::cos(chi) * std::cos(chi);
  };
  EXPECT_NEAR(ratio(12, sun, mirrored) / (indicatrix(0) / indicatrix(2 * M_PI / 3)), 1, 1e-3);
}

TEST(Sky, SamplesGiveTheIrradianceOnTheGround) {
  for (const char* name : {"cie:1", "cie:12,30,200", "cie:15,70,90", "perez:700,100,6,21,10,48,11,1"}) {
    SceneDescription d = under(name);
    d.lights.clear();
    const Scene scene(std::move(d));
    const double expected = horizontal_irradiance(*scene.environment()->sky);
    double sum = 0;
    constexpr int kSide = 200;
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const LightSample s = sample_light(scene, {0, 0, 0}, 0.5f, {(i + 0.5f) / kSide, (j + 0.5f) / kSide});
        if (s.pdf > 0) sum += luminance(s.radiance) * std::max(s.direction.y, 0.0f) / s.pdf / (kSide * kSide);
      }
    EXPECT_NEAR(sum, expected, 0.005 * expected) << name;
  }
}

TEST(Sky, SunStandsWhereAlmanacsHaveIt) {
  // Berlin at the solstice; Sydney in December, when the sun is in the north. NOAA's solar calculator gives these.
  const SunPlace berlin = sun_place({6, 21, 12, 52.52, 13.40, 1});
  EXPECT_NEAR(berlin.altitude, 60.9, 0.5);
  EXPECT_NEAR(berlin.azimuth, 176, 3);
  const SunPlace sydney = sun_place({12, 21, 12, -33.87, 151.2, 10});
  EXPECT_NEAR(sydney.altitude, 79.6, 0.6);
  EXPECT_TRUE(sydney.azimuth < 20 || sydney.azimuth > 340) << sydney.azimuth;
  const SunPlace morning = sun_place({3, 21, 8, 0, 0, 0});
  EXPECT_NEAR(morning.azimuth, 90, 2);
}

TEST(Sky, PerezFollowsTheMeasuredIrradiance) {
  const SceneDescription clear = under("perez:850,80,6,21,12,40,0,0"), overcast = under("perez:0,150,6,21,12,40,0,0");
  ASSERT_EQ(clear.lights.size(), 1u);
  EXPECT_TRUE(overcast.lights.empty());
  // Global illuminance over global irradiance lies near 100 to 130 lm/W.
  const SkyModel& sky = *clear.environment->sky;
  const double lux =
      kLuminousEfficacy * (horizontal_irradiance(sky) + luminance(clear.lights[0].intensity) * sky.sun.y);
  const double watts = 80 + 850 * sky.sun.y;
  EXPECT_GT(lux / watts, 95);
  EXPECT_LT(lux / watts, 130);
  // A clear sky is brighter at the horizon than across from the sun, an overcast one at the zenith.
  const Vec3 away = sky_direction(60, 0);
  EXPECT_GT(sky_radiance(sky, sky.sun), 3 * sky_radiance(sky, away));
  const SkyModel& grey = *overcast.environment->sky;
  EXPECT_GT(sky_radiance(grey, {0, 1, 0}), 1.5f * sky_radiance(grey, sky_direction(3, 0)));
  EXPECT_THROW(under("perez:0,150,6,21,0,40,0,0"), Error) << "midnight";
  EXPECT_THROW(under("perez:0,0,6,21,12,40,0,0"), Error);
}

/// The header of a weather file of Munich.
std::string weather_header(int records_per_hour) {
  std::string text = "LOCATION,Munich,-,DEU,TEST,108660,48.13,11.70,1.0,529.0\n";
  for (int i = 2; i <= 7; ++i) text += "HEADER " + std::to_string(i) + "\n";
  return text + "DATA PERIODS,1," + std::to_string(records_per_hour) + ",Data,Sunday, 1/ 1,12/31\n";
}

/// A record of a weather file.
std::string weather_record(int month, int day, int hour, int minute, const std::string& direct, int diffuse) {
  return "1999," + std::to_string(month) + "," + std::to_string(day) + "," + std::to_string(hour) + "," +
         std::to_string(minute) + ",?9?9,20,10,50,95000,1000,1300,350,600," + direct + "," + std::to_string(diffuse) +
         ",0,0\n";
}

TEST(Sky, ReadsAnHourOfAWeatherFile) {
  std::string text = weather_header(1);
  for (int hour = 1; hour <= 24; ++hour) text += weather_record(6, 21, hour, 60, std::to_string(10 * hour), 5 * hour);
  const WeatherHour noon = parse_weather_hour(text, "a.epw", 6, 21, 12);
  EXPECT_EQ(noon.irradiance.direct_normal, 120);
  EXPECT_EQ(noon.irradiance.diffuse_horizontal, 60);
  EXPECT_EQ(noon.moment.hour, 11.5);
  EXPECT_NEAR(noon.moment.latitude, 48.13, 1e-9);
  EXPECT_EQ(noon.moment.zone, 1);
  EXPECT_THROW(parse_weather_hour(text, "a.epw", 6, 22, 12), Error);
  EXPECT_THROW(parse_weather_hour("no weather\n", "a.epw", 6, 21, 12), Error);
  for (std::size_t size = 0; size + 2 < text.size(); ++size)
    EXPECT_THROW(parse_weather_hour(text.substr(0, size), "a.epw", 6, 21, 24), Error) << size;
}

TEST(Sky, ReadsWeatherFilesOfManyHands) {
  const std::string plain = weather_header(1) + weather_record(6, 21, 12, 60, "700", 120);
  std::string spaces, quoted = plain;
  for (const char c : plain) spaces += c == ',' ? std::string(", ") : std::string(1, c);
  quoted.replace(quoted.find("Munich"), 6, "\"Munich, centre\"");
  std::string crlf;
  for (const char c : plain) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (const std::string& text :
       {plain, spaces, quoted, crlf, "\xef\xbb\xbf" + plain, plain.substr(0, plain.size() - 1)}) {
    const WeatherHour noon = parse_weather_hour(text, "a.epw", 6, 21, 12);
    EXPECT_EQ(noon.irradiance.direct_normal, 700);
    EXPECT_EQ(noon.irradiance.diffuse_horizontal, 120);
    EXPECT_EQ(noon.moment.latitude, 48.13);
  }
}

TEST(Sky, SumsTheRecordsOfAnHour) {
  std::string text = weather_header(4);
  for (int hour = 11; hour <= 13; ++hour)
    for (int i = 1; i <= 4; ++i) text += weather_record(6, 21, hour, 15 * i, std::to_string(100 + i), 10 * i);
  const WeatherHour noon = parse_weather_hour(text, "a.epw", 6, 21, 12);
  EXPECT_EQ(noon.irradiance.direct_normal, 410);
  EXPECT_EQ(noon.irradiance.diffuse_horizontal, 100);
  text.resize(text.find("1999,6,21,12,45"));
  try {
    parse_weather_hour(text, "a.epw", 6, 21, 12);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("a.epw:8: says 4 records an hour"));
  }
  EXPECT_THROW(parse_weather_hour(weather_header(0), "a.epw", 6, 21, 12), Error);
}

TEST(Sky, HasDawnsAndSunsInBlackSkies) {
  // By these formulas the sun rises at 8:06 in Munich at the winter solstice, so that hour 8 is dark
  // and hour 9 begins in the dark.
  const std::string text = weather_header(1) + weather_record(12, 21, 8, 60, "0", 3) +
                           weather_record(12, 21, 9, 60, "3", 12) + weather_record(12, 21, 12, 60, "700", 0);
  const auto under_hour = [&](int hour) {
    const WeatherHour h = parse_weather_hour(text, "a.epw", 12, 21, hour);
    SceneDescription d;
    add_perez_sky(h.moment, h.irradiance, 0.2, d);
    return d;
  };
  EXPECT_GT(parse_weather_hour(text, "a.epw", 12, 21, 9).moment.hour, 8.5);
  EXPECT_LT(parse_weather_hour(text, "a.epw", 12, 21, 9).moment.hour, 8.56);
  for (const int hour : {8, 9}) {
    const SceneDescription dim = under_hour(hour);
    const double lux = kLuminousEfficacy * horizontal_irradiance(*dim.environment->sky);
    EXPECT_GT(lux, 60 * (hour == 8 ? 3 : 12)) << hour;
    EXPECT_LT(lux, 160 * (hour == 8 ? 3 : 12)) << hour;
  }
  EXPECT_TRUE(under_hour(8).lights.empty()) << "the sun is below the horizon";
  const SceneDescription bare = under_hour(12);
  EXPECT_EQ(sky_radiance(*bare.environment->sky, {0, 1, 0}), 0);
  EXPECT_GT(sky_radiance(*bare.environment->sky, {0, -1, 0}), 0) << "the ground reflects the sun";
  ASSERT_EQ(bare.lights.size(), 1u);
  EXPECT_GT(bare.lights[0].intensity.g * kLuminousEfficacy, 60 * 700);
}

TEST(WeatherYear, ReadsAllHours) {
  std::string text = weather_header(2);
  for (int day = 20; day <= 21; ++day)
    for (int hour = 1; hour <= 24; ++hour)
      for (const int minute : {30, 60}) text += weather_record(6, day, hour, minute, std::to_string(hour), 5);
  const WeatherYear year = parse_weather_year("\xef\xbb\xbf" + text, "a.epw");
  ASSERT_EQ(year.hours.size(), 48u);
  EXPECT_EQ(year.hours[30].hour, 7);
  EXPECT_EQ(year.hours[30].moment.day, 21);
  EXPECT_EQ(year.hours[30].moment.hour, 6.5);
  EXPECT_EQ(year.hours[30].irradiance.direct_normal, 14);
  EXPECT_EQ(year.hours[30].irradiance.diffuse_horizontal, 10);
  for (const int hour : {1, 5, 20, 24}) {
    const WeatherHour one = parse_weather_hour(text, "a.epw", 6, 21, hour),
                      same = year.hours[static_cast<std::size_t>(23 + hour)];
    EXPECT_EQ(one.moment.hour, same.moment.hour) << "the sun at the horizon, too";
    EXPECT_EQ(one.irradiance.direct_normal, same.irradiance.direct_normal);
    EXPECT_EQ(one.hour, same.hour);
  }
  text.resize(text.find("1999,6,21,7,60"));
  EXPECT_THROW(parse_weather_year(text, "a.epw"), Error) << "an hour lacks a record";
}

TEST(WeatherYear, HasLeapDaysAndEmptyLines) {
  const std::string text =
      weather_header(1) + weather_record(2, 29, 12, 60, "500", 100) + weather_record(3, 1, 12, 60, "500", 100) + "\n\n";
  const WeatherYear year = parse_weather_year(text, "a.epw");
  ASSERT_EQ(year.hours.size(), 2u);
  EXPECT_EQ(year.hours[0].moment.day, 29);
  EXPECT_NEAR(sun_place(year.hours[0].moment).altitude, sun_place(year.hours[1].moment).altitude, 0.5);
  EXPECT_THROW(parse_weather_year(weather_header(1) + weather_record(2, 30, 25, 60, "5", 1), "a.epw"), Error);
  EXPECT_THROW(parse_weather_year(weather_header(1), "a.epw"), Error);
}

TEST(WeatherYear, SaysWhatDoesNotFit) {
  // The records have 600 W/m2 of global irradiance; the sun stands some 64 degrees high.
  const auto notes_of = [](const std::string& records) {
    const WeatherYear year = parse_weather_year(weather_header(1) + records, "a.epw");
    std::string all;
    for (const std::string& note : year.notes) all += note + "\n";
    return all;
  };
  EXPECT_THAT(notes_of(weather_record(6, 21, 12, 60, "700", 120)),
              testing::AllOf(HasSubstr("in 1 hours global"), HasSubstr("06-21 hour 12"), HasSubstr("has 1 hours")));
  EXPECT_THAT(notes_of(weather_record(6, 21, 12, 60, "535", 120)), testing::Not(HasSubstr("global")));
  EXPECT_THAT(notes_of(weather_record(6, 21, 2, 60, "0", 8)), HasSubstr("1 hours have light, but no sun"));
  EXPECT_THROW(notes_of(weather_record(6, 21, 12, 60, "9999", 120)), Error);
}

TEST(Sky, HasLightWhereDiffuseIrradianceIsMoreThanTheModelKnows) {
  // A sun of a degree above the horizon, in a sky as bright as at noon.
  const SceneDescription d = under("perez:0,103,3,21,6.5,48,0,0");
  const double level = horizontal_irradiance(*d.environment->sky) * kLuminousEfficacy;
  EXPECT_GT(level, 60 * 103);
  EXPECT_LT(level, 160 * 103);
  EXPECT_GT(sky_radiance(*d.environment->sky, {0, 1, 0}), 0);
}

TEST(Sky, RefusesOtherTexts) {
  for (const char* bad : {"", "cie:", "cie:0", "cie:17", "cie:1.5", "cie:1,2", "cie:1,-5,0", "cie:1,5,0,-1", "sunny",
                          "perez:1,2,3", "perez:1,2,13,1,12,0,0,0", "epw:", "epw:a.epw", "epw:a.epw,6,21,25"})
    EXPECT_THROW(check_sky(bad), Error) << bad;
  EXPECT_NO_THROW(check_sky("epw:a,b.epw,6,21,12,0.3"));
}

}  // namespace
}  // namespace glowworm
