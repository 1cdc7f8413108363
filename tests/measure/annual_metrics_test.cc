// Metrics of years that are made by hand.
#include "measure/annual_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "core/error.h"
#include "measure/year_files.h"

namespace glowworm {
namespace {

/// The hours of `days` days in June.
std::vector<WeatherHour> hours_of(int days) {
  std::vector<WeatherHour> out;
  for (int day = 1; day <= days; ++day)
    for (int hour = 1; hour <= 24; ++hour) {
      WeatherHour h;
      h.moment.month = 6;
      h.moment.day = day;
      h.hour = hour;
      out.push_back(h);
    }
  return out;
}

TEST(AnnualMetrics, CountOccupiedHours) {
  // From 8 to 18 a sensor rises from 100 lx by 100 lx an hour; at night it has more than ever.
  const std::vector<WeatherHour> hours = hours_of(2);
  const std::vector<std::uint8_t> occupied = occupied_hours("8-18", hours);
  EXPECT_EQ(std::accumulate(occupied.begin(), occupied.end(), 0), 20);
  Year year;
  year.sensors = 1;
  year.hours = hours.size();
  for (const WeatherHour& h : hours) {
    const bool by_day = h.hour > 8 && h.hour <= 18;
    const auto step = static_cast<float>(h.hour - 8);
    year.total.push_back(by_day ? 100 * step : 1e6f);
    year.sun.push_back(by_day && h.hour > 15 ? 1000.0f : 999.0f);
  }
  MetricLimits limits;
  limits.useful = {100, 300, 800};
  limits.sun_hours = 5;
  const std::vector<SensorMetrics> m = metrics_of(year, occupied, limits);
  EXPECT_NEAR(m[0].mean, 550, 1e-6);
  EXPECT_NEAR(m[0].autonomy, 0.8, 1e-9) << "300 lx count";
  EXPECT_NEAR(m[0].continuous, (1.0 / 3 + 2.0 / 3 + 8) / 10, 1e-6);
  EXPECT_NEAR(m[0].useful[0], 0, 1e-9);
  EXPECT_NEAR(m[0].useful[1], 0.2, 1e-9) << "100 and 200 lx";
  EXPECT_NEAR(m[0].useful[2], 0.5, 1e-9) << "300 to 700 lx";
  EXPECT_NEAR(m[0].useful[3], 0.3, 1e-9) << "800 lx and more";
  EXPECT_EQ(m[0].sun_hours, 6);
  const std::vector<std::uint32_t> chosen = {0};
  const std::vector<float> weight = {1};
  EXPECT_EQ(metrics_of_zone(m, chosen, weight, limits).sun_exposure, 1);
  limits.sun_hours = 6;
  EXPECT_EQ(metrics_of_zone(m, chosen, weight, limits).sun_exposure, 0) << "more than so many hours";
}

TEST(AnnualMetrics, OfZonesAreSharesOfArea) {
  std::vector<SensorMetrics> m(3);
  m[0].autonomy = 0.5, m[1].autonomy = 0.49, m[2].autonomy = 1;
  m[0].sun_hours = 251, m[1].sun_hours = 250;
  m[0].useful[2] = 1;
  const std::vector<std::uint32_t> all = {0, 1, 2}, two = {0, 1};
  const std::vector<float> weight = {2, 1, 1};
  EXPECT_NEAR(metrics_of_zone(m, all, weight).spatial_autonomy, 0.75, 1e-9);
  EXPECT_NEAR(metrics_of_zone(m, all, weight).sun_exposure, 0.5, 1e-9);
  EXPECT_NEAR(metrics_of_zone(m, two, weight).spatial_autonomy, 2.0 / 3, 1e-9);
  EXPECT_NEAR(metrics_of_zone(m, all, weight).mean.useful[2], 0.5, 1e-9);
}

TEST(AnnualMetrics, SimplifiedGlareIsWienolds) {
  EXPECT_NEAR(simplified_glare(0), 0.184, 1e-9);
  EXPECT_NEAR(simplified_glare(3472.7), 0.4, 1e-4);
}

TEST(Schedule, IsReadFromTextFiles) {
  using testing::ElementsAre;
  EXPECT_THAT(parse_schedule("# blinds\n0\n1\n2", "s", 3, 2), ElementsAre(0, 1, 2));
  EXPECT_THAT(parse_schedule("\xef\xbb\xbfmonth,day,hour,state\r\n1,1,0.5,1\r\n1,1,1.5,0\r\n", "s", 2, 1),
              ElementsAre(1, 0));
  EXPECT_THROW(parse_schedule("0\n1\n", "s", 3, 1), Error);
  EXPECT_THROW(parse_schedule("0\n2\n", "s", 2, 1), Error);
  EXPECT_THROW(parse_schedule("0\n0.5\n", "s", 2, 1), Error);
  for (const char* bad : {"", "8", "18-8", "8-25", "8.5-9", "a-b"})
    EXPECT_THROW(occupied_hours(bad, hours_of(1)), Error) << bad;
}

TEST(RatedBox, HoldsItsSensors) {
  const RatedBox zone = parse_rated_box("south,4,0,2,0,3,1");
  EXPECT_EQ(zone.name, "south");
  EXPECT_TRUE(zone.contains({1, 1, 1.5}));
  EXPECT_FALSE(zone.contains({1, 1, 2.5}));
  for (const char* bad : {"", "a", "a,1,2,3", ",0,0,0,1,1,1", "a,0,0,0,1,1,x"})
    EXPECT_THROW(parse_rated_box(bad), Error) << bad;
}

}  // namespace
}  // namespace glowworm
